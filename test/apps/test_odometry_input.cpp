// SPDX-License-Identifier: BSD-3-Clause
#include "live/odometry_input.h"
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/testing/places.h>

#include <sys/stat.h>

namespace facetloc::test {
namespace {

using Clock = OdometryInput::Clock;
using std::chrono::milliseconds;

const CameraMounting kMounting{0.98, 10};

std::string lineOf(const Eigen::Isometry3d& T, const char* key, const std::optional<double>& stamp) {
  std::ostringstream out;
  out.precision(17);
  const Eigen::Quaterniond q(T.linear());
  const auto& t = T.translation();
  out << "{";
  if (stamp) out << "\"stamp\":" << *stamp << ",";
  out << "\"" << key << "\":{\"position\":[" << t.x() << "," << t.y() << "," << t.z() << "],\"quaternion\":["
      << q.x() << "," << q.y() << "," << q.z() << "," << q.w() << "]}}\n";
  return out.str();
}

Eigen::Isometry3d ahead(double x, double turn = 0) {
  Eigen::Isometry3d T(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  T.translation().x() = x;
  return T;
}

std::string faultOf(const std::string& line, const std::optional<CameraMounting>& mounting = kMounting) {
  return messageOf<std::invalid_argument>([&] { parseOdometry(line, mounting); });
}

TEST(OdometryLine, IsInTheFormOfTheStream) {
  const Eigen::Isometry3d T_w_b = ahead(1.5, 0.3), T_w_c = T_w_b * kMounting.T_b_c();
  OdometryLine line = parseOdometry(lineOf(T_w_b, "T_w_b", 12.25), kMounting);
  EXPECT_EQ(line.stamp, 12.25);
  EXPECT_TRUE(line.T_o_c.isApprox(T_w_c, 1e-12));
  line = parseOdometry(lineOf(T_w_c, "T_w_c", {}), {});
  EXPECT_FALSE(line.stamp);
  EXPECT_TRUE(line.T_o_c.isApprox(T_w_c, 1e-12));
}

TEST(OdometryLine, WithFaultsSaysThem) {
  const std::string good = "\"quaternion\":[0,0,0,1]";
  EXPECT_THAT(faultOf("1 2 3"), HasSubstr("no JSON object"));
  EXPECT_THAT(faultOf("[1,2]"), HasSubstr("no JSON object"));
  EXPECT_THAT(faultOf("{\"stamp\":1"), HasSubstr("no JSON object"));
  EXPECT_THAT(faultOf(std::string(5000, '[')), HasSubstr("no JSON object"));
  EXPECT_THAT(faultOf("{\"stamp\":1}"), HasSubstr("neither T_w_b nor T_w_c"));
  EXPECT_THAT(faultOf("{\"stamp\":\"now\",\"T_w_b\":{}}"), HasSubstr("stamp"));
  EXPECT_THAT(faultOf("{\"T_w_b\":5}"), HasSubstr("must be an object"));
  EXPECT_THAT(faultOf("{\"T_w_b\":{\"position\":[1,2,3]}}"), HasSubstr("quaternion"));
  EXPECT_THAT(faultOf("{\"T_w_b\":{\"position\":[1,2]," + good + "}}"), HasSubstr("position"));
  EXPECT_THAT(faultOf("{\"T_w_b\":{\"position\":[1,2,\"x\"]," + good + "}}"), HasSubstr("position"));
  EXPECT_THAT(faultOf("{\"T_w_b\":{\"position\":[1,2,1e999]," + good + "}}"), Not(""));
  EXPECT_THAT(faultOf("{\"T_w_b\":{\"position\":[1,2,3],\"quaternion\":[0,0,0,2]}}"), HasSubstr("rotation"));
  EXPECT_THAT(faultOf(lineOf(ahead(1), "T_w_b", 1), {}), HasSubstr("mounting"));
}

std::string faultOfLine(const std::string& line, const std::optional<CameraMounting>& mounting = kMounting) {
  return messageOf<RobotCommandError>([&] { parseRobotLine(line, mounting); });
}

std::string poseLine(const std::string& inner) { return "{\"pose\":" + inner + "}\n"; }

/** A pose of the camera, and more. */
std::string poseAt(double x, const std::string& more = "") {
  std::string line = lineOf(ahead(x), "T_w_c", {});
  line.erase(line.rfind('}'));
  return poseLine(line + more + "}");
}

TEST(RobotLine, SaysWhereTheCameraIs) {
  const auto start = parseRobotLine(poseAt(2, ",\"part\":\"attic\""), {}).start;
  ASSERT_TRUE(start);
  EXPECT_TRUE(start->T_w_c.T.isApprox(ahead(2), 1e-12));
  EXPECT_EQ(start->part, "attic");
  EXPECT_NEAR(start->T_w_c.P(0, 0), std::pow(30 * kDegree, 2), 1e-12);
  EXPECT_NEAR(start->T_w_c.P(5, 5), 1, 1e-12);

  const auto with_covariance =
      parseRobotLine(poseAt(2, ",\"covariance\":[4,0,0,0,0,0,4,0,0,0,0,4,0,0,1,9,0,0,9,0,9]"), {}).start;
  EXPECT_EQ(with_covariance->T_w_c.P(0, 0), 4);
  EXPECT_EQ(with_covariance->T_w_c.P(2, 5), 1);
  EXPECT_EQ(with_covariance->T_w_c.P(5, 2), 1);
  EXPECT_EQ(with_covariance->T_w_c.P(5, 5), 9);

  std::string of_base = lineOf(ahead(1), "T_w_b", {});
  EXPECT_TRUE(
      parseRobotLine(poseLine(of_base), kMounting).start->T_w_c.T.isApprox(ahead(1) * kMounting.T_b_c()));
  EXPECT_TRUE(parseRobotLine("{\"relocalize\":true}", {}).relocalize);
  EXPECT_TRUE(parseRobotLine(lineOf(ahead(1), "T_w_c", {}), {}).odometry);
}

TEST(RobotLine, ThatCannotBeObeyedSaysWhy) {
  EXPECT_THAT(faultOfLine(poseLine("5")), HasSubstr("must be an object"));
  EXPECT_THAT(faultOfLine(poseLine("{}")), HasSubstr("neither T_w_b nor T_w_c"));
  EXPECT_THAT(faultOfLine(poseLine(lineOf(ahead(1), "T_w_b", {})), {}), HasSubstr("mounting"));
  EXPECT_THAT(faultOfLine(poseAt(1, ",\"covariance\":[1,2]")), HasSubstr("21 numbers"));
  EXPECT_THAT(faultOfLine(poseAt(1, ",\"covariance\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]")),
              HasSubstr("positive definite"));
  EXPECT_THAT(faultOfLine(poseAt(1, ",\"part\":7")), HasSubstr("part"));
  EXPECT_THAT(faultOfLine("{\"relocalize\":1}"), HasSubstr("neither true nor false"));
}

class OdometryFiles : public InAFolder {
protected:
  std::string put(const std::string& content) const {
    std::ofstream(folder_ / "odometry") << content;
    return folder_ / "odometry";
  }
  static std::optional<Eigen::Isometry3d> at(OdometryInput& input, double stamp) {
    return input.at(stamp, Clock::now());
  }
};

TEST_F(OdometryFiles, InterpolatePosesBetweenTheirStamps) {
  OdometryInput input(put(lineOf(ahead(1), "T_w_c", 10) + "\n" + lineOf(ahead(2, 0.2), "T_w_c", 10.2) +
                          lineOf(ahead(9), "T_w_c", 11)),
                      {});
  while (!at(input, 11)) std::this_thread::yield();  // it reads on its own thread
  EXPECT_TRUE(at(input, 10)->isApprox(ahead(1), 1e-12));
  EXPECT_TRUE(at(input, 10.05)->isApprox(ahead(1.25, 0.05), 1e-9));
  EXPECT_FALSE(at(input, 9.9)) << "before the first line";
  EXPECT_FALSE(at(input, 10.5)) << "in a gap of 0.8 s";
  EXPECT_FALSE(at(input, 11.1)) << "after the last line";
  EXPECT_EQ(input.fault(), "");
}

TEST_F(OdometryFiles, SayTheFirstFaultOnceAndGoOn) {
  OdometryInput input(put(lineOf(ahead(1), "T_w_c", 1) + "nonsense\nmore of it\n" +
                          lineOf(ahead(1), "T_w_c", {}) + lineOf(ahead(2), "T_w_c", 1.1)),
                      {});
  while (!at(input, 1.1)) std::this_thread::yield();
  EXPECT_THAT(input.fault(), HasAll("line 2 is no odometry", "no JSON object"));
  EXPECT_EQ(input.fault(), "");
  EXPECT_TRUE(at(input, 1.05)->isApprox(ahead(1.5), 1e-9));
}

TEST_F(OdometryFiles, MayHoldCommandsAndNameEachFaultOfThem) {
  OdometryInput input(put(lineOf(ahead(1), "T_w_c", 1) + poseAt(3) + poseLine("1") + poseLine("2") +
                          "{\"relocalize\":true}\n" + poseAt(4) + lineOf(ahead(2), "T_w_c", 1.1)),
                      {});
  while (!at(input, 1.1)) std::this_thread::yield();
  const auto start = input.takeStart();
  ASSERT_TRUE(start);
  EXPECT_TRUE(start->start.T_w_c.T.isApprox(ahead(4))) << "the latest";
  EXPECT_EQ(start->line, 6u);
  EXPECT_FALSE(input.takeStart()) << "once";
  EXPECT_TRUE(input.takeRelocalize());
  EXPECT_FALSE(input.takeRelocalize());
  input.refuse(*start, "it is in no part");
  for (const char* fault : {"line 3", "line 4", "line 6: it is in no part"})
    EXPECT_THAT(input.fault(), HasSubstr(fault));
  EXPECT_EQ(input.fault(), "");
}

TEST_F(OdometryFiles, BeginAnewWhereTimeGoesBack) {
  OdometryInput input(put(lineOf(ahead(1), "T_w_c", 5) + lineOf(ahead(7), "T_w_c", 1)), {});
  while (!at(input, 1)) std::this_thread::yield();
  EXPECT_FALSE(at(input, 5));
}

TEST_F(OdometryFiles, ThatAreNotThereAreErrors) {
  EXPECT_THROW(OdometryInput(folder_ / "nowhere", {}), IoError);
}

TEST_F(OdometryFiles, AreOfNowWithoutStampsAndMayComeLate) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  OdometryInput input(pipe, {});
  std::ofstream out(pipe);
  const auto say = [&out](double x) { out << lineOf(ahead(x), "T_w_c", {}) << std::flush; };
  say(1);
  std::this_thread::sleep_for(milliseconds(60));
  const Clock::time_point frame = Clock::now();
  std::thread late([&] {
    std::this_thread::sleep_for(milliseconds(10));
    say(2);
  });
  const auto T = input.at(0, frame);  // waits for the line after the frame
  late.join();
  if (T) {  // else this machine was slower than its patience
    EXPECT_GT(T->translation().x(), 1);
    EXPECT_LE(T->translation().x(), 2);
  }
  EXPECT_FALSE(input.at(0, frame - std::chrono::seconds(5)));
}

class LiveOdometry : public LiveTool {
protected:
  /** The robot's, from elsewhere. */
  std::string odometry(const std::string& key) const {
    const DepthSequence recording = DepthSequence::open(sequence());
    const CameraMounting mounting = *recording.camera()->camera.mounting;
    const Eigen::Isometry3d T_o_w = ahead(-5, 1) * ahead(3);
    std::string lines;
    for (const StampedPose& pose : recording.groundTruth().poses()) {
      const Eigen::Isometry3d T_o_c = T_o_w * pose.T_w_c;
      lines += lineOf(key == "T_w_c" ? T_o_c : T_o_c * mounting.T_b_c().inverse(), key.c_str(), pose.stamp);
    }
    writeContent(folder_ / "odometry", lines);
    return folder_ / "odometry";
  }
};

TEST_F(LiveOdometry, IsReadFromAFileAndFromStandardInput) {
  for (const char* key : {"T_w_b", "T_w_c"}) {
    const std::string command = std::string(kLiveTool) + " --device '" + sequence() + "' --map '" + map() +
                                "' --headless --odometry ";
    for (const std::string& source : {odometry(key), "- < '" + odometry(key) + "'"}) {
      const ToolRun run = ok(Process({"/bin/sh", "-c", command + source}).wait());
      EXPECT_THAT(run.out, HasSubstr("with odometry")) << run.err;
      EXPECT_THAT(run.out, HasSubstr("tracking"));
    }
  }
}

TEST_F(LiveOdometry, WithoutAUseOrAFileIsAnError) {
  EXPECT_EQ(runLive({"--device", sequence(), "--headless", "--odometry", "-"}).code, kUsage);
  EXPECT_THAT(
      runLive({"--device", sequence(), "--map", map(), "--headless", "--odometry", folder_ / "nowhere"}),
      fails("nowhere: does not exist"));
}

}  // namespace
}  // namespace facetloc::test

// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "live_tool.h"
#include "outputs/pose_stream.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/testing/places.h>

#include <algorithm>
#include <arpa/inet.h>
#include <json/json.h>
#include <set>
#include <sys/socket.h>
#include <sys/time.h>

namespace facetloc::test {
namespace {

Json::Value parsed(const std::string& line) {
  Json::Value value;
  std::string errors;
  std::istringstream in(line);
  Json::CharReaderBuilder builder;
  Json::CharReaderBuilder::strictMode(&builder.settings_);
  EXPECT_TRUE(Json::parseFromStream(builder, in, &value, &errors)) << errors << line;
  return value;
}

Eigen::Isometry3d poseIn(const Json::Value& pose) {
  const auto number = [&](const char* key, int i) { return pose[key][i].asDouble(); };
  const Eigen::Quaterniond q(number("quaternion", 3), number("quaternion", 0), number("quaternion", 1),
                             number("quaternion", 2));
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.toRotationMatrix();
  T.translation() << number("position", 0), number("position", 1), number("position", 2);
  return T;
}

/** The lines of a stream without findings. */
std::vector<std::string> answersIn(const std::string& stream) {
  std::vector<std::string> lines = linesIn(stream);
  lines.erase(std::remove_if(lines.begin(), lines.end(),
                             [](const std::string& line) { return parsed(line).isMember("finding"); }),
              lines.end());
  return lines;
}

/** Compares the keys and the kinds of values with the schema. */
void expectBySchema(const Json::Value& answer) {
  static const Json::Value schema = parsed(contentOf(kStreamSchema))["$defs"]["answer"];
  std::set<std::string> wanted;
  for (const Json::Value& key : schema["required"]) wanted.insert(key.asString());
  const auto names = answer.getMemberNames();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()), wanted);
  EXPECT_THAT((std::vector<std::string>{"sure", "doubtful", "unknown"}),
              Contains(answer["state"].asString()));
  EXPECT_TRUE(answer["stamp"].isDouble());
  EXPECT_TRUE(answer["reason"].isString());
  for (const char* pose : {"T_w_c", "T_w_b"})
    if (!answer[pose].isNull()) {
      EXPECT_EQ(answer[pose]["position"].size(), 3u);
      EXPECT_EQ(answer[pose]["quaternion"].size(), 4u);
    }
  if (!answer["covariance"].isNull()) {
    EXPECT_EQ(answer["covariance"].size(), 21u);
  }
}

/** The schema and the document describe each column of results by the column's own text. */
TEST(PoseStream, SchemaAndDocumentDescribeTheColumns) {
  const Json::Value schema = parsed(contentOf(kStreamSchema))["$defs"]["answer"]["properties"];
  const std::string document = contentOf(fs::path(kStreamSchema).parent_path() / "RECORDINGS.md");
  std::size_t in_stream = 0;
  for (const ResultColumn& column : resultColumns()) {
    if (schema.isMember(column.name)) {
      ++in_stream;
      EXPECT_EQ(schema[column.name]["description"].asString(), column.text) << column.name;
    }
    const auto names = column.names();
    const std::string unit = *column.unit ? std::string(" [") + column.unit + "]" : "";
    EXPECT_THAT(document, HasSubstr("| `" + names.front() + "`" +
                                    (names.size() > 1 ? " ... `" + names.back() + "`" : "") + " | " +
                                    column.text + unit + " |"));
  }
  EXPECT_EQ(in_stream, 8u);
}

FrameResult frame() {
  FrameResult result;
  result.stamp = 1355494975.814212;
  ResultRow row;
  row.frame = "a \"strange\"\tname \\";
  row.rank = 1;
  row.model = "left";
  row.probability = 0.95;
  row.state = AnswerState::sure;
  row.T_w_c = Eigen::Isometry3d(Eigen::Translation3d(1, -2, 0.98) *
                                Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -3).normalized()));
  Matrix6d P;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) P(r, c) = 10 * std::min(r, c) + std::max(r, c);
  row.P_w_c = P;
  row.shares = ViewShares{0.7, 0.2, 0.1, 0.05};
  result.rows = {row};
  return result;
}

TEST(PoseStream, ALineIsJsonOfTheSchema) {
  const CameraMounting mounting{0.98, 10};
  const std::string line = toJson(frame(), mounting);
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  const Json::Value answer = parsed(line);
  expectBySchema(answer);
  EXPECT_NEAR(answer["stamp"].asDouble(), frame().stamp, 1e-6);
  EXPECT_EQ(answer["frame"].asString(), frame().rows[0].frame);
  EXPECT_EQ(answer["state"].asString(), "sure");
  const Eigen::Isometry3d T_w_c = poseIn(answer["T_w_c"]), T_w_b = poseIn(answer["T_w_b"]);
  EXPECT_TRUE(T_w_c.isApprox(*frame().rows[0].T_w_c, 1e-6));
  EXPECT_TRUE((T_w_b * mounting.T_b_c()).isApprox(T_w_c, 1e-6));
  EXPECT_EQ(answer["covariance"][0].asDouble(), 0);
  EXPECT_EQ(answer["covariance"][5].asDouble(), 5);
  EXPECT_EQ(answer["covariance"][6].asDouble(), 11);
  EXPECT_EQ(answer["covariance"][20].asDouble(), 55);
  EXPECT_EQ(answer["shares"]["hiding"].asDouble(), 0.2);
  EXPECT_EQ(answer["shares"]["new"].asDouble(), 0.1);
}

TEST(PoseStream, UnknownValuesAreNull) {
  FrameResult result = frame();
  EXPECT_TRUE(parsed(toJson(result, {}))["T_w_b"].isNull()) << "the mounting is unknown";
  ResultRow row;
  row.frame = "1.0";
  row.reason = "nothing agrees";
  result.rows = {row};
  const Json::Value answer = parsed(toJson(result, CameraMounting{1, 0}));
  expectBySchema(answer);
  for (const char* key : {"T_w_c", "T_w_b", "covariance", "model", "shares"})
    EXPECT_TRUE(answer[key].isNull()) << key;
  EXPECT_EQ(answer["state"].asString(), "unknown");
  EXPECT_EQ(answer["probability"].asDouble(), 0);
  EXPECT_EQ(answer["reason"].asString(), "nothing agrees");
}

TEST(PoseStream, AnAdviceIsInDegrees) {
  FrameResult result = frame();
  EXPECT_TRUE(parsed(toJson(result, {}))["next_look"].isNull());
  result.rows.front().next_look = NextLook{-EIGEN_PI / 2, 1.5, 0.7, 0.8};
  const Json::Value look = parsed(toJson(result, {}))["next_look"];
  EXPECT_NEAR(look["yaw_deg"].asDouble(), -90, 1e-4);
  EXPECT_EQ(look["ahead"].asDouble(), 1.5);
  EXPECT_EQ(look["sure"].asDouble(), 0.8);
  EXPECT_EQ(look["gain"].asDouble(), 0.7);
}

TEST(PoseStream, LinesAreInTheOrderOfTheFrames) {
  std::ostringstream out;
  PoseStream stream(out, {});
  FrameResult result = frame();
  for (const std::size_t index : {2, 0, 1, 4, 3}) {
    result.stamp = static_cast<double>(index);
    stream.put(index, result);
    if (index == 2) {
      EXPECT_THAT(out.str(), IsEmpty()) << "before the frames that it follows";
    }
    if (index == 0) {
      EXPECT_EQ(linesIn(out.str()).size(), 1u);
    }
  }
  const auto lines = linesIn(out.str());
  ASSERT_EQ(lines.size(), 5u);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(parsed(lines[i])["stamp"].asInt(), i);
}

TEST(PoseStream, AFindingHasALineOfItsOwn) {
  std::ostringstream out, err;
  Findings kept;
  const Console console{out, err, false, true, "tool", false, &kept};
  besideStream(console).find(
      {"poses.jump", Severity::doubt, "the poses jump\nhere", "look", {{"seconds", 0.2, 0.01}}});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_THAT(err.str(), HasSubstr("the poses jump")) << "a doubt, although quiet";
  ASSERT_EQ(linesIn(out.str()).size(), 1u) << out.str();
  const Json::Value finding = parsed(out.str())["finding"];
  const Json::Value schema = parsed(contentOf(kStreamSchema));
  for (const Json::Value& key : schema["$defs"]["finding"]["properties"]["finding"]["required"])
    EXPECT_TRUE(finding.isMember(key.asString())) << key;
  EXPECT_EQ(finding["id"].asString(), "poses.jump");
  EXPECT_EQ(finding["words"].asString(), "the poses jump\nhere");
  EXPECT_EQ(finding["evidence"][0]["value"].asDouble(), 0.2);
}

class StreamOfImages : public Tools {};

TEST_F(StreamOfImages, LocalizeWritesEachImageAndNothingElse) {
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{}, {"--sequence"}, {"--sequence", "--smooth"}}) {
    const ToolRun run =
        ok(runTool<localizeApp>(Arguments{map(), query(), "-o", folder_ / "results", "--stream"} + options));
    EXPECT_THAT(run.err, HasSubstr("results in"));
    const auto lines = answersIn(run.out);
    ASSERT_EQ(lines.size(), static_cast<std::size_t>(kFrames));
    const Trajectory truth = DepthSequence::readTruth(query());
    double before = -1;
    int sure = 0;
    for (const std::string& line : lines) {
      const Json::Value answer = parsed(line);
      expectBySchema(answer);
      EXPECT_GT(answer["stamp"].asDouble(), before);
      before = answer["stamp"].asDouble();
      if (answer["state"].asString() != "sure") continue;
      ++sure;
      const Eigen::Isometry3d T = *truth.at(before);
      EXPECT_LT((poseIn(answer["T_w_c"]).translation() - T.translation()).norm(), 0.1);
      EXPECT_NEAR(answer["T_w_b"]["position"][2].asDouble(), 0, 0.1) << "the base is on the floor";
    }
    EXPECT_GE(sure, 8);
  }
}

TEST_F(StreamOfImages, AnswersOfAnEarlierRunAreAlsoStreamed) {
  const std::vector<std::string> arguments = {map(), query(), "-o", folder_ / "results", "--stream"};
  const ToolRun once = runTool<localizeApp>(arguments);
  std::vector<std::string> again = arguments;
  again.emplace_back("--resume");
  const auto first = answersIn(once.out), second = answersIn(runTool<localizeApp>(again).out);
  ASSERT_EQ(second.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Json::Value a = parsed(first[i]), b = parsed(second[i]);
    for (const char* key : {"stamp", "frame", "state", "probability", "model", "covariance"})
      EXPECT_EQ(a[key], b[key]);
    for (const char* key : {"T_w_c", "T_w_b"})
      EXPECT_TRUE(poseIn(a[key]).isApprox(poseIn(b[key]), 1e-8)) << "more than files round";
  }
}

TEST_F(StreamOfImages, AnImageThatCannotBeReadHasALine) {
  const ToolRun run =
      runTool<localizeApp>({map(), withOneCorruptImage(), "-o", folder_ / "results", "--stream"});
  EXPECT_EQ(run.code, kFailed);
  const auto lines = answersIn(run.out);
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(kFrames));
  EXPECT_THAT(parsed(lines[4])["reason"].asString(), HasSubstr("not a PNG"));
}

class StreamOfACamera : public LiveTool {};

TEST_F(StreamOfACamera, NeedsAMap) {
  EXPECT_EQ(runLive({"--device", sequence(), "--stream", "--headless"}).code, kUsage);
}

/** Receives the output of a reader that publishes by datagrams, on a port of ours. */
class Datagrams {
public:
  Datagrams() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    socklen_t size = sizeof address;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    const timeval patience{1, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Datagrams() { close(socket_); }
  int port() const { return port_; }
  /** The next one; empty after a second without one. */
  std::string next() const {
    std::string bytes(4096, '\0');
    const ssize_t size = recv(socket_, bytes.data(), bytes.size(), 0);
    return size > 0 ? bytes.substr(0, static_cast<std::size_t>(size)) : std::string();
  }

private:
  int socket_;
  int port_ = 0;
};

TEST_F(StreamOfACamera, IsReadByTheExample) {
  const Datagrams datagrams;
  const std::string command = std::string(kLiveTool) + " --device '" + sequence() + "' --map '" + map() +
                              "' --headless --stream --speed 0.3 | /usr/bin/env python3 " + kReadStream +
                              " " + std::to_string(datagrams.port());
  const ToolRun run = ok(Process({"/bin/sh", "-c", command}).wait());
  EXPECT_THAT(run.out, HasSubstr(", probability "));
  const Trajectory truth = DepthSequence::readTruth(sequence());
  const CameraMounting mounting = *DepthSequence::open(sequence()).camera()->camera.mounting;
  int received = 0;
  for (std::string bytes; !(bytes = datagrams.next()).empty(); ++received) {
    const Json::Value message = parsed(bytes);
    const Eigen::Isometry3d T_w_c = poseIn(message) * mounting.T_b_c();
    const auto true_pose = truth.at(message["stamp"].asDouble());
    ASSERT_TRUE(true_pose);
    EXPECT_LT((T_w_c.translation() - true_pose->translation()).norm(), 0.1);
  }
  EXPECT_GE(received, 5);
}

}  // namespace
}  // namespace facetloc::test

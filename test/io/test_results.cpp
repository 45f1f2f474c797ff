// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/full_disk.h>

#include <cmath>
#include <stdexcept>

namespace facetloc::test {
namespace {

const Eigen::Vector3d kUpright = Eigen::Vector3d::Zero();

StampedPose poseAt(double stamp, const Eigen::Vector3d& phi = {0.1, -0.2, 0.3},
                   const Eigen::Vector3d& t = {1, 2, 3}) {
  StampedPose pose;
  pose.stamp = stamp;
  pose.T_w_c.linear() = expSO3(phi);
  pose.T_w_c.translation() = t;
  return pose;
}

TEST(Trajectory, BetweenTwoPosesTheMotionIsEven) {
  const Trajectory poses({poseAt(2, {0, 0, 0.8}, {3, 0, 0}), poseAt(1, {0, 0, 0.4}, {1, 0, 2})});
  const auto middle = poses.interpolated(1.25);
  ASSERT_TRUE(middle);
  EXPECT_LT((middle->linear() - expSO3({0, 0, 0.5})).norm(), 1e-12);
  EXPECT_LT((middle->translation() - Eigen::Vector3d(1.5, 0, 1.5)).norm(), 1e-12);
  EXPECT_EQ(poses.interpolated(1)->matrix(), poses.poses()[0].T_w_c.matrix());
  EXPECT_EQ(poses.interpolated(2)->matrix(), poses.poses()[1].T_w_c.matrix());
  EXPECT_FALSE(poses.interpolated(0.999));
  EXPECT_FALSE(poses.interpolated(2.001));
  EXPECT_FALSE(Trajectory().interpolated(1));
  const Trajectory twice({poseAt(1), poseAt(1, kUpright), poseAt(2)});  // two poses of one stamp
  EXPECT_TRUE(twice.interpolated(1.5)->matrix().allFinite());
}

TEST(Trajectory, RoundTrips) {
  const TemporaryFolder folder;
  const std::vector<StampedPose> poses = {poseAt(1305031102.175304, {3.1, 0.1, -0.2}, {1.0 / 3, -1e-7, 1e5}),
                                          poseAt(1305031102.275304)};
  writeTumTrajectory(folder / "poses.txt", poses);
  const Trajectory read = readTrajectory(folder / "poses.txt");
  ASSERT_EQ(read.poses().size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(read.poses()[i].stamp, poses[i].stamp, 1e-6);
    EXPECT_LT(boxminus(read.poses()[i].T_w_c, poses[i].T_w_c).head<3>().norm(), 1e-8);
    EXPECT_TRUE(read.poses()[i].T_w_c.translation().isApprox(poses[i].T_w_c.translation(), 1e-8));
  }
}

TEST(Trajectory, WritesExactlyEightColumns) {
  const TemporaryFolder folder;
  StampedPose identity = poseAt(0.5, kUpright, {-0.0, 1, 2});
  writeTumTrajectory(folder / "poses.txt", {identity});
  EXPECT_EQ(bytesOf(folder / "poses.txt"), "# timestamp tx ty tz qx qy qz qw\n0.500000 0 1 2 0 0 0 1\n");
}

TEST(Trajectory, RefusesToWriteNonFiniteNumbers) {
  const TemporaryFolder folder;
  EXPECT_THROW(writeTumTrajectory(folder / "poses.txt", {poseAt(NAN)}), std::invalid_argument);
  EXPECT_EQ(folder.count(), 0);
}

TEST(Trajectory, TheNearestPoseWithinTheToleranceCountsInAGap) {
  const Trajectory trajectory(
      {poseAt(2, kUpright, {2, 0, 0}), poseAt(1, kUpright, {1, 0, 0}), poseAt(1.1, kUpright, {1.1, 0, 0})});
  constexpr double kShort = 0.019;  // five of these are less than the gap of 0.1 s
  EXPECT_EQ(trajectory.at(1.01, kShort)->translation().x(), 1);
  EXPECT_EQ(trajectory.at(1.09, kShort)->translation().x(), 1.1);
  EXPECT_EQ(trajectory.at(1.019, kShort)->translation().x(), 1) << "the tolerance is meant in decimals";
  EXPECT_EQ(trajectory.at(0.99)->translation().x(), 1);
  EXPECT_EQ(trajectory.at(2.015)->translation().x(), 2);
  EXPECT_FALSE(trajectory.at(1.05, kShort));
  EXPECT_FALSE(trajectory.at(0.9));
  EXPECT_FALSE(trajectory.at(2.1));
  EXPECT_FALSE(trajectory.at(NAN));
  EXPECT_EQ(trajectory.at(1.25, 0.17)->translation().x(), 1.1) << "five times 0.17 are less than the gap";
  EXPECT_NEAR(trajectory.at(1.5, 1)->translation().x(), 1.5, 1e-9);
  EXPECT_FALSE(Trajectory().at(0));
}

TEST(Trajectory, BetweenPosesThatAreCloseInTimeTheyAreInterpolated) {
  const Trajectory trajectory({poseAt(1, kUpright, {1, 0, 0}), poseAt(1.1, kUpright, {1.1, 0, 0})});
  for (const double stamp : {1.0, 1.01, 1.05, 1.09, 1.1})
    EXPECT_NEAR(trajectory.at(stamp)->translation().x(), stamp, 1e-9);
  EXPECT_EQ(trajectory.at(0.985)->translation().x(), 1) << "before the first pose, which is near";
  EXPECT_FALSE(trajectory.at(1.13));
}

TEST(Trajectory, ReadsCommentsAndUnorderedLines) {
  const TemporaryFolder folder;
  putBytes(folder / "g.txt", "# header\n\n 2 0 0 0 0 0 0 1 # later\r\n+1e0\t0 0 0 0 0 0 -1\n");
  const Trajectory trajectory = readTrajectory(folder / "g.txt");
  ASSERT_EQ(trajectory.poses().size(), 2u);
  EXPECT_EQ(trajectory.poses()[0].stamp, 1);
  EXPECT_TRUE(trajectory.poses()[0].T_w_c.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(Trajectory, AnEmptyFileIsAnEmptyTrajectoryAndNoneIsAFault) {
  const TemporaryFolder folder;
  putBytes(folder / "g.txt", "# nothing yet\n");
  EXPECT_TRUE(readTrajectory(folder / "g.txt").empty());
  EXPECT_THAT(ioErrorOf([] { readTrajectory("no/such/file.txt"); }), HasSubstr("does not exist"));
}

constexpr const char* kHeader =
    "frame,rank,model,probability,score,m_tx,m_ty,m_tz,m_qx,m_qy,m_qz,m_qw,"
    "w_tx,w_ty,w_tz,w_qx,w_qy,w_qz,w_qw,sd_rot_deg,sd_trans_m,reason,state,part,not_in_map\n";

ResultRow hypothesis(const std::string& frame, int rank) {
  ResultRow row;
  row.frame = frame;
  row.rank = rank;
  row.model = "room, left \"side\"";
  row.probability = 1.0 / 3;
  row.score = -12.5;
  row.T_m_c.linear() = expSO3({0.1, 2.5, -0.3});
  row.T_m_c.translation() << 1, -2, 3.25;
  row.sd_rot_deg = 0.5;
  row.sd_trans_m = 0.01;
  row.state = AnswerState::doubtful;
  return row;
}

Matrix6d exampleCovariance() {
  Matrix6d P;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) P(i, j) = i == j ? 1 + i : 0.01 * (i + j) - 0.05;
  return P;
}

ResultRow noHypothesis(const std::string& frame) {
  ResultRow row;
  row.frame = frame;
  row.reason = "fewer than 6 constrained\ndegrees, \"sorry\"";
  return row;
}

std::vector<FrameResult> twoFrames() {
  FrameResult a, b;
  a.stamp = 1.5;
  a.rows = {hypothesis("1.5", 1), hypothesis("1.5", 2)};
  a.rows[0].T_w_c = Eigen::Isometry3d(Eigen::Translation3d(7, 8, 9));
  a.rows[0].P_w_c = exampleCovariance();
  a.rows[0].shares = ViewShares{0.625, 0.25, 0.125, 0.0625};
  for (ResultRow& row : a.rows) row.state = AnswerState::sure;
  a.timing = {"1.5", 10.25, 2, 3.5, 140};
  b.stamp = 2;
  b.rows = {noHypothesis("2")};
  b.timing = {"2", 1, 2, 3, 0};
  return {a, b};
}

using Results = InAFolder;

TEST_F(Results, OnlyPosesInTheWorldAreATrajectory) {
  auto frames = twoFrames();
  frames[0].rows[0].part = "attic, left";
  frames[0].rows[0].not_in_map = 0.125;
  writeResults(folder_.path(), frames, "");
  EXPECT_THAT(readTrajectory(folder_ / "poses_tum.txt").poses(), IsEmpty());
  const auto rows = readHypotheses(folder_.path());
  EXPECT_EQ(rows[0].part, "attic, left");
  EXPECT_EQ(rows[0].not_in_map, 0.125);
  EXPECT_EQ(rows[1].not_in_map, std::nullopt);
  EXPECT_TRUE(rows[0].T_w_c);
  EXPECT_EQ(rows[1].part, "");
}

TEST_F(Results, EachPartOfTheMapHasATrajectoryOfItsOwn) {
  auto frames = twoFrames();
  frames[0].rows[0].part = "../attic, left";
  frames[1] = frames[0];
  frames[1].stamp = 2;
  for (ResultRow& row : frames[1].rows) row.frame = "2", row.part = "1.25";
  frames[1].timing.frame = "2";
  writeResults(folder_.path(), frames, "");
  const auto stampsIn = [&](const char* name) {
    std::vector<double> stamps;
    const Trajectory read = readTrajectory(folder_ / name);
    for (const StampedPose& pose : read.poses()) stamps.push_back(pose.stamp);
    return stamps;
  };
  EXPECT_THAT(stampsIn("poses_tum.part-..%2fattic%2c%20left.txt"), ElementsAre(1.5));
  EXPECT_THAT(stampsIn("poses_tum.part-1.25.txt"), ElementsAre(2));
  EXPECT_THAT(stampsIn("poses_tum.txt"), IsEmpty());

  ResultsWriter goes_on(folder_.path(), "", {{"2", 2}});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "poses_tum.part-..%2fattic%2c%20left.txt")) << "not kept";
  EXPECT_THAT(stampsIn("poses_tum.part-1.25.txt"), ElementsAre(2));
  frames[1].stamp = 3;
  for (ResultRow& row : frames[1].rows) row.frame = "3";
  frames[1].timing.frame = "3";
  goes_on.append(frames[1]);
  EXPECT_THAT(stampsIn("poses_tum.part-1.25.txt"), ElementsAre(2, 3));
}

std::string errorOf(const std::string& content) {
  const TemporaryFolder folder;
  putBytes(folder / "hypotheses.csv", content);
  return ioErrorOf([&] { readHypotheses(folder.path()); });
}

TEST_F(Results, RoundTrip) {
  const auto frames = twoFrames();
  writeResults(folder_ / "a/b", frames, "min_support = 150\n");

  const auto rows = readHypotheses(folder_ / "a/b");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].frame, "1.5");
  EXPECT_EQ(rows[1].rank, 2);
  EXPECT_EQ(rows[0].model, "room, left \"side\"");
  EXPECT_NEAR(rows[0].probability, 1.0 / 3, 1e-9);
  EXPECT_EQ(rows[0].score, -12.5);
  EXPECT_LT(boxminus(rows[0].T_m_c, frames[0].rows[0].T_m_c).norm(), 1e-8);
  ASSERT_TRUE(rows[0].T_w_c);
  EXPECT_EQ(rows[0].T_w_c->translation().y(), 8);
  EXPECT_FALSE(rows[1].T_w_c);
  EXPECT_EQ(rows[0].sd_rot_deg, 0.5);
  EXPECT_EQ(rows[0].sd_trans_m, 0.01);
  EXPECT_EQ(rows[2].rank, 0);
  EXPECT_EQ(rows[2].reason, frames[1].rows[0].reason);

  EXPECT_EQ(rows[0].state, AnswerState::sure);
  EXPECT_EQ(rows[1].state, AnswerState::sure);
  EXPECT_EQ(rows[2].state, AnswerState::unknown);

  const auto covariances = readCovariances(folder_ / "a/b");
  ASSERT_EQ(covariances.size(), 1u);
  EXPECT_LT((covariances.at("1.5") - exampleCovariance()).norm(), 1e-8);

  const auto timing = readTiming(folder_ / "a/b");
  ASSERT_EQ(timing.size(), 2u);
  EXPECT_EQ(timing[0].frame, "1.5");
  EXPECT_EQ(timing[0].segment_ms, 10.25);
  EXPECT_EQ(timing[0].localize_ms, 3.5);
  EXPECT_EQ(timing[0].models, 140);

  const Trajectory poses = readTrajectory(folder_ / "a/b/poses_tum.txt");
  ASSERT_EQ(poses.poses().size(), 1u) << "only sure ones of rank 1 with a world pose";
  EXPECT_EQ(poses.poses()[0].stamp, 1.5);
  EXPECT_EQ(bytesOf(folder_ / "a/b/params.ini"), "min_support = 150\n");
}

TEST_F(Results, TheBytesAreThoseOfTheContract) {
  FrameResult frame;
  ResultRow row = hypothesis("f", 1);
  row.model = "m";
  row.T_m_c = Eigen::Translation3d(1.0 / 3, -0.0, 1e-9);
  frame.rows = {row};
  FrameResult lost;
  lost.rows = {noHypothesis("g")};
  lost.rows[0].reason = "dark, \"very\"";
  writeResults(folder_.path(), {frame, lost}, "");
  EXPECT_EQ(bytesOf(folder_ / "hypotheses.csv"),
            kHeader + std::string(
                          "f,1,m,0.333333333,-12.5,0.333333333,0,1e-09,0,0,0,1,,,,,,,,0.5,0.01,,doubtful,,\n"
                          "g,0,,,,,,,,,,,,,,,,,,,,\"dark, \"\"very\"\"\",unknown,,\n"));
}

/** Poses that are not sure are not handed to anybody who may drive by them. */
TEST_F(Results, DoubtfulPosesAreNoTrajectory) {
  auto frames = twoFrames();
  for (ResultRow& row : frames[0].rows) row.state = AnswerState::doubtful;
  writeResults(folder_.path(), frames, "");
  EXPECT_TRUE(readTrajectory(folder_ / "poses_tum.txt").poses().empty());
  EXPECT_EQ(readHypotheses(folder_.path())[0].state, AnswerState::doubtful);
  EXPECT_EQ(readCovariances(folder_.path()).size(), 1u);
}

TEST_F(Results, OlderFoldersLackTheProbabilityOfNoPlace) {
  std::string header = kHeader;
  header.erase(header.rfind(",not_in_map"), std::string(",not_in_map").size());
  const TemporaryFolder folder;
  putBytes(folder / "hypotheses.csv", header + "f,0,,,,,,,,,,,,,,,,,,,,why,unknown,\n");
  const std::vector<ResultRow> rows = readHypotheses(folder.path());
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].not_in_map, std::nullopt);
  EXPECT_THAT(errorOf(kHeader + std::string("f,0,,,,,,,,,,,,,,,,,,,,why,unknown,,1.5\n")),
              HasAll("line 2", "not_in_map is not between 0 and 1"));
}

TEST_F(Results, AWrongStateOrCovarianceIsNamed) {
  EXPECT_THAT(errorOf(kHeader + std::string("f,0,,,,,,,,,,,,,,,,,,,,why,certain,,\n")),
              HasAll("line 2", "state"));
  const TemporaryFolder folder;
  writeResults(folder.path(), twoFrames(), "");
  const std::string good = bytesOf(folder / "covariances.csv");
  putBytes(folder / "covariances.csv", good + "f" + good.substr(good.find("\n1.5,") + 4));
  EXPECT_EQ(readCovariances(folder.path()).size(), 2u);
  for (const char* first : {"nan", "-1", "x"}) {
    const std::size_t cell = good.find("\n1.5,") + 5;
    putBytes(folder / "covariances.csv", good.substr(0, cell) + first + good.substr(good.find(',', cell)));
    EXPECT_THAT(ioErrorOf([&] { readCovariances(folder.path()); }), HasSubstr("covariances.csv: line 2"));
  }
}

TEST_F(Results, SharesOfAViewAreOfTheFirstRank) {
  const TemporaryFolder folder;
  writeResults(folder.path(), twoFrames(), "");
  EXPECT_EQ(bytesOf(folder / "shares.csv"),
            "frame,explained,hiding,new,missing\n1.5,0.625,0.25,0.125,0.0625\n");
  EXPECT_EQ(readShares(folder.path()).at("1.5").missing, 0.0625);
  EXPECT_EQ(readResults(folder.path()).at("1.5").rows.front().shares->hiding, 0.25);
  putBytes(folder / "shares.csv", "frame,explained,hiding,new,missing\n1.5,0.6,0.3,0.1,1.5\n");
  EXPECT_THAT(ioErrorOf([&] { readShares(folder.path()); }), HasAll("line 2", "missing"));
  std::filesystem::remove(folder / "shares.csv");
  EXPECT_TRUE(readShares(folder.path()).empty()) << "as in folders of older versions";
}

TEST_F(Results, ColumnsAreFoundByName) {
  putBytes(folder_ / "timing.csv",
           "models,extra,localize_ms,features_ms,segment_ms,frame\r\n7,,3,2,1,\"a,b\"\r\n");
  const auto timing = readTiming(folder_.path());
  ASSERT_EQ(timing.size(), 1u);
  EXPECT_EQ(timing[0].frame, "a,b");
  EXPECT_EQ(timing[0].segment_ms, 1);
  EXPECT_EQ(timing[0].models, 7);
}

TEST_F(Results, NamesTheLineOfAFault) {
  const std::string header = kHeader;
  const std::string none = "f,0,,,,,,,,,,,,,,,,,,,,why,unknown,,\n";
  EXPECT_EQ(errorOf(header + none), "");
  EXPECT_EQ(errorOf(header), "");
  EXPECT_THAT(errorOf(""), HasSubstr("empty"));
  EXPECT_THAT(errorOf("frame,rank\nf,0\n"), HasAll("hypotheses.csv", "'reason'"));
  EXPECT_THAT(errorOf(header + none + "f,0,,,,,\n"), HasAll("line 3", "columns"));
  EXPECT_THAT(errorOf(header + "f,x,,,,,,,,,,,,,,,,,,,,why,unknown,,\n"), HasAll("line 2", "rank = 'x'"));
  EXPECT_THAT(errorOf(header + "f,-1,,,,,,,,,,,,,,,,,,,,why,unknown,,\n"), HasSubstr("negative"));
  EXPECT_THAT(errorOf(header + "f,1,m,,,,,,,,,,,,,,,,,,,why,unknown,,\n"), HasSubstr("probability"));
  EXPECT_THAT(errorOf(header + "f,1,m,1,1,0,0,0,0,0,0,2,,,,,,,,1,1,,sure,,\n"), HasSubstr("rotation"));
  EXPECT_THAT(errorOf(header + "f,1,m,1,nan,0,0,0,0,0,0,1,,,,,,,,1,1,,sure,,\n"), HasSubstr("finite"));
  EXPECT_THAT(errorOf(header + "f,1,m,1,1,0,0,0,0,0,0,1,1,,,,,,,1,1,,sure,,\n"), HasSubstr("w_ty"));
  EXPECT_THAT(errorOf(header + "f,1,m,1.5,1,0,0,0,0,0,0,1,,,,,,,,1,1,,sure,,\n"),
              HasSubstr("between 0 and 1"));
  EXPECT_THAT(errorOf(header + "f,1,m,1,1,9e6,0,0,0,0,0,1,,,,,,,,1,1,,sure,,\n"), HasSubstr("1000 km away"));
  EXPECT_THAT(errorOf(header + "f,1,m,1,1,0,0,0,0,0,0,1,,,,,,,,1,-1,,sure,,\n"), HasSubstr("is negative"));
  EXPECT_THAT(errorOf(header + "f,0,,,,,,,,,,,,,,,,,,,,\"why,unknown,,\n"), HasAll("line 2", "quote"));
  EXPECT_THAT(errorOf(header + "\"f\"x,0,,,,,,,,,,,,,,,,,,,,why,unknown,,\n"), HasSubstr("line 2"));
  EXPECT_NE(ioErrorOf([] { readTiming("no/such/folder"); }), "");
}

/** As a program leaves it that is killed while it writes. */
TEST_F(Results, ATornLastLineIsLeftOutForWhoHearsOfIt) {
  const std::string row = "f,0,,,,,,,,,,,,,,,,,,,,why,unknown,,\n", torn = "g,1,\"a model";
  const TemporaryFolder folder;
  std::string remarks;
  const Remark remark = [&](const std::string& text) { remarks += text; };
  for (std::size_t cut = 1; cut <= torn.size(); ++cut) {
    putBytes(folder / "hypotheses.csv", kHeader + row + torn.substr(0, cut));
    EXPECT_NE(ioErrorOf([&] { readHypotheses(folder.path()); }), "");
    remarks.clear();
    EXPECT_EQ(readHypotheses(folder.path(), remark).size(), 1u);
    EXPECT_THAT(remarks, HasAll("hypotheses.csv", "torn"));
  }
  remarks.clear();
  putBytes(folder / "hypotheses.csv", kHeader + torn + "\n" + row);
  EXPECT_NE(ioErrorOf([&] { readHypotheses(folder.path(), remark); }), "") << "it is not the last line";
  putBytes(folder / "hypotheses.csv", kHeader + row + row.substr(0, row.size() - 1));
  EXPECT_EQ(readHypotheses(folder.path(), remark).size(), 1u) << "the rest of it is unknown";
  EXPECT_THAT(remarks, HasSubstr("torn"));
  EXPECT_EQ(readHypotheses(folder.path()).size(), 2u);
}

TEST_F(Results, LineNumbersCountLinesInsideQuotes) {
  const std::string two_lines = "f,0,,,,,,,,,,,,,,,,,,,,\"a\nb\",unknown,,\n\n";
  EXPECT_THAT(errorOf(kHeader + two_lines + "bad\n"), HasSubstr("line 5"));
}

TEST(Starts, RoundTrip) {
  const TemporaryFolder folder;
  EXPECT_TRUE(readStarts(folder.path()).empty());
  StartAnswer sure{"1.5", "2,5", AnswerState::sure, 0.95, Eigen::Isometry3d::Identity()};
  sure.T_w_c->linear() = expSO3({0.1, 2.5, -0.3});
  const StartAnswer unknown{"1.5", "3", AnswerState::unknown, 0, {}};
  writeStarts(folder.path(), {sure, unknown});
  const std::vector<StartAnswer> read = readStarts(folder.path());
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].start, "1.5");
  EXPECT_EQ(read[0].frame, "2,5");
  EXPECT_EQ(read[0].state, AnswerState::sure);
  EXPECT_EQ(read[0].probability, 0.95);
  EXPECT_TRUE(read[0].T_w_c->isApprox(*sure.T_w_c, 1e-8));
  EXPECT_EQ(read[1].state, AnswerState::unknown);
  EXPECT_FALSE(read[1].T_w_c);

  putBytes(folder.path() / "starts.csv",
           "start,frame,state,probability,w_tx,w_ty,w_tz,w_qx,w_qy,w_qz,w_qw\na,b,perhaps,1,,,,,,,\n");
  EXPECT_THAT(ioErrorOf([&] { readStarts(folder.path()); }), HasAll("starts.csv", "2"));
}

TEST(ResultsWriter, WritesTheSameFrameByFrame) {
  const TemporaryFolder folder;
  writeResults(folder / "whole", twoFrames(), "width = 320\n");
  ResultsWriter writer(folder / "growing", "width = 320\n");
  EXPECT_TRUE(isResultsFolder(folder / "growing"));
  EXPECT_TRUE(readHypotheses(folder / "growing").empty());
  for (const FrameResult& frame : twoFrames()) {
    const std::size_t before = readTiming(folder / "growing").size();
    writer.append(frame);
    EXPECT_EQ(readTiming(folder / "growing").size(), before + 1) << "there when append() returns";
  }
  for (const char* name :
       {"hypotheses.csv", "timing.csv", "poses_tum.txt", "covariances.csv", "shares.csv", "params.ini"})
    EXPECT_EQ(bytesOf(folder / "whole" / name), bytesOf(folder / "growing" / name)) << name;
}

TEST(ResultsWriter, BeginsAnewAndIsChecked) {
  const TemporaryFolder folder;
  writeResults(folder / "a", twoFrames(), "");
  ResultsWriter writer(folder / "a", "new = 1\n");
  EXPECT_TRUE(readHypotheses(folder / "a").empty());
  EXPECT_EQ(bytesOf(folder / "a" / "params.ini"), "new = 1\n");
  FrameResult bad = twoFrames()[0];
  bad.rows[0].score = NAN;
  EXPECT_THROW(writer.append(bad), std::invalid_argument);
  EXPECT_TRUE(readTiming(folder / "a").empty()) << "nothing of it is written";
  putBytes(folder / "b", "a file");
  EXPECT_THAT(ioErrorOf([&] { ResultsWriter(folder / "b", ""); }), HasSubstr("cannot be created"));
}

/** A program may be killed while it writes, at any byte. */
TEST(ResultsWriter, GoesOnWithWhatIsWhole) {
  const TemporaryFolder folder;
  std::vector<FrameResult> frames = twoFrames();
  frames[1].rows[0].reason = "dark, \"very\"";
  std::filesystem::create_directory(folder / "run");
  const std::vector<ResultFrame> names = {{"1.5", 1.5}, {"2", 2}};
  constexpr const char* kFiles[] = {"hypotheses.csv", "covariances.csv", "shares.csv", "poses_tum.txt",
                                    "timing.csv"};
  writeResults(folder / "none", {}, "");
  writeResults(folder / "one", {frames[0]}, "");
  writeResults(folder / "whole", frames, "");
  const auto sizeOf = [&](const char* run, const char* file) { return bytesOf(folder / run / file).size(); };
  for (const int before : {0, 1}) {
    const char *begin = before ? "one" : "none", *end = before ? "whole" : "one";
    for (const char* torn : kFiles)
      for (std::size_t size = sizeOf(begin, torn); size < sizeOf(end, torn); size += 5) {
        bool is_written = true;  // for the files in their order, those before the torn one
        for (const char* file : kFiles) {
          const std::string content = bytesOf(folder / (is_written ? end : begin) / file);
          putBytes(folder / "run" / file, file == torn ? content.substr(0, size) : content);
          is_written = is_written && file != torn;
        }
        EXPECT_EQ(readResults(folder / "run").size(), static_cast<std::size_t>(before)) << torn << size;
        ResultsWriter writer(folder / "run", "", names);
        for (std::size_t i = static_cast<std::size_t>(before); i < frames.size(); ++i)
          writer.append(frames[i]);
        for (const char* file : kFiles)
          EXPECT_EQ(bytesOf(folder / "run" / file), bytesOf(folder / "whole" / file)) << file << torn << size;
      }
  }
}

TEST(ResultsWriter, BringsFramesIntoOrderAndDropsOthers) {
  const TemporaryFolder folder;
  const std::vector<FrameResult> frames = twoFrames();
  writeResults(folder / "right", frames, "");
  writeResults(folder / "wrong", {frames[1], frames[0]}, "");
  writeResults(folder / "second", {frames[1]}, "");
  ResultsWriter(folder / "wrong", "", {{"1.5", 1.5}, {"2", 2}, {"not there", 3}});
  ResultsWriter(folder / "right" / ".", "", {{"1.5", 1.5}, {"2", 2}});
  for (const char* name : {"hypotheses.csv", "timing.csv", "poses_tum.txt", "covariances.csv", "shares.csv"})
    EXPECT_EQ(bytesOf(folder / "wrong" / name), bytesOf(folder / "right" / name)) << name;
  ResultsWriter(folder / "wrong", "", {{"2", 2}});
  for (const char* name : {"hypotheses.csv", "timing.csv", "poses_tum.txt", "covariances.csv", "shares.csv"})
    EXPECT_EQ(bytesOf(folder / "wrong" / name), bytesOf(folder / "second" / name)) << name;
}

TEST_F(Results, ColumnsHaveWordsForDocuments) {
  std::string header;
  for (const ResultColumn& column : resultColumns()) {
    EXPECT_STRNE(column.text, "") << column.name;
    for (const std::string& name : column.names()) header += (header.empty() ? "" : ",") + name;
  }
  EXPECT_EQ(header + "\n", kHeader);
}

TEST(GrowingFile, SaysThatTheDiskIsFull) {
  const TemporaryFolder folder;
  {
    const FullDisk full(10);
    EXPECT_THAT(ioErrorOf([&] { GrowingFile(folder / "a", "a long header\n"); }),
                HasSubstr("a: " + std::string(FullDisk::kWords)));
    EXPECT_EQ(folder.count(), 0);
    GrowingFile file(folder / "b", "header\n");
    EXPECT_THROW(file.append("a long line\n"), WriteError);
  }
  EXPECT_EQ(bytesOf(folder / "b"), "header\na l") << "as much as the disk has room for";
}

TEST_F(Results, WritingIsChecked) {
  EXPECT_THROW(writeResults(folder_ / "a", {FrameResult()}, ""), std::invalid_argument);
  FrameResult frame;
  frame.rows = {hypothesis("f", 1)};
  frame.rows[0].score = NAN;
  EXPECT_THROW(writeResults(folder_ / "a", {frame}, ""), std::invalid_argument);
  EXPECT_EQ(folder_.count(), 0);
}

}  // namespace
}  // namespace facetloc::test

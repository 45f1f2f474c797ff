// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/error.h>
#include <facetloc/io/gravity_record.h>

namespace facetloc::test {
namespace {

class GravityFiles : public InAFolder {
protected:
  std::string put(const std::string& content) const {
    std::ofstream(folder_ / "gravity") << content;
    return folder_ / "gravity";
  }
  GravityRecord read(const std::string& content) const { return readGravity(put(content), kDegree); }
  std::string faultOf(const std::string& content) const {
    return ioErrorOf([&] { read(content); });
  }
};

TEST_F(GravityFiles, AreLinesOfAStampAndADirectionOfAnyLength) {
  const GravityRecord record =
      read("# stamps and directions\n\n10.5 0 9.81 0\r\n10.0,0,0,1\n11 ; 0 ; -2 ; 0\n");
  ASSERT_EQ(record.samples().size(), 3u);
  EXPECT_EQ(record.samples()[0].stamp, 10.0);
  EXPECT_TRUE(record.samples()[0].gravity.down.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(record.samples()[1].gravity.down.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(record.samples()[2].gravity.down.isApprox(-Eigen::Vector3d::UnitY()));
  EXPECT_EQ(record.samples()[2].gravity.std, kDegree);
}

TEST_F(GravityFiles, MayNameTheirColumnsAmongOthers) {
  const std::string log = "time_ms,x,y,z,gravity_x,gravity_y,gravity_z,std_deg\n"
                          "1500,7,8,9,0,1,0,2\n1600,7,8,9,1,0,0,0.5\n";
  const GravityRecord record = read(log);
  ASSERT_EQ(record.samples().size(), 2u);
  EXPECT_NEAR(record.samples()[0].stamp, 1.5, 1e-12);
  EXPECT_NEAR(record.samples()[0].gravity.std, 2 * kDegree, 1e-12);
  EXPECT_TRUE(record.samples()[1].gravity.down.isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(holdsGravity(put(log)));
  EXPECT_FALSE(holdsGravity(put("0 1 2 3 0 0 0 1\n"))) << "poses";
  EXPECT_FALSE(holdsGravity(put("")));
}

TEST_F(GravityFiles, WithFaultsNameTheLine) {
  EXPECT_THAT(faultOf("1 0 1 0\n2 0 1\n"), HasAll("gravity", "line 2", "3 columns"));
  EXPECT_THAT(faultOf("1 0 1 0\n2 0 x 0\n"), HasAll("line 2", "'x'"));
  EXPECT_THAT(faultOf("1 0 nan 0\n"), HasSubstr("line 1"));
  EXPECT_THAT(faultOf("1 0 0 0\n"), HasAll("line 1", "no direction"));
  EXPECT_THAT(faultOf("stamp gx gy gz std_deg\n1 0 1 0 0\n"), HasAll("line 2", "deviation"));
  EXPECT_THAT(faultOf("nothing\n"), HasSubstr("stamp gx gy gz"));
  EXPECT_THAT(faultOf(""), HasSubstr("stamp gx gy gz"));
  EXPECT_THAT(faultOf("stamp gx gy gz\n"), HasSubstr("no line"));
  EXPECT_THROW(readGravity(folder_ / "nowhere", kDegree), IoError);
}

TEST_F(GravityFiles, AreWrittenAsTheyAreRead) {
  const std::string file = folder_ / "out";
  writeGravity(file, {{1.25, gravityAlong({0.1, 1, 0.2}, kDegree)}, {2, gravityAlong({0, 0, 1}, kDegree)}});
  const GravityRecord record = readGravity(file, kDegree);
  ASSERT_EQ(record.samples().size(), 2u);
  EXPECT_EQ(record.samples()[0].stamp, 1.25);
  EXPECT_TRUE(record.samples()[0].gravity.down.isApprox(Eigen::Vector3d(0.1, 1, 0.2).normalized(), 1e-8));
}

TEST(GravityRecord, IsKnownBetweenSamplesThatAreClose) {
  const auto sample = [](double stamp, const Eigen::Vector3d& down) {
    return StampedGravity{stamp, gravityAlong(down, kDegree)};
  };
  const GravityRecord record({sample(1, {0, 1, 0}), sample(1.1, {0, 1, 0.1}), sample(3, {0, 0, 1})});
  EXPECT_TRUE(record.at(1.05)->down.isApprox(Eigen::Vector3d(0, 1, 0.05).normalized(), 1e-3));
  EXPECT_TRUE(record.at(0.99)->down.isApprox(Eigen::Vector3d::UnitY())) << "nearest";
  EXPECT_TRUE(record.at(3.02));
  EXPECT_FALSE(record.at(0.9));
  EXPECT_FALSE(record.at(2)) << "in a gap";
  EXPECT_FALSE(record.at(4));
  EXPECT_FALSE(GravityRecord().at(0));
}

TEST(GravityRecord, FollowsFromPosesInALevelWorld) {
  const Eigen::Isometry3d upside(
      Eigen::AngleAxisd(-EIGEN_PI / 2, Eigen::Vector3d::UnitX()));  // looks along y
  const GravityRecord record = gravityOf(Trajectory({{1, upside}}), Eigen::Vector3d::UnitZ(), kDegree);
  EXPECT_TRUE(record.at(1)->down.isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

}  // namespace
}  // namespace facetloc::test

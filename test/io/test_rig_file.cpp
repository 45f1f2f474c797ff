// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/rig_file.h>
#include <facetloc/testing/pose_matchers.h>

#include <gmock/gmock.h>

namespace facetloc::test {
namespace {

using testing::HasSubstr;

std::string errorOf(const std::string& content) {
  const TemporaryFolder folder;
  putBytes(folder / "rig.ini", content);
  return ioErrorOf([&] { readRigFile(folder / "rig.ini"); });
}

TEST(RigFile, NamesTheFoldersOfCamerasAndTheirErrors) {
  const TemporaryFolder folder;
  putBytes(folder / "rig.ini", "# a robot\ncameras = front  rear # two\ntranslation_std=0.02\n");
  const auto rig = readRigFile(folder.path());
  ASSERT_TRUE(rig);
  ASSERT_EQ(rig->cameras.size(), 2u);
  EXPECT_EQ(rig->cameras[0].filename(), "front");
  EXPECT_EQ(rig->cameras[1].parent_path(), rig->cameras[0].parent_path());
  EXPECT_EQ(rig->translation_std, 0.02);
  EXPECT_EQ(rig->rotation_std, RigFile().rotation_std);
  EXPECT_FALSE(readRigFile(folder / "front"));
}

// A camera 0.3 m behind the first one that looks back: its axis points against the first one's.
TEST(RigFile, PosesFollowFromTheMountings) {
  const CameraMounting front{1, 0, 0, 0, 0.1, 0}, rear{1, 0, 0, 180, -0.2, 0};
  RigFile rig;
  rig.rotation_std = 0.01;
  const PoseWithCovariance T = rig.between(front, rear);
  EXPECT_TRUE((T.T * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(0, 0, -1.3)));
  EXPECT_TRUE((T.T * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(-1, 0, -0.3)));
  EXPECT_NEAR(T.P(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(T.P(5, 5), rig.translation_std * rig.translation_std, 1e-12);
}

TEST(RigFile, FaultsAreNamedWithTheirLine) {
  EXPECT_THAT(errorOf("cameras = front\n"), HasSubstr("fewer than two cameras"));
  EXPECT_THAT(errorOf("cameras = a a\n"), HasSubstr("line 1: camera a is named twice"));
  EXPECT_THAT(errorOf("\ncameras a b\n"), HasSubstr("line 2: expected key = value"));
  EXPECT_THAT(errorOf("cameras = a b\nrotation_std_deg = -1\n"), HasSubstr("line 2: rotation_std_deg = -1"));
  EXPECT_THAT(errorOf("cameras = a b\nangle = 1\n"), HasSubstr("unknown key 'angle'"));
  EXPECT_THAT(errorOf("cameras = a b\ncameras = c d\n"), HasSubstr("cameras is given twice"));
}

}  // namespace
}  // namespace facetloc::test

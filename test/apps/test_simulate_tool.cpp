// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/simulation/simulated_drive.h>

#include <pcl/io/ply_io.h>

#include <algorithm>

namespace facetloc::test {
namespace {

TEST_F(Tools, SimulateIsReproducible) {
  for (const std::string scene :
       {"room", "office", "home", "hall", "corridor", "hotel", "boards", "doors", "passage", "box"}) {
    for (const std::string threads : {"1", "2"}) {
      const ToolRun run = ok(runTool<simulateApp>({scene, "--seed", "9", "--frames", "2", "--width", "160",
                                                   "-o", folder_ / scene + threads, "--threads", threads}));
      EXPECT_THAT(lastLine(run.out), HasSubstr(folder_ / scene + threads));
    }
    const fs::path one = folder_ / scene + "1", two = folder_ / scene + "2";
    int compared = 0;
    for (const auto& entry : fs::recursive_directory_iterator(one)) {
      if (!entry.is_regular_file()) continue;
      EXPECT_EQ(contentOf(entry.path()), contentOf(two / fs::relative(entry.path(), one))) << entry.path();
      ++compared;
    }
    // Two runs of camera.ini, groundtruth.txt, planes.csv, depth and labels; unmapped.txt.
    EXPECT_EQ(compared, 2 * (3 + 2 * 2) + 1);
  }
}

TEST_F(Tools, SimulateRefusesUnknownNames) {
  EXPECT_THAT(
      runTool<simulateApp>({"palace", "-o", folder_ / "x"}),
      refuses("office", "home", "hall", "corridor", "hotel", "boards", "doors", "passage", "box", "room"));
}

TEST_F(Tools, SimulateWritesTheBuildingItself) {
  ok(runTool<simulateApp>(
      {"home", "--seed", "2", "--model", folder_ / "home.ply", "--grid", folder_ / "plans/home"}));
  pcl::PolygonMesh mesh;
  ASSERT_EQ(pcl::io::loadPLYFile(folder_ / "home.ply", mesh), 0);
  EXPECT_GT(mesh.polygons.size(), 1000u);
  const OccupancyGrid grid = readOccupancyGrid(folder_ / "plans/home.yaml");
  EXPECT_GT(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kOccupied), 1000);
  EXPECT_THAT(runTool<simulateApp>({"boards", "--grid", folder_ / "boards"}), refuses("no walls"));
}

TEST_F(Tools, SimulateTakesAnotherCamera) {
  ok(runTool<simulateApp>({"room", "--camera", "phone_lidar", "--frames", "1", "-o", folder_ / "lidar"}));
  const CameraFile lidar = *DepthSequence::open(folder_ / "lidar/map").camera();
  EXPECT_EQ(lidar.preset, "phone_lidar");
  EXPECT_EQ(lidar.camera.intrinsics, findCameraPreset("phone_lidar")->intrinsics());
  EXPECT_EQ(lidar.camera.max_depth, 5);

  // An option counts more than the camera: here all pixels are lost.
  const ToolRun blind =
      ok(runTool<simulateApp>({"room", "--camera", "phone_lidar", "--sensor.random_dropout", "1", "--frames",
                               "1", "--width", "128", "-o", folder_ / "blind"}));
  const DepthSequence sequence = DepthSequence::open(folder_ / "blind/map");
  const DepthImage image = sequence.load(0);
  EXPECT_EQ(image.camera.height, 96) << "3 to 4, as its camera";
  EXPECT_EQ(std::count(image.depth.begin(), image.depth.end(), 0.f), 128 * 96);
}

TEST_F(Tools, SimulateMakesMapsThatAreALittleOff) {
  const auto simulate = [&](const std::string& name, std::vector<std::string> options) {
    ok(runTool<simulateApp>(Arguments{"room", "--frames", "3", "--width", "80", "-o", folder_ / name} +
                            options));
  };
  const auto images = [&](const std::string& run) {
    std::vector<std::vector<float>> all;
    const DepthSequence sequence = DepthSequence::open(folder_ / run);
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) all.push_back(sequence.load(i).depth);
    return all;
  };
  simulate("true", {});
  simulate("bent", {"--surface-error", "0.02"});
  simulate("moved", {"--map_poses.translation_std", "0.05"});
  EXPECT_NE(images("bent/map"), images("true/map"));
  EXPECT_EQ(images("bent/query"), images("true/query"));
  EXPECT_EQ(images("moved/map"), images("true/map"));
  for (const char* run : {"map", "query"})
    EXPECT_EQ(contentOf(folder_ / ("moved/" + std::string(run) + "/groundtruth.txt")),
              contentOf(folder_ / ("true/" + std::string(run) + "/groundtruth.txt")));
  const Trajectory moved = readTrajectory(folder_ / "moved/map/poses.txt"),
                   truth = readTrajectory(folder_ / "true/map/groundtruth.txt");
  ASSERT_EQ(moved.poses().size(), truth.poses().size());
  const double error = (moved.poses()[0].T_w_c.translation() - truth.poses()[0].T_w_c.translation()).norm();
  EXPECT_GT(error, 0.005);
  EXPECT_LT(error, 0.3);
  EXPECT_FALSE(fs::exists(folder_ / "true/map/poses.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "moved/query/poses.txt"));
}

TEST_F(Tools, SimulateAddsSharedErrorsOfTheCamera) {
  const auto simulate = [&](const std::string& name, std::vector<std::string> options) {
    ok(runTool<simulateApp>(Arguments{"room", "--camera", "phone_lidar", "--frames", "1", "--width", "128",
                                      "-o", folder_ / name} +
                            options));
    return DepthSequence::open(folder_ / (name + "/map")).load(0).depth;
  };
  const auto usual = simulate("usual", {}), shared = simulate("shared", {"--shared-errors"});
  EXPECT_NE(usual, shared);
  EXPECT_EQ(usual, simulate("off", {"--shared-errors", "--sensor.smooth_error", "0", "--sensor.blur_px", "0",
                                    "--sensor.filling_px", "0"}))
      << "options count more";
}

TEST_F(Tools, SimulateRefusesAnUnknownCamera) {
  EXPECT_THAT(runTool<simulateApp>({"room", "--camera", "nikon", "-o", folder_ / "x"}),
              refuses("unknown camera 'nikon'", "realsense_d435"));
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(Tools, SimulateWritesASequenceWithItsTruth) {
  const DepthSequence sequence = DepthSequence::open(map_run());
  EXPECT_EQ(sequence.frames().size(), static_cast<std::size_t>(kFrames));
  ASSERT_TRUE(sequence.camera() && sequence.camera()->camera.mounting);
  const Intrinsics k = kinectIntrinsics();
  const Intrinsics half = {320, 240, k.fx / 2, k.fy / 2, (k.cx + 0.5) / 2 - 0.5, (k.cy + 0.5) / 2 - 0.5};
  EXPECT_EQ(sequence.camera()->camera.intrinsics, half);
  for (const FrameFile& frame : sequence.frames()) {
    EXPECT_TRUE(sequence.groundTruth().at(frame.stamp, 1e-6));
    EXPECT_TRUE(fs::exists(map_run() + "/labels/" + frame.path.filename().string()));
  }
}

TEST_F(Tools, SimulateStampsImagesAsARobotDrives) {
  ok(runTool<simulateApp>(
      {"office", "--frames", "60", "--width", "40", "--rounds", "2", "-o", folder_ / "office"}));
  double stamp = -1;
  for (const char* run : {"map", "query"}) {
    const DepthSequence sequence = DepthSequence::open(folder_ / "office/" + run);
    const Eigen::Isometry3d T_c_b = sequence.camera()->camera.mounting->T_b_c().inverse();
    const std::vector<StampedPose>& poses = sequence.groundTruth().poses();
    ASSERT_EQ(poses.size(), run == std::string("map") ? 120u : 60u);
    EXPECT_GT(poses.front().stamp, stamp) << "no two images have the same stamp";
    stamp = poses.back().stamp;
    double distance = 0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const Eigen::Isometry3d from = poses[i - 1].T_w_c * T_c_b, to = poses[i].T_w_c * T_c_b;
      const double length = (to.translation() - from.translation()).head<2>().norm();
      const double time = poses[i].stamp - poses[i - 1].stamp;
      EXPECT_LE(length, 0.5 * time + 1e-5) << i;
      EXPECT_GE(time, 1 / 30. - 1e-5) << i;
      distance += length;
    }
    EXPECT_GT(distance / (poses.back().stamp - poses.front().stamp), 0.15) << "nor does it dawdle";
  }
}

TEST_F(Tools, SimulateGoesRoundMoreThanOnce) {
  const auto simulate = [&](const std::string& folder, const std::string& rounds) {
    return runTool<simulateApp>({"home", "--map-frames", "40", "--query-frames", "3", "--width", "40",
                                 "--map-step", "5", "--drive.turn_deg", "180", "--rounds", rounds, "-o",
                                 folder_ / folder});
  };
  ok(simulate("once", "1"));
  ok(simulate("thrice", "3"));
  EXPECT_EQ(simulate("never", "0").code, kUsage);
  EXPECT_EQ(DepthSequence::open(folder_ / "once/map").frames().size(), 40u);
  EXPECT_EQ(DepthSequence::open(folder_ / "thrice/map").frames().size(), 120u);
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "once/query")) {
    if (!entry.is_regular_file()) continue;
    const fs::path other = fs::path(folder_ / "thrice") / fs::relative(entry.path(), folder_ / "once");
    EXPECT_EQ(contentOf(entry.path()), contentOf(other)) << entry.path();
  }
}

TEST_F(Tools, SimulateWritesTheWheelOdometry) {
  const auto simulate = [&](const std::string& folder, const std::vector<std::string>& more) {
    return runTool<simulateApp>(
               Arguments{"office", "--frames", "30", "--width", "40", "-o", folder_ / folder} + more)
        .code;
  };
  ASSERT_EQ(simulate("without", {}), kOk);
  ASSERT_EQ(simulate("with", {"--odometry"}), kOk);
  ASSERT_EQ(simulate("exact", {"--odometry", "--odometry.scale_std", "0", "--odometry.length_std", "0",
                               "--odometry.heading_std_deg", "0"}),
            kOk);
  for (const std::string run : {"map", "query"}) {
    EXPECT_FALSE(fs::exists(folder_ / "without/" + run + "/odometry.txt"));
    const std::string truth = "/" + run + "/groundtruth.txt", told = "/" + run + "/odometry.txt";
    EXPECT_EQ(contentOf(folder_ / "without" + truth), contentOf(folder_ / "with" + truth));
    const Trajectory camera = readTrajectory(folder_ / "exact" + truth),
                     base = readTrajectory(folder_ / "exact" + told),
                     noisy = readTrajectory(folder_ / "with" + told);
    ASSERT_EQ(base.poses().size(), camera.poses().size());
    ASSERT_EQ(noisy.poses().size(), camera.poses().size());
    const Eigen::Isometry3d T_b_c = DriveParams{}.mounting().T_b_c();
    const auto place = [&](std::size_t i) -> Eigen::Vector3d {
      return (camera.poses()[i].T_w_c * T_b_c.inverse()).translation();
    };
    for (std::size_t i = 0; i < base.poses().size(); ++i) {
      const StampedPose &exact = base.poses()[i], &wrong = noisy.poses()[i];
      EXPECT_EQ(exact.stamp, camera.poses()[i].stamp);
      EXPECT_NEAR(exact.T_w_c.translation().norm(), (place(i) - place(0)).head<2>().norm(), 1e-6) << i;
      EXPECT_EQ(wrong.T_w_c.translation().isApprox(exact.T_w_c.translation()), i == 0) << i;
      EXPECT_LT((wrong.T_w_c.translation() - exact.T_w_c.translation()).norm(), 2) << i;
    }
  }
}

TEST_F(Tools, SimulateDrivesInRealTime) {
  const Arguments common = {"room", "--seed",  "5",   "--frames",    "2", "--width",
                            "80",   "--drive", "1.5", "--pace.rate", "10"};
  const auto simulate = [&](const std::string& folder, const std::vector<std::string>& more) {
    return runTool<simulateApp>(common + more + Arguments{"-o", folder_ / folder});
  };
  ok(simulate("all", {"--threads", "2"}));
  for (const char* run : {"map", "query", "drive"}) EXPECT_TRUE(fs::exists(folder_ / "all/" + run)) << run;
  const ToolRun alone = ok(simulate("alone", {"--runs", "drive"}));
  EXPECT_THAT(alone.out, HasSubstr("15 images"));
  EXPECT_FALSE(fs::exists(folder_ / "alone/map"));
  EXPECT_FALSE(fs::exists(folder_ / "alone/query"));

  const DepthSequence drive = DepthSequence::open(folder_ / "alone/drive");
  ASSERT_EQ(drive.frames().size(), 15u);
  EXPECT_EQ(drive.groundTruth().poses().size(), 15u);
  for (std::size_t i = 0; i < drive.frames().size(); ++i) {
    EXPECT_NEAR(drive.frames()[i].stamp, drive.frames()[0].stamp + 0.1 * static_cast<double>(i), 1e-6);
    EXPECT_TRUE(drive.groundTruth().at(drive.frames()[i].stamp, 1e-6));
    const fs::path file = drive.frames()[i].path.filename();
    EXPECT_EQ(contentOf(drive.frames()[i].path), contentOf(fs::path(folder_ / "all/drive/depth") / file));
  }
  EXPECT_FALSE(fs::exists(folder_ / "alone/drive/labels"));

  EXPECT_EQ(simulate("alone", {"--runs", "drive"}).code, kFailed);  // is there already
  ok(simulate("alone", {"--runs", "map"}));                         // beside it
  EXPECT_THAT(simulate("other", {"--runs", "flight"}).err, HasSubstr("map query drive"));
  EXPECT_EQ(simulate("other", {"--pace.rate", "0"}).code, kUsage);
}

}  // namespace
}  // namespace facetloc::test

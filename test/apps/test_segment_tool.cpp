// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/features/segment_frame.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>
#include <facetloc/io/results.h>
#include <facetloc/io/segment_file.h>

#include <pcl/impl/pcl_base.hpp>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>

namespace facetloc::test {
namespace {

TEST_F(Tools, SegmentWritesSegmentsLabelsAndOverlays) {
  ok(runTool<segmentApp>({firstImage(), "-o", folder_ / "out", "--labels", "--overlay"}));
  const std::string base = folder_ / "out/" + fs::path(firstImage()).stem().string();
  pcl::PointCloud<SegmentFrame> cloud;
  ASSERT_EQ(pcl::PCDReader().read(base + ".segments.pcd", cloud), 0);
  const Raster<std::uint16_t> labels = readGreyPng(base + ".png", 16);
  EXPECT_EQ(labels.width, 320);
  EXPECT_EQ(*std::max_element(labels.data.begin(), labels.data.end()), cloud.size());
  EXPECT_TRUE(fs::exists(base + "_overlay.png"));
}

TEST_F(Tools, SegmentWritesCloudsAndPolygons) {
  const std::vector<std::string> arguments = {firstImage(), "-o", folder_ / "out", "--pcd", "--ply"};
  ok(runTool<segmentApp>(arguments));
  const std::string base = folder_ / "out/" + fs::path(firstImage()).stem().string();
  const std::vector<Segment> segments = readSegments(base + ".segments.pcd");
  pcl::PointCloud<pcl::PointXYZL> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(base + ".pcd", cloud), 0);
  std::vector<double> points(segments.size() + 1, 0), off(segments.size() + 1, 0);
  for (const pcl::PointXYZL& p : cloud) {
    ASSERT_LE(p.label, segments.size());
    if (p.label == 0 || !p.getVector3fMap().allFinite()) continue;
    const Segment& s = segments[p.label - 1];
    points[p.label] += 1;
    off[p.label] += std::abs(s.normal().dot(p.getVector3fMap().cast<double>() - s.t));
  }
  for (std::size_t k = 1; k < points.size(); ++k) {
    EXPECT_GE(points[k], segments[k - 1].num_points);
    EXPECT_LT(off[k] / points[k], 0.05);
  }
  pcl::PolygonMesh mesh;
  ASSERT_EQ(pcl::io::loadPLYFile(base + ".ply", mesh), 0);
  EXPECT_EQ(mesh.polygons.size(), segments.size());

  fs::remove(base + ".ply");
  std::vector<std::string> again = arguments;
  again.emplace_back("--resume");
  ok(runTool<segmentApp>(again));
  EXPECT_TRUE(fs::exists(base + ".ply"));
}

/** An image as a cloud with colours, and labels of another program. */
pcl::PointCloud<pcl::PointXYZRGBL> colouredCloud(const DepthImage& image) {
  constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();
  pcl::PointCloud<pcl::PointXYZRGBL> cloud(image.camera.width, image.camera.height);
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      pcl::PointXYZRGBL& p = cloud(u, v);
      const float z = image.at(u, v);
      p.getVector3fMap() = Eigen::Vector3f::Constant(kNotMeasured);
      if (z > 0) p.getVector3fMap() = (image.camera.ray(u, v) * z).cast<float>();
      p.r = static_cast<std::uint8_t>(u), p.g = static_cast<std::uint8_t>(v), p.b = 7, p.label = 9999;
    }
  cloud.is_dense = false;
  return cloud;
}

TEST_F(Tools, SegmentLabelsAllPointsOfACloudAndKeepsItsFields) {
  const auto in = colouredCloud(DepthSequence::open(firstImage()).load(0));
  pcl::io::savePCDFileBinary(folder_ / "first.pcd", in);
  ok(runTool<segmentApp>({folder_ / "first.pcd", "-o", folder_ / "out", "--pcd", "--width", "160"}));
  pcl::PointCloud<pcl::PointXYZRGBL> out;
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "out/first.pcd", out), 0);
  ASSERT_EQ(out.width, in.width);
  ASSERT_EQ(out.height, in.height);
  std::size_t measured = 0, labelled = 0;
  for (std::size_t i = 0; i < in.size(); ++i) {
    EXPECT_EQ(out[i].rgba & 0xffffff, in[i].rgba & 0xffffff);
    if (std::isnan(in[i].z)) {
      EXPECT_EQ(out[i].label, 0u);
      continue;
    }
    EXPECT_EQ(out[i].getVector3fMap(), in[i].getVector3fMap());
    ASSERT_LT(out[i].label, 9999u);
    ++measured, labelled += out[i].label > 0;
  }
  EXPECT_GT(2 * labelled, measured);
}

TEST_F(Tools, SegmentLabelsCloudsOfOneNameInSeveralFolders) {
  const auto in = colouredCloud(DepthSequence::open(firstImage()).load(0));
  std::vector<std::string> inputs;
  for (const char* folder : {"a/x", "b/x", "b/y"}) {
    fs::create_directories(folder_ / folder);
    inputs.push_back(folder_ / folder + "/cloud.pcd");
    pcl::io::savePCDFileBinary(inputs.back(), in);
  }
  ok(runTool<segmentApp>(inputs + Arguments{"-o", folder_ / "out", "--pcd"}));
  for (const char* name : {"a_x_cloud.pcd", "b_x_cloud.pcd", "y_cloud.pcd"})
    EXPECT_TRUE(fs::exists(folder_ / "out/" + name)) << name;
}

TEST_F(Tools, SegmentLabelsAllPixelsOfAnImage) {
  ok(runTool<segmentApp>({firstImage(), "-o", folder_ / "out", "--pcd", "--width", "160"}));
  pcl::PointCloud<pcl::PointXYZRGBL> cloud;
  const std::string name = fs::path(firstImage()).stem().string() + ".pcd";
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "out/" + name, cloud), 0);
  EXPECT_EQ(cloud.width, 320u);
  EXPECT_EQ(cloud.height, 240u);
}

TEST_F(Tools, FilesOfSegmentsAreLocalized) {
  ok(runTool<segmentApp>({query(), "-o", folder_ / "found"}));
  for (const std::vector<std::string>& how : {std::vector<std::string>{}, {"--sequence"}}) {
    EXPECT_THAT(
        ok(runTool<localizeApp>(Arguments{map(), folder_ / "found", "-o", folder_ / "results"} + how)).err,
        HasSubstr("without depth"));
    const Trajectory truth = DepthSequence::readTruth(query());
    std::size_t right = 0;
    for (const ResultRow& row : readHypotheses(folder_ / "results"))
      if (row.rank == 1 && row.T_w_c)
        right += (row.T_w_c->translation() - truth.at(std::stod(row.frame))->translation()).norm() < 0.1;
    EXPECT_GE(right, static_cast<std::size_t>(kFrames) / 2);
  }
  EXPECT_THAT(runMap({"build", folder_ / "found", "-o", folder_ / "x.flmap"}),
              fails("this tool needs the depth images"));
}

TEST_F(Tools, SegmentSplitsInEitherWay) {
  std::vector<std::string> labels;
  for (const std::string method : {"quadtree", "delaunay"}) {
    ok(runTool<segmentApp>({firstImage(), "-o", folder_ / method, "--labels", "--split", method}));
    EXPECT_THAT(contentOf(folder_ / (method + "/params.ini")),
                HasSubstr("[split]\nmethod = " + method + "\n"));
    labels.push_back(contentOf(folder_ / (method + "/" + fs::path(firstImage()).stem().string() + ".png")));
    ASSERT_FALSE(labels.back().empty());
  }
  EXPECT_NE(labels[0], labels[1]);
}

TEST_F(Tools, SegmentMeasuresNoise) {
  const std::string folder = folder_ / "azure";
  ok(runTool<simulateApp>({"room", "--camera", "azure_kinect", "--frames", "6", "-o", folder}));
  const ToolRun run = ok(runTool<segmentApp>({"--noise", folder + "/map", folder + "/query"}));
  for (const char* words :
       {"depth [m]", "std of depth [mm]", "correlated over [px]", "Correlated over", "inverse_depth_std = "})
    EXPECT_THAT(run.out, HasSubstr(words));
}

TEST_F(Tools, SegmentMeasuresNoNoiseWhereNothingIsFlat) {
  ok(runTool<simulateApp>(
      {"room", "--sensor.random_dropout", "0.9", "--frames", "1", "--width", "80", "-o", folder_ / "holes"}));
  EXPECT_THAT(runTool<segmentApp>({"--noise", folder_ / "holes/map"}), fails("too few flat places"));
}

TEST_F(Tools, SegmentWritesNothingWhereItMeasuresNoise) {
  for (const char* option : {"--labels", "--overlay", "--resume"}) {
    const ToolRun run = runTool<segmentApp>({"--noise", query(), option});
    EXPECT_EQ(run.code, kUsage) << option;
    EXPECT_THAT(run.err, HasSubstr(std::string("leave out ") + option));
  }
  EXPECT_EQ(runTool<segmentApp>({"--noise", query(), "-o", folder_ / "x"}).code, kUsage);
}

TEST_F(Tools, SegmentReportsABadImageAndDoesTheOthers) {
  const std::string input = withOneCorruptImage();
  EXPECT_THAT(runTool<segmentApp>({input, "-o", folder_ / "out"}), fails("1 of 12 items failed"));
  EXPECT_EQ(filesOf(folder_ / "out").size(), 14u);  // and params.ini, images.txt and inputs.csv

  // Existing results are not touched, missing ones are made.
  const fs::path first = filesOf(folder_ / "out").front();
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(24);
  fs::last_write_time(first, old);
  fs::copy(query() + "/depth", input + "/depth", kReplace);
  EXPECT_THAT(ok(runTool<segmentApp>({input, "-o", folder_ / "out", "--resume"})).out,
              HasAll("1 image with", "11 were done before"));
  EXPECT_EQ(filesOf(folder_ / "out").size(), 15u);
  EXPECT_EQ(fs::last_write_time(first), old);
}

TEST_F(Tools, SegmentResumesNothingOfOtherInputs) {
  const std::string input = folder_.copyOf(query(), "input"), out = folder_ / "out";
  const auto resume = [&](const std::string& width) {
    return runTool<segmentApp>({input, "-o", out, "--width", width, "--resume"});
  };
  ok(resume("160"));
  EXPECT_THAT(resume("160").out, HasSubstr("12 were done before"));
  EXPECT_THAT(resume("320").err, HasSubstr("other parameters"));
  giveOtherImages(input);
  EXPECT_THAT(resume("160").err, HasSubstr("other images"));
  ok(runTool<segmentApp>({input, "-o", out}));
  EXPECT_THAT(resume("320").out, HasSubstr("12 were done before"));
}

TEST_F(Tools, SegmentLeavesNothingThatIsOfAnotherRun) {
  const std::string input = folder_.copyOf(query(), "input"), out = folder_ / "out";
  const fs::path gone = filesOf(input + "/depth").front();
  const fs::path labels = fs::path(out) / gone.filename();  // as large as the image was taken to be
  ok(runTool<segmentApp>({input, "-o", out, "--labels", "--overlay", "--width", "160"}));
  EXPECT_EQ(filesOf(out).size(), 3u * kFrames + 3);
  EXPECT_EQ(readGreyPng(labels, 16).width, 160);

  ok(runTool<segmentApp>({input, "-o", out}));
  EXPECT_EQ(filesOf(out).size(), 1u * kFrames + 3) << "labels of width 160";
  EXPECT_THAT(ok(runTool<segmentApp>({input, "-o", out, "--labels", "--resume"})).out,
              Not(HasSubstr("done before")));
  EXPECT_EQ(readGreyPng(labels, 16).width, 320);

  fs::remove(gone);
  ok(runTool<segmentApp>({input, "-o", out, "--labels", "--resume"}));
  EXPECT_EQ(filesOf(out).size(), 2u * (kFrames - 1) + 3);
  EXPECT_FALSE(fs::exists(labels));
}

TEST_F(Tools, SegmentsOfAnEmptyImageAreAValidFile) {
  const std::string input = folder_ / "input";
  fs::create_directories(input);
  fs::copy_file(query() + "/camera.ini", input + "/camera.ini");
  writePng(input + "/0.png", Raster<std::uint16_t>{320, 240, 1, std::vector<std::uint16_t>(320 * 240, 0)});
  EXPECT_THAT(ok(runTool<segmentApp>({input, "-o", folder_ / "out", "--labels", "--overlay"})).err,
              IsEmpty());
  pcl::PointCloud<SegmentFrame> cloud;
  cloud.resize(3);
  EXPECT_EQ(pcl::PCDReader().read(folder_ / "out/0.segments.pcd", cloud), 0);
  EXPECT_TRUE(cloud.empty());
}

TEST_F(Tools, SegmentDistinguishesImagesOfTheSameName) {
  for (const char* run : {"map", "query"}) {
    fs::create_directories(folder_ / run + "/depth");
    fs::copy_file(query() + "/camera.ini", folder_ / run + "/camera.ini");
    fs::copy_file(firstImage(), folder_ / run + "/depth/7.png");
  }
  ok(runTool<segmentApp>({folder_ / "map", folder_ / "query/depth/7.png", "-o", folder_ / "out"}));
  EXPECT_TRUE(fs::exists(folder_ / "out/map_7.segments.pcd"));
  EXPECT_TRUE(fs::exists(folder_ / "out/query_7.segments.pcd"));
  EXPECT_THAT(runTool<segmentApp>({folder_ / "map", folder_ / "map", "-o", folder_ / "out"}),
              refuses("would both be named"));
}

TEST_F(Tools, SegmentRefusesImagesWhoseOutputsWouldHaveOneName) {
  fs::create_directories(folder_ / "depth");
  fs::copy_file(query() + "/camera.ini", folder_ / "camera.ini");
  for (const char* name : {"a", "a_overlay"}) fs::copy_file(firstImage(), folder_ / "depth/" + name + ".png");
  EXPECT_THAT(runTool<segmentApp>({folder_ / "", "-o", folder_ / "out", "--labels", "--overlay"}),
              refuses("would both be named a_overlay.png"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  ok(runTool<segmentApp>({folder_ / "", "-o", folder_ / "out", "--labels"}));
}

TEST_F(Tools, TrueLabelsAreNotReplacedByFoundOnes) {
  const std::string input = folder_.copyOf(query(), "input");
  EXPECT_THAT(runTool<segmentApp>({input, "-o", input + "/labels", "--labels"}),
              refuses("use another output folder"));
}

TEST_F(Tools, ParametersMayContainANumberSign) {
  const std::string out = folder_ / "run#3", file = folder_ / "p.ini";
  std::ofstream(file) << "output = " << out << " # where the results go\n#a comment\n";
  ok(runTool<segmentApp>({firstImage(), "--params", file}));
  EXPECT_TRUE(fs::exists(out));
}

}  // namespace
}  // namespace facetloc::test

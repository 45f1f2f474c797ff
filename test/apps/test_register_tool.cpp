// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/io/results.h>
#include <facetloc/io/segment_file.h>

#include <pcl/io/pcd_io.h>

#include <cmath>

namespace facetloc::test {
namespace {

TEST_F(Tools, RegisterFindsAnImageInItself) {
  const auto images = filesOf(map_run() + "/depth");
  EXPECT_THAT(runTool<registerApp>({images[0].string(), images[1].string(), "-o", images[0].parent_path()}),
              fails("holds other files already"));
  EXPECT_THAT(ok(runTool<registerApp>({images[0].string(), images[1].string(), "-o", folder_ / "out"})).out,
              HasSubstr(folder_ / "out"));
  const auto rows = readHypotheses(folder_ / "out");
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0].frame, images[0].stem().string());
  EXPECT_EQ(rows[0].rank > 0 ? rows[0].model : images[1].stem().string(), images[1].stem().string());
  EXPECT_EQ(runTool<registerApp>({images[0].string(), map_run()}).code, kUsage);
  EXPECT_EQ(runTool<registerApp>({images[0].string(), folder_ / "nowhere.png"}).code, kFailed);
}

TEST_F(Tools, RegisterTakesSegmentsAndMovesTheSource) {
  const auto images = filesOf(map_run() + "/depth");
  const std::string source = images[1].string(), target = images[0].string(), found = folder_ / "found";
  ok(runTool<segmentApp>({source, target, "-o", found}));
  const auto segmentsOf = [&](const std::string& image) {
    return found + "/" + std::filesystem::path(image).stem().string() + ".segments.pcd";
  };
  std::vector<std::string> clouds;
  for (const std::string& of_source : {source, segmentsOf(source)})
    for (const std::string& of_target : {target, segmentsOf(target)}) {
      clouds.push_back(folder_ / (std::to_string(clouds.size()) + ".pcd"));
      EXPECT_THAT(ok(runTool<registerApp>({of_source, of_target, "--aligned", clouds.back()})).out,
                  HasSubstr("aligned source in " + clouds.back()));
    }
  // The points of the image and its segments are moved to the same place.
  pcl::PointCloud<pcl::PointXYZ> points;
  ASSERT_EQ(pcl::io::loadPCDFile(clouds[0], points), 0);
  const std::vector<Segment> moved = readSegments(clouds[2]);
  ASSERT_FALSE(moved.empty());
  std::size_t near = 0;
  for (const pcl::PointXYZ& p : points)
    near += std::abs(moved[0].normal().dot(p.getVector3fMap().cast<double>() - moved[0].t)) < 0.03;
  EXPECT_GT(near, static_cast<std::size_t>(moved[0].num_points) / 2);

  EXPECT_THAT(runTool<registerApp>({segmentsOf(source), target, "--aligned", segmentsOf(source)}),
              refuses("would replace"));
  EXPECT_EQ(runTool<registerApp>({source, target, "--aligned", folder_ / "a.txt"}).code, kUsage);
}

}  // namespace
}  // namespace facetloc::test

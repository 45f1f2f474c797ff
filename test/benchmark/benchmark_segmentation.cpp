// SPDX-License-Identifier: BSD-3-Clause
//
// Speed of segmentation and features by stages, on one thread, beside two yardsticks: one pass that reads the
// image and accumulates moments, and PCL's own plane segmentation. Of a simulated room, and of the first
// image of a depth sequence that FACETLOC_BENCHMARK_SEQUENCE names.
#include "cluttered_room.h"

#include <facetloc/features/organized_cloud.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/segmentation/view_builder.h>

#include <benchmark/benchmark.h>
#include <pcl/features/integral_image_normal.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>

#include <cstdlib>
#include <limits>

namespace {

using namespace facetloc;
using namespace facetloc::benchmarks;

enum Source { kSimulated, kReal };

// At the given width; of a simulated room or of the sequence. Empty if there is no sequence.
DepthImage imageOf(Source source, int width) {
  if (source == kReal) {
    const char* folder = std::getenv("FACETLOC_BENCHMARK_SEQUENCE");
    return folder ? DepthSequence::open(folder).load(0, width) : DepthImage{};
  }
  const SimulatedCamera camera(kinectIntrinsics(), SimulatedNoise{}, kSeed);
  const DepthImage image = camera.render(clutteredRoom(kSeed), cameraPose(0.3, -0.2, 0.4), 0).depth;
  return subsampled(image, subsamplingStep(image.camera, width));
}

// The arguments of a benchmark as an image; false, and the benchmark is skipped, if there is none.
bool prepare(benchmark::State& state, DepthImage& image) {
  image = imageOf(static_cast<Source>(state.range(1)), static_cast<int>(state.range(0)));
  if (image.empty()) state.SkipWithError("set FACETLOC_BENCHMARK_SEQUENCE to a depth sequence");
  return !image.empty();
}

void report(benchmark::State& state, const DepthImage& image) {
  const auto pixels = state.iterations() * static_cast<std::int64_t>(image.depth.size());
  state.SetItemsProcessed(pixels);
  state.SetBytesProcessed(pixels * static_cast<std::int64_t>(sizeof(float)));
}

void images(benchmark::internal::Benchmark* b) {
  b->ArgNames({"width", "real"})->ArgsProduct({{320, 640}, {kSimulated, kReal}});
  b->Unit(benchmark::kMillisecond);
}

void yardstickMoments(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  for (auto _ : state) {
    PlaneMoments m;
    for (int v = 0, i = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u, ++i)
        if (image.depth[i] > 0) m.add(u, v, 1.0 / image.depth[i]);
    benchmark::DoNotOptimize(m);
  }
  report(state, image);
}
BENCHMARK(yardstickMoments)->Apply(images);

void yardstickPcl(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  cloud->width = image.camera.width, cloud->height = image.camera.height, cloud->is_dense = false;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const float z = isMeasured(image.at(u, v)) ? image.at(u, v) : std::numeric_limits<float>::quiet_NaN();
      const Eigen::Vector3f p = image.camera.ray(u, v).cast<float>() * z;
      cloud->push_back({p.x(), p.y(), p.z()});
    }
  cloud->width = image.camera.width, cloud->height = image.camera.height;
  std::size_t planes = 0;
  for (auto _ : state) {
    const pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
    pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setNormalEstimationMethod(estimation.COVARIANCE_MATRIX);
    estimation.setMaxDepthChangeFactor(0.02f);
    estimation.setNormalSmoothingSize(10.0f);
    estimation.setInputCloud(cloud);
    estimation.compute(*normals);
    pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> segmentation;
    segmentation.setMinInliers(static_cast<unsigned>(scaledPixels(150, image.camera)));
    segmentation.setAngularThreshold(3 * kDegree);
    segmentation.setDistanceThreshold(0.02);
    segmentation.setInputNormals(normals);
    segmentation.setInputCloud(cloud);
    std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>>
        regions;
    segmentation.segmentAndRefine(regions);
    planes = regions.size();
  }
  state.counters["segments"] = static_cast<double>(planes);
  report(state, image);
}
BENCHMARK(yardstickPcl)->Apply(images);

void noise(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  std::vector<float> scratch;
  for (auto _ : state) benchmark::DoNotOptimize(estimateNoise(image, scratch));
  report(state, image);
}
BENCHMARK(noise)->Apply(images);

void split(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  DisparityImage disparity;
  toDisparity(image, SensorNoise{}.inverse_depth_std, disparity);
  DepthTriangulation triangulation;
  for (auto _ : state) triangulation.compute(disparity);
  state.counters["vertices"] = static_cast<double>(triangulation.vertices().size());
  report(state, image);
}
BENCHMARK(split)->Apply(images);

void merge(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  DisparityImage disparity;
  toDisparity(image, SensorNoise{}.inverse_depth_std, disparity);
  DepthTriangulation triangulation;
  triangulation.compute(disparity);
  RegionMerging merging;
  for (auto _ : state) merging.compute(triangulation, disparity);
  state.counters["regions"] = static_cast<double>(merging.regions().size());
  report(state, image);
}
BENCHMARK(merge)->Apply(images);

void features(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  LabelledPlanes planes;
  PlaneSegmenter().segment(image, planes);
  SegmentEstimation estimation;
  std::vector<Segment> segments;
  std::vector<int> kept;
  DepthPicture picture;
  for (auto _ : state) {
    estimation.estimate(image, planes.labels, {}, segments, kept);
    picture.assign(image);
  }
  report(state, image);
}
BENCHMARK(features)->Apply(images);

void segmentation(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  PlaneSegmenter segmenter;
  LabelledPlanes result;
  for (auto _ : state) segmenter.segment(image, result);
  report(state, image);
}
BENCHMARK(segmentation)->Apply(images);

void segmentationAndFeatures(benchmark::State& state) {
  DepthImage image;
  if (!prepare(state, image)) return;
  ViewBuilder builder;
  View view;
  for (auto _ : state) builder.build(image, view);
  state.counters["segments"] = static_cast<double>(view.segments.size());
  report(state, image);
}
BENCHMARK(segmentationAndFeatures)->Apply(images);

}  // namespace

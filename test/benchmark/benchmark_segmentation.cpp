// SPDX-License-Identifier: BSD-3-Clause
//
// Speed of segmentation and features by stages, on one thread, beside two yardsticks: one pass that reads the
// image and accumulates moments, and PCL's own plane segmentation. Of a simulated room, and of images from
// all over a depth sequence that FACETLOC_BENCHMARK_SEQUENCE names, in turn: times are means over them.
#include "base/image_noise.h"
#include "cluttered_room.h"
#include "depth_triangulation.h"
#include "disparity_image.h"
#include "pcl_planes.h"
#include "quad_tree.h"
#include "region_merging.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/organized_clouds.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
using namespace facetloc::internal;
using namespace facetloc::benchmarks;

enum Source { kSimulated, kReal };

// At the given width; of a simulated room or of the sequence. None if there is no sequence.
std::vector<DepthImage> imagesOf(Source source, int width) {
  constexpr std::size_t kOfSequence = 16;
  std::vector<DepthImage> images;
  if (source == kReal) {
    const char* folder = std::getenv("FACETLOC_BENCHMARK_SEQUENCE");
    if (!folder) return images;
    const DepthSequence sequence = DepthSequence::open(folder);
    const std::size_t size = sequence.frames().size(), n = std::min(kOfSequence, size);
    for (std::size_t i = 0; i < n; ++i) images.push_back(sequence.load(i * size / n, width));
    return images;
  }
  const SimulatedCamera camera(kinectIntrinsics(), SimulatedNoise{}, kSeed);
  const DepthImage image = camera.render(clutteredRoom(kSeed), cameraPose(0.3, -0.2, 0.4), 0).depth;
  images.push_back(subsampled(image, subsamplingStep(image.camera, width)));
  return images;
}

// The images that the arguments of a benchmark name; without any, it is skipped.
std::vector<DepthImage> prepare(benchmark::State& state) {
  std::vector<DepthImage> images;
  try {
    images = imagesOf(static_cast<Source>(state.range(1)), static_cast<int>(state.range(0)));
    if (images.empty()) state.SkipWithError("set FACETLOC_BENCHMARK_SEQUENCE to a depth sequence");
  } catch (const std::exception& e) {
    state.SkipWithError(e.what());
  }
  return images;
}

std::vector<DisparityImage> disparitiesOf(const std::vector<DepthImage>& images) {
  std::vector<DisparityImage> disparities(images.size());
  for (std::size_t i = 0; i < images.size(); ++i)
    toDisparity(images[i], SensorNoise{}.inverse_depth_std, disparities[i]);
  return disparities;
}

// Times a function of each input in turn, which the images are or have been made into. Its result
// is counted under a name, as a mean.
template <class Input, class Function>
void time(benchmark::State& state, const std::vector<Input>& inputs, const Function& function,
          const std::string& counted = "") {
  std::size_t next = 0;
  double sum = 0;
  for (auto _ : state) {
    sum += static_cast<double>(function(inputs[next]));
    next = (next + 1) % inputs.size();
  }
  if (!counted.empty()) state.counters[counted] = benchmark::Counter(sum, benchmark::Counter::kAvgIterations);
  const std::int64_t width = state.range(0), pixels = state.iterations() * width * (width * 3 / 4);
  state.SetItemsProcessed(pixels);
  state.SetBytesProcessed(pixels * static_cast<std::int64_t>(sizeof(float)));
}

void images(benchmark::internal::Benchmark* b) {
  b->ArgNames({"width", "real"})->ArgsProduct({{320, 640}, {kSimulated, kReal}});
  b->Unit(benchmark::kMillisecond);
}

void yardstickMoments(benchmark::State& state) {
  time(state, prepare(state), [](const DepthImage& image) {
    PlaneMoments m;
    for (int v = 0, i = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u, ++i)
        if (image.depth[i] > 0) m.add(u, v, 1.0 / image.depth[i]);
    benchmark::DoNotOptimize(m);
    return m.n;
  });
}
BENCHMARK(yardstickMoments)->Apply(images);

void yardstickPcl(benchmark::State& state) {
  std::vector<pcl::PointCloud<pcl::PointXYZ>::ConstPtr> clouds;
  for (const DepthImage& image : prepare(state)) clouds.push_back(test::organizedCloud<pcl::PointXYZ>(image));
  const double min_inliers = 150 * std::pow(static_cast<double>(state.range(0)) / 320, 2);
  const auto segment = [&](const auto& cloud) {
    return planesByPcl(cloud, static_cast<unsigned>(min_inliers)).maxLabel();
  };
  time(state, clouds, segment, "segments");
}
BENCHMARK(yardstickPcl)->Apply(images);

void noise(benchmark::State& state) {
  std::vector<float> scratch;
  time(state, prepare(state), [&](const DepthImage& image) {
    return estimateNoise(image, SensorNoise{}.inverse_depth_std, scratch);
  });
}
BENCHMARK(noise)->Apply(images);

void split(benchmark::State& state) {
  QuadTree tree;
  const auto compute = [&](const DisparityImage& image) {
    tree.compute(image);
    return tree.leaves().size();
  };
  time(state, disparitiesOf(prepare(state)), compute, "leaves");
}
BENCHMARK(split)->Apply(images);

void splitByTriangles(benchmark::State& state) {
  DepthTriangulation triangulation;
  const auto compute = [&](const DisparityImage& image) {
    triangulation.compute(image);
    return triangulation.triangles().size();
  };
  time(state, disparitiesOf(prepare(state)), compute, "leaves");
}
BENCHMARK(splitByTriangles)->Apply(images);

template <class Split>
void mergeLeavesOf(benchmark::State& state) {
  struct Input {
    const DisparityImage* image;
    Split split;
  };
  const std::vector<DisparityImage> disparities = disparitiesOf(prepare(state));
  std::vector<Input> inputs;
  for (const DisparityImage& image : disparities) {
    inputs.push_back({&image, Split()});
    inputs.back().split.compute(image);
  }
  RegionMerging merging;
  const auto compute = [&](const Input& input) {
    merging.compute(input.split, *input.image);
    return merging.regions().size();
  };
  time(state, inputs, compute, "regions");
}
void merge(benchmark::State& state) { mergeLeavesOf<QuadTree>(state); }
BENCHMARK(merge)->Apply(images);
void mergeTriangles(benchmark::State& state) { mergeLeavesOf<DepthTriangulation>(state); }
BENCHMARK(mergeTriangles)->Apply(images);

void features(benchmark::State& state) {
  struct Input {
    DepthImage image;
    LabelledPlanes planes;
  };
  std::vector<Input> inputs;
  for (const DepthImage& image : prepare(state)) {
    inputs.push_back({image, {}});
    PlaneSegmenter().segment(image, inputs.back().planes);
  }
  SegmentEstimation estimation;
  std::vector<Segment> segments;
  std::vector<int> kept;
  DepthPicture picture;
  const auto estimate = [&](const Input& input) {
    estimation.estimate(input.image, input.planes.labels, {}, segments, kept);
    picture.assign(input.image);
    return segments.size();
  };
  time(state, inputs, estimate, "segments");
}
BENCHMARK(features)->Apply(images);

ViewParams paramsOf(SplitMethod method) {
  ViewParams params;
  params.split.method = method;
  return params;
}

void segment(benchmark::State& state, SplitMethod method) {
  PlaneSegmenter segmenter(paramsOf(method));
  LabelledPlanes result;
  const auto segment = [&](const DepthImage& image) {
    segmenter.segment(image, result);
    return result.planes.size();
  };
  time(state, prepare(state), segment, "regions");
}
void segmentation(benchmark::State& state) { segment(state, SplitMethod::quadtree); }
BENCHMARK(segmentation)->Apply(images);
void segmentationByTriangles(benchmark::State& state) { segment(state, SplitMethod::delaunay); }
BENCHMARK(segmentationByTriangles)->Apply(images);

void buildView(benchmark::State& state, SplitMethod method) {
  ViewBuilder builder({}, paramsOf(method));
  View view;
  const auto build = [&](const DepthImage& image) {
    builder.build(image, view);
    return view.segments.size();
  };
  time(state, prepare(state), build, "segments");
}
void segmentationAndFeatures(benchmark::State& state) { buildView(state, SplitMethod::quadtree); }
BENCHMARK(segmentationAndFeatures)->Apply(images);
void segmentationAndFeaturesByTriangles(benchmark::State& state) { buildView(state, SplitMethod::delaunay); }
BENCHMARK(segmentationAndFeaturesByTriangles)->Apply(images);

}  // namespace

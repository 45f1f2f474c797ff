// SPDX-License-Identifier: BSD-3-Clause
//
// Planes found in cluttered simulated rooms, by the rendered truth.
//
//   score_clutter [--width=320] [--GROUP.PARAMETER=VALUE ...]
//
// A true region is a connected set of measured pixels of one true plane, of at least 150 px at 320x240. It is
// found if a segment covers 80 % of it and lies in it to 80 %. The truth knows no border finer than the
// camera's silhouettes, which waver by half a pixel.
#include "cluttered_room.h"
#include "programs.h"

#include <facetloc/segmentation/plane_segmenter.h>
#include <facetloc/testing/overlap_score.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
using namespace facetloc::benchmarks;

constexpr int kRooms = 20, kViews = 3;
constexpr double kMinRegion = 150;  // [px at 320x240]

// Every step-th label of every step-th row.
Raster<std::uint16_t> subsampledTruth(const LabelImage& labels, int step) {
  Raster<std::uint16_t> out;
  out.width = labels.width / step, out.height = labels.height / step;
  for (int v = 0; v < out.height; ++v)
    for (int u = 0; u < out.width; ++u)
      out.data.push_back(labels.label[std::size_t(v) * step * labels.width + std::size_t(u) * step]);
  return out;
}

// Numbers the connected sets of equal planes from 1 on, row by row; 0 = not measured.
Raster<std::uint16_t> connectedRegions(const Raster<std::uint16_t>& plane, const DepthImage& depth) {
  const int w = plane.width, h = plane.height;
  Raster<std::uint16_t> region = plane;
  region.data.assign(plane.data.size(), 0);
  const auto counts = [&](int i) { return plane.data[i] != 0 && isMeasured(depth.depth[i]); };
  std::uint16_t last = 0;
  std::vector<int> stack;
  for (int start = 0; start < w * h; ++start) {
    if (region.data[start] != 0 || !counts(start)) continue;
    region.data[start] = ++last;
    stack.assign(1, start);
    while (!stack.empty()) {
      const int i = stack.back(), u = i % w, v = i / w;
      stack.pop_back();
      const auto visit = [&](int j) {
        if (region.data[j] != 0 || !counts(j) || plane.data[j] != plane.data[i]) return;
        region.data[j] = last;
        stack.push_back(j);
      };
      if (u > 0) visit(i - 1);
      if (u + 1 < w) visit(i + 1);
      if (v > 0) visit(i - w);
      if (v + 1 < h) visit(i + w);
    }
  }
  return region;
}

test::OverlapScore scoreOf(int room, int view, int width, const SegmentationParams& params) {
  const std::uint64_t seed = kSeed + room;
  const SimulatedCamera camera(kinectIntrinsics(), SimulatedNoise{}, seed);
  const SimulatedFrame frame =
      camera.render(clutteredRoom(seed), cameraPose(0.3, -0.2, 0.4 + view * 2 * M_PI / kViews), view);
  const int step = subsamplingStep(frame.depth.camera, width);
  const DepthImage image = subsampled(frame.depth, step);
  LabelledPlanes found;
  PlaneSegmenter(params).segment(image, found);
  return test::overlapScore(found.labels, connectedRegions(subsampledTruth(frame.labels, step), image), 1,
                            static_cast<int>(scaledPixels(kMinRegion, image.camera)));
}

void run(int argc, char** argv) {
  int width = 320;
  SegmentationParams params;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("--width=", 0) == 0)
      width = std::atoi(argument.c_str() + 8);
    else if (!setByArgument(params, argument))
      throw Usage{"score_clutter [--width=320] [--GROUP.PARAMETER=VALUE ...]"};
  }
  std::vector<test::OverlapScore> scores(kRooms * kViews);
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < kRooms * kViews; ++i) scores[i] = scoreOf(i / kViews, i % kViews, width, params);
  test::OverlapScore sum;
  for (const test::OverlapScore& score : scores) sum += score;
  std::printf("found %d of %d planes: %.1f %%; %d segments, of which %.2f are one\n", sum.correct,
              sum.regions, 100 * sum.rate(), sum.segments, sum.precision());
}

}  // namespace

int main(int argc, char** argv) {
  return runProgram("score_clutter", [&] { run(argc, argv); });
}

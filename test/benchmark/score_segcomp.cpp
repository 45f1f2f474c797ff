// SPDX-License-Identifier: BSD-3-Clause
//
// Correct-segmentation rate on range images of the SegComp benchmark.
//
//   score_segcomp FOLDER [SIGMA] [--GROUP.PARAMETER=VALUE ...]
//
// FOLDER holds calibration.csv, depth/ and labels/; SIGMA: noise of inverse depth [1/m]. A noise region is a
// segment that is no region of the truth, or not to 80 %.
#include "programs.h"

#include <facetloc/segmentation/plane_segmenter.h>
#include <facetloc/testing/overlap_score.h>
#include <facetloc/testing/segcomp.h>

#include <cstdio>
#include <cstdlib>

namespace {

using namespace facetloc;

void run(int argc, char** argv) {
  if (argc < 2) throw benchmarks::Usage{"score_segcomp FOLDER [SIGMA] [--GROUP.PARAMETER=VALUE ...]"};
  constexpr double kMinRegion = 100;  // smaller regions are not scored [px]
  SensorNoise noise;
  SegmentationParams params;
  for (int i = 2; i < argc; ++i)
    if (!benchmarks::setByArgument(params, argv[i])) noise.inverse_depth_std = std::atof(argv[i]);

  test::OverlapScore sum;
  const auto images = test::readSegComp(argv[1]);
  std::printf("image                regions correct segments\n");
  for (const test::SegCompImage& image : images) {
    params.labels.min_support = kMinRegion / scaledPixels(1, image.depth.camera);
    LabelledPlanes found;
    PlaneSegmenter(params, noise).segment(image.depth, found);
    const test::OverlapScore score = test::overlapScore(found.labels, image.truth);
    std::printf("%-20s %7d %7d %8d\n", image.name.c_str(), score.regions, score.correct, score.segments);
    sum += score;
  }
  std::printf(
      "correct %d of %d regions in %zu images: %.1f %%; %.2f of the segments, %.2f noise regions an image\n",
      sum.correct, sum.regions, images.size(), 100 * sum.rate(), sum.precision(),
      (sum.segments - sum.correct) / static_cast<double>(images.size()));
}

}  // namespace

int main(int argc, char** argv) {
  return benchmarks::runProgram("score_segcomp", [&] { run(argc, argv); });
}

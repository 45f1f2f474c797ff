// SPDX-License-Identifier: BSD-3-Clause
//
// Correct-segmentation rate on range images of the SegComp benchmark (Hoover et al. 1996): a region is
// correctly segmented if one segment covers at least 80 % of it and is covered by it to at least 80 %.
//
//   score_segcomp FOLDER [SIGMA]     FOLDER holds calibration.csv, depth/ and labels/; SIGMA: noise of
//   inverse depth [1/m]
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

namespace {

using namespace facetloc;

constexpr int kFirstPlane = 10;  // labels below mean noise, shadow, background
constexpr int kMinRegion = 100;  // smaller regions are not scored [px]
constexpr double kOverlap = 0.8;

struct Count {
  int regions = 0, correct = 0, segments = 0;
};

Count score(const LabelImage& found, const Raster<std::uint16_t>& truth) {
  std::map<int, int> size_true, size_found;
  std::map<std::pair<int, int>, int> shared;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    const int t = truth.data[i], f = found.label[i];
    if (t >= kFirstPlane) ++size_true[t];
    if (f) ++size_found[f];
    if (t >= kFirstPlane && f) ++shared[{t, f}];
  }
  Count c;
  c.segments = static_cast<int>(size_found.size());
  for (const auto& [t, size] : size_true) c.regions += size >= kMinRegion;
  for (const auto& [pair, n] : shared)
    if (size_true[pair.first] >= kMinRegion && n >= kOverlap * size_true[pair.first] &&
        n >= kOverlap * size_found[pair.second])
      ++c.correct;
  return c;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: score_segcomp FOLDER [SIGMA]\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  SensorNoise noise;
  SegmentationParams params;
  if (argc > 2) noise.inverse_depth_std = std::atof(argv[2]);

  std::ifstream calibration(folder / "calibration.csv");
  std::string line;
  std::getline(calibration, line);  // header: name,fx,fy,cx,cy,depth_scale
  Count sum;
  int images = 0;
  std::printf("image                regions correct segments  noise/sigma\n");
  while (std::getline(calibration, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::string name;
    CameraFile camera;
    fields >> name >> camera.intrinsics.fx >> camera.intrinsics.fy >> camera.intrinsics.cx >>
        camera.intrinsics.cy >> camera.depth_scale;
    const Raster<std::uint16_t> truth = readGreyPng(folder / "labels" / (name + ".png"));
    camera.intrinsics.width = truth.width;
    camera.intrinsics.height = truth.height;
    const DepthImage image = readDepthPng(folder / "depth" / (name + ".png"), camera);
    params.min_support =
        kMinRegion * 320.0 * 240.0 / (truth.width * truth.height);  // the benchmark's smallest region

    LabelledPlanes s;
    PlaneSegmenter(params, noise).segment(image, s);
    const Count c = score(s.labels, truth);
    std::printf("%-20s %7d %7d %8d %8.2f\n", name.c_str(), c.regions, c.correct, c.segments,
                s.noise / noise.inverse_depth_std);
    sum.regions += c.regions, sum.correct += c.correct, sum.segments += c.segments;
    ++images;
  }
  std::printf("correct %d of %d regions in %d images: %.1f %%\n", sum.correct, sum.regions, images,
              100.0 * sum.correct / std::max(1, sum.regions));
}

// SPDX-License-Identifier: BSD-3-Clause
//
// Do planar segments stay on one object? Ours beside those of PCL's OrganizedMultiPlaneSegmentation, of the
// same images in the same run.
//
//   score_segments FOLDER [--GROUP.PARAMETER=VALUE ...]
//
// FOLDER holds labelled clouds (PCD with the fields x, y, z and label, as those of mOSD in PCL's data
// repository), or a sequence with depth/ and label/ (16-bit PNG of the same names). Labels: object_score.h.
// Images are segmented at their full size, by all with the same smallest plane: segments of views are those
// that facetloc_segment writes, PlanarSegmentation has those too whose features say too little. A segment of
// at least 100 labelled pixels goes across objects if less than 90 % of these are on one.
#include "object_score.h"
#include "pcl_planes.h"
#include "programs.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/organized_clouds.h>

#include <pcl/io/pcd_io.h>

#include <cstdio>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;
using namespace facetloc::benchmarks;

Raster<std::uint16_t> labelsOfCloud(const fs::path& path) {
  pcl::PCLPointCloud2 stored;
  if (pcl::io::loadPCDFile(path.string(), stored) < 0)
    throw IoError(path.string(), "cannot be read as a PCD");
  if (pcl::getFieldIndex(stored, "label") < 0)
    throw IoError(path.string(), "has no field 'label': score_segments needs labelled clouds");
  pcl::PointCloud<pcl::PointXYZL> cloud;
  pcl::fromPCLPointCloud2(stored, cloud);
  Raster<std::uint16_t> labels;
  labels.width = static_cast<int>(cloud.width), labels.height = static_cast<int>(cloud.height);
  for (const pcl::PointXYZL& point : cloud) labels.data.push_back(static_cast<std::uint16_t>(point.label));
  return labels;
}

Raster<std::uint16_t> labelsOf(const FrameFile& frame, const fs::path& folder, const Intrinsics& image) {
  const bool cloud = frame.path.extension() == ".pcd";
  const fs::path path = cloud ? frame.path : folder / "label" / (frame.name + ".png");
  Raster<std::uint16_t> labels = cloud ? labelsOfCloud(path) : readGreyPng(path);
  if (labels.width != image.width || labels.height != image.height)
    throw IoError(path.string(), "its labels have another size than the depth image");
  return labels;
}

void print(const char* name, const ObjectScore& score) {
  std::printf("%-32s %7zu %9.1f %11zu %7.1f %% %9.2f %% %12.1f %%\n", name, score.images,
              static_cast<double>(score.segments) / static_cast<double>(score.images), score.across,
              percent(score.across, score.segments), percent(score.main_pixels, score.segment_pixels),
              percent(score.covered_pixels, score.object_pixels));
}

void run(int argc, char** argv) {
  ViewParams params;
  bool good = argc >= 2 && argv[1][0] != '-';
  for (int i = 2; i < argc; ++i) good = good && setByArgument(params, argv[i]);
  if (!good) throw Usage{"score_segments FOLDER [--GROUP.PARAMETER=VALUE ...]"};
  const fs::path folder = argv[1];
  const DepthSequence sequence = DepthSequence::open(folder);
  const Camera camera = sequence.camera() ? sequence.camera()->camera : Camera{};
  ViewBuilder views(camera, params);
  PlaneSegmenter segmenter(params, camera.noise);
  LabelledPlanes planes;
  ObjectScore of_views, of_planes, of_pcl;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const DepthImage image = sequence.load(i);
    const Raster<std::uint16_t> truth = labelsOf(sequence.frames()[i], folder, image.camera);
    views.build(image);
    of_views += objectScore(views.segmentation().labels, truth, image);
    segmenter.segment(image, planes);
    of_planes += objectScore(planes.labels, truth, image);
    const auto smallest = static_cast<unsigned>(scaledPixels(params.labels.min_support, image.camera));
    of_pcl += objectScore(planesByPcl(test::organizedCloud<pcl::PointXYZ>(image), smallest), truth, image);
  }
  std::printf("%-32s %7s %9s %11s %9s %11s %14s\n", "", "images", "segments", "across", "", "on the main",
              "object pixels");
  std::printf("%-32s %7s %9s %11s %9s %11s %14s\n", "", "", "an image", "objects", "", "object",
              "in segments");
  print("segments of views", of_views);
  print("PlanarSegmentation", of_planes);
  print("OrganizedMultiPlaneSegmentation", of_pcl);
}

}  // namespace

int main(int argc, char** argv) {
  return runProgram("score_segments", [&] { run(argc, argv); });
}

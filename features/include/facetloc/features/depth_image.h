// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief A depth image: z in metres, row-major, camera.width x camera.height; 0 = not measured. */
struct DepthImage {
  Intrinsics camera;
  std::vector<float> depth;

  bool empty() const { return depth.empty(); }
  /** \brief True if the camera is possible and there is one depth per pixel; other images count as empty. */
  bool valid() const {
    return camera.valid() && depth.size() == static_cast<std::size_t>(camera.width) * camera.height;
  }
  float at(int u, int v) const { return depth[static_cast<std::size_t>(v) * camera.width + u]; }
};

constexpr float kNearestMeasured = 1e-3f, kFarthestMeasured = 1e6f;  // [m]
/** \brief Is this a depth that a camera measured? 0, NaN, infinities and depths below 1 mm are not. */
inline bool isMeasured(float z) { return z >= kNearestMeasured && z <= kFarthestMeasured; }

/** \brief The median of the measured depths, of about a thousand pixels spread over the image [m];
 * DepthNoise::kUsualDepth if none is measured. */
double usualDepth(const DepthImage& image);

/** \brief Takes the depths beyond max_depth [m] out of an image. */
void dropBeyond(double max_depth, DepthImage& image);

/** \brief A number of pixels given for a 320x240 image, scaled with the area of another one. */
inline double scaledPixels(double pixels_at_320x240, const Intrinsics& camera) {
  return pixels_at_320x240 * (double(camera.width) * camera.height) / (320.0 * 240.0);
}

/** \brief Every step-th pixel of every step-th row. Never averages: that would invent depth at silhouettes.
 * If that lost a fifth of the measured pixels or more, since the camera leaves out pixels here and there, an
 * unmeasured pixel is replaced by the first measured one of its step x step block. */
DepthImage subsampled(const DepthImage& image, int step);

/** \brief How often the working width goes into the image's, which is a step that keeps at least that width;
 * 1 for smaller images and for a working width of 0. */
int subsamplingStep(const Intrinsics& camera, int working_width);

constexpr int kWorkingWidth = 320;  ///< at which images are segmented unless another is set [px]

/** \brief The image as it is segmented: subsampled so that at least working_width columns remain; as it is
 * for a working width of 0. */
DepthImage workingImage(const DepthImage& image, int working_width = kWorkingWidth);

/** \brief One label per pixel, row-major; 0 = none, k = k-th segment counted from 1. */
struct LabelImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> label;

  int maxLabel() const;
};

/** \brief Labels of all pixels of an image by those of its workingImage(). A measured pixel has the label of
 * the working pixel around it that is nearest in depth; an unmeasured one has none. Throws
 * std::invalid_argument if the labels are not of the working image's size. */
LabelImage fullLabels(const LabelImage& labels, const DepthImage& image, int working_width = kWorkingWidth);

/** \brief Reach of the holes of a depth image that was aligned to a finer one, which leaves pixels between
 * those that it fills: how far from a hole the measured pixels around it are, on all its sides [px]. 0 for
 * images without such a grid of holes: those of which fewer than half as many pixels are holes between
 * measured ones as are measured. */
int holeGridReach(const DepthImage& image);

/** \brief Fills the grid of holes: a hole takes the mean inverse depth of the measured pixels around it if
 * these are of one surface, or else the depth of the nearest one. Larger holes stay, and an image without a
 * grid of holes stays as it is. */
void fillHoleGrid(DepthImage& image);

/** \brief True if most measured pixels have measured ones to their right and below them, or if there are
 * hardly any. */
bool isDense(const DepthImage& image);

}  // namespace facetloc

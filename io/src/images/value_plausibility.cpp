// SPDX-License-Identifier: BSD-3-Clause
#include "images/value_plausibility.h"

#include "base/median.h"
#include "bytes/files.h"
#include "images/depth_file.h"

#include <facetloc/features/depth_image.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr std::size_t kMostImages = 16;
constexpr std::size_t kLeastImages = 3;    // that have to agree
constexpr std::size_t kLeastPixels = 100;  // measured pixels of an image that is judged

/** Do the values reach the largest one of an integer format, or 1, and come close to it before? */
template <typename Value>
bool isStretched(const std::vector<Value>& values, std::initializer_list<Value> limits) {
  constexpr double kClose = 0.9;
  Value largest = 0, next = 0;
  for (const Value value : values)
    if (value > largest)
      next = std::exchange(largest, value);
    else if (value > next && value < largest)
      next = value;
  return std::find(limits.begin(), limits.end(), largest) != limits.end() && next >= kClose * largest;
}

ValueImage valueImage(const DepthImage& depth) {
  ValueImage image;
  image.depth = workingImage(depth);
  for (const float z : image.depth.depth)
    if (isMeasured(z)) image.measured.push_back(z);
  return image;
}

bool hasOneValue(const ValueImage& image) {
  const auto [least, most] = std::minmax_element(image.measured.begin(), image.measured.end());
  return *least == *most;
}

void checkSingle(const std::vector<ValueImage>& images, Findings& found) {
  const auto n = static_cast<std::size_t>(std::count_if(images.begin(), images.end(), hasOneValue));
  if (n == 0) return;
  found.push_back(
      {"values.single",
       n == images.size() ? Severity::refusal : Severity::doubt,
       fmt::format("{} of {} images have one value in all their pixels, {:.3f} m in the first", n,
                   images.size(), std::find_if(images.begin(), images.end(), hasOneValue)->measured.front()),
       "such images show nothing; leave them out",
       {{"single", static_cast<double>(n)}, {"images", static_cast<double>(images.size())}}});
}

/** The noise of a camera never repeats. */
void checkFrozen(const std::vector<ValueImage>& images, Findings& found) {
  std::size_t again = 0, judged = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (hasOneValue(images[i])) continue;
    ++judged;
    again += std::any_of(images.begin(), images.begin() + static_cast<std::ptrdiff_t>(i),
                         [&](const ValueImage& other) { return other.depth.depth == images[i].depth.depth; });
  }
  if (again == 0) return;
  found.push_back(
      {"values.frozen",
       2 * again >= judged ? Severity::doubt : Severity::note,
       fmt::format("{} of {} images repeat an earlier one in every pixel: the recording stood still", again,
                   judged),
       "leave the repeated images out",
       {{"repeated", static_cast<double>(again)}, {"images", static_cast<double>(judged)}}});
}

bool checkStretched(const std::vector<ValueImage>& images, Findings& found) {
  const auto n = static_cast<std::size_t>(
      std::count_if(images.begin(), images.end(), [](const ValueImage& image) { return image.stretched; }));
  if (n < kLeastImages || 10 * n < 9 * images.size()) return false;
  found.push_back(
      {"values.stretched",
       Severity::refusal,
       fmt::format("each image is stretched to the range of its format: {} of {} reach its largest "
                   "value, so that the scale is another one in each",
                   n, images.size()),
       "save the images anew with one scale for all",
       {{"stretched", static_cast<double>(n)}, {"images", static_cast<double>(images.size())}}});
  return true;
}

/** All measured depths, sorted. */
std::vector<float> sortedDepths(const std::vector<ValueImage>& images) {
  std::vector<float> all;
  for (const ValueImage& image : images) all.insert(all.end(), image.measured.begin(), image.measured.end());
  std::sort(all.begin(), all.end());
  return all;
}

double quantile(const std::vector<float>& sorted, double q) {
  return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

bool checkBuffer(const std::vector<float>& sorted, Findings& found) {
  constexpr double kUsual = 0.9, kNearest = 0.5, kFarthest = 0.98;  // buffer values
  const double median = quantile(sorted, 0.5);
  if (sorted.back() > 1 || sorted.back() < kFarthest || median < kUsual || quantile(sorted, 0.01) < kNearest)
    return false;
  found.push_back(
      {"values.buffer",
       Severity::doubt,
       fmt::format(
           "all depths are between 0 and 1, half of them above {:.3f}: they seem to be the depth buffer "
           "of a renderer (OpenGL), not metres",
           median),
       "depth = near * far / (far - value * (far - near)), with the renderer's clipping planes, are metres",
       {{"median", median}, {"largest", sorted.back()}}});
  return true;
}

/** Medians of z z'' / (2 z'^2) along rows of each image: 1 on planes, whose inverse depth is linear in the
 * image; 0 for disparities; negative for a constant minus the depth. */
std::vector<double> curvatures(const std::vector<ValueImage>& images) {
  constexpr int kSpans = 40, kStep = 3;                // spans per width; pixels between rows
  constexpr double kLeastSlope = 0.2, kMostSlope = 1;  // change over five pixels, by the depth
  constexpr double kSteady = 2;                        // ratio of neighbouring changes
  constexpr std::size_t kLeast = 20;
  std::vector<double> medians;
  for (const ValueImage& image : images) {
    const Intrinsics& camera = image.depth.camera;
    const int span = std::max(2, camera.width / kSpans);
    std::vector<double> found;
    for (int v = 0; v < camera.height; v += kStep)
      for (int u = 0; u + 4 * span < camera.width; u += kStep) {
        double z[5];
        bool measured = true;
        for (int i = 0; i < 5; ++i) {
          z[i] = image.depth.at(u + i * span, v);
          measured = measured && isMeasured(static_cast<float>(z[i]));
        }
        const double change = z[4] - z[0], slope = std::abs(change) / z[2];
        if (!measured || slope < kLeastSlope || slope > kMostSlope) continue;
        bool steady = true;
        for (int i = 0; i < 4; ++i) {
          const double part = 4 * (z[i + 1] - z[i]) / change;
          steady = steady && part > 1 / kSteady && part < kSteady;
        }
        if (steady) found.push_back(2 * z[2] * (z[4] - 2 * z[2] + z[0]) / (change * change));
      }
    if (found.size() >= kLeast) medians.push_back(median(std::move(found)));
  }
  return medians;
}

void checkInverted(const std::vector<ValueImage>& images, Findings& found) {
  constexpr std::size_t kEnough = 6;  // images
  constexpr double kCertain = 5;      // standard deviations
  const std::vector<double> all = curvatures(images);
  if (all.size() < kEnough) return;
  const auto n = static_cast<double>(all.size());
  double mean = 0, squares = 0;
  for (const double c : all) mean += c / n;
  for (const double c : all) squares += (c - mean) * (c - mean);
  const double std = std::sqrt(squares / (n * (n - 1)));
  if (!(mean < -kCertain * std)) return;
  found.push_back(
      {"values.inverted",
       Severity::doubt,
       "surfaces are bent as if depths were stored as a constant minus the depth, larger where it is "
       "nearer",
       "subtract them from that constant",
       {{"curvature", mean, std}, {"images", n}}});
}

/** A limit that many pixels have exactly, nothing exceeds, and few come near to. */
struct Limit {
  float value = 0;
  double share = 0;  // share of the measured pixels
};

std::optional<Limit> limitOf(const std::vector<ValueImage>& images, const std::vector<float>& sorted,
                             bool largest) {
  constexpr double kLeastShare = 0.02, kSpike = 5;
  constexpr float kNear = 0.8F;  // ratio of depths
  const float limit = largest ? sorted.back() : sorted.front();
  std::size_t reached = 0;
  for (const ValueImage& image : images)
    reached += limit == (largest ? *std::max_element(image.measured.begin(), image.measured.end())
                                 : *std::min_element(image.measured.begin(), image.measured.end()));
  const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), limit);
  const double count = static_cast<double>(last - first), share = count / static_cast<double>(sorted.size());
  if (reached < kLeastImages || 2 * reached < images.size() || share < kLeastShare) return {};
  const auto from = largest ? std::lower_bound(sorted.begin(), sorted.end(), kNear * limit) : last;
  const auto to = largest ? first : std::upper_bound(sorted.begin(), sorted.end(), limit / kNear);
  for (auto level = from; level < to;) {
    const auto next = std::upper_bound(level, to, *level);
    if (kSpike * static_cast<double>(next - level) > count) return {};
    level = next;
  }
  return Limit{limit, share};
}

void checkLimits(const std::vector<ValueImage>& images, const std::vector<float>& sorted, double max_depth,
                 Findings& found) {
  constexpr double kBelow = 0.999;
  for (const bool largest : {true, false}) {
    const auto limit = limitOf(images, sorted, largest);
    if (!limit || limit->value > max_depth) continue;
    found.push_back(
        {"values.limit",
         Severity::doubt,
         fmt::format(
             "{:.0f} % of the measured pixels have exactly the {} depth, {:.3f} m: they were out of range, "
             "and not measured",
             100 * limit->share, largest ? "largest" : "smallest", limit->value),
         largest ? fmt::format("max_depth={:.3f} in camera.ini leaves them out", kBelow * limit->value)
                 : std::string("write 0 in their place"),
         {{"share", limit->share}, {"depth_m", limit->value}}});
  }
}

Findings judged(const std::vector<ValueImage>& images, double max_depth) {
  Findings found;
  if (images.empty()) return found;
  checkSingle(images, found);
  if (firstOf(found, Severity::refusal)) return found;
  checkFrozen(images, found);
  if (checkStretched(images, found)) return found;
  const std::vector<float> sorted = sortedDepths(images);
  if (checkBuffer(sorted, found)) return found;
  checkInverted(images, found);
  checkLimits(images, sorted, max_depth, found);
  return found;
}

}  // namespace

std::vector<std::size_t> valueSample(const DepthSequence& sequence) {
  const std::size_t all = sequence.frames().size();
  std::vector<std::size_t> numbers(std::min(all, kMostImages));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i * all / numbers.size();
  return numbers;
}

ValueImage ValueSample::read(const DepthSequence& sequence, std::size_t index,
                             const std::function<void(const Raster<std::uint16_t>&)>& take) {
  const auto& path = sequence.frames()[index].path;
  if (!isPng(path)) {
    const DepthImage depth = sequence.load(index);
    ValueImage image = valueImage(depth);
    image.stretched = isStretched<float>(depth.depth, {1.0F});
    return image;
  }
  constexpr int kBits = 16;
  Raster<std::uint16_t> values = readGreyPng(path, kBits);
  take(values);
  const bool stretched = isStretched<std::uint16_t>(values.data, {255, 65535});
  ValueImage image = valueImage(sequence.imageOf(index, storedIn(std::move(values))));
  image.stretched = stretched;
  return image;
}

ValueSample::ValueSample(const DepthSequence& sequence,
                         const std::function<void(const Raster<std::uint16_t>&)>& take)
    : max_depth_(sequence.camera() ? sequence.camera()->camera.max_depth
                                   : std::numeric_limits<double>::infinity()) {
  if (sequence.ofSegments()) return;
  for (const std::size_t index : valueSample(sequence)) {
    if (!std::filesystem::is_regular_file(sequence.frames()[index].path)) continue;  // a pipe is read once
    try {
      ValueImage image = read(sequence, index, take);
      if (image.measured.size() >= kLeastPixels) images_.push_back(std::move(image));
    } catch (const std::exception&) {  // the image is named when it is read for its content
    }
  }
}

Findings ValueSample::findings() const { return judged(images_, max_depth_); }

Findings valueFindings(const std::vector<DepthImage>& images, double max_depth) {
  std::vector<ValueImage> values;
  for (const DepthImage& image : images)
    if (ValueImage value = valueImage(image); value.measured.size() >= kLeastPixels)
      values.push_back(std::move(value));
  return judged(values, max_depth);
}

}  // namespace facetloc::internal

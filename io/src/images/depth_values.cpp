// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "images/depth_file.h"
#include "images/value_plausibility.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr std::size_t kValues = 65536;
constexpr int kLargestDivisor = 512;
constexpr double kMultiples = 0.98;          // share of the values
constexpr std::size_t kLeastDifferent = 20;  // values, of which a divisor says something

using Histogram = std::vector<std::size_t>;

bool isMeasured(std::uint16_t value) { return value != 0 && value != kNotMeasured; }

std::uint16_t swapped(std::uint16_t value) {
  return static_cast<std::uint16_t>((value >> 8) | ((value & 0xff) << 8));
}

/** Quantile of the values counted in a histogram; 0 if it is empty. */
double quantile(const Histogram& histogram, double q) {
  std::size_t all = 0, below = 0;
  for (const std::size_t n : histogram) all += n;
  for (std::size_t value = 0; value < histogram.size(); ++value)
    if ((below += histogram[value]) > q * static_cast<double>(all)) return static_cast<double>(value);
  return 0;
}

/** Counts the values of images, and the differences of neighbours. */
class Counter {
public:
  void add(const Raster<std::uint16_t>& image) {
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * image.width + u;
        const std::uint16_t value = image.data[i];
        if (!isMeasured(value)) continue;
        ++values_[value];
        if (u + 1 == image.width || !isMeasured(image.data[i + 1])) continue;
        const std::uint16_t next = image.data[i + 1];
        if (next == value) continue;  // as of most neighbours where a camera measures in coarse steps
        ++as_read_[static_cast<std::size_t>(std::abs(next - value))];
        ++with_swapped_[static_cast<std::size_t>(std::abs(swapped(next) - swapped(value)))];
      }
  }

  DepthValues result() && {
    DepthValues found;
    for (const std::size_t n : values_) found.count += n, found.different += n > 0;
    if (found.count == 0) return found;
    found.neighbours = quantile(as_read_, 0.5);
    found.neighbours_swapped = quantile(with_swapped_, 0.5);
    found.median = quantile(values_, 0.5);
    if (found.different >= kLeastDifferent) found.divisor = divisor(found.count);
    found.histogram = std::move(values_);
    return found;
  }

private:
  int divisor(std::size_t count) const {
    for (int divisor = kLargestDivisor; divisor > 1; --divisor) {
      std::size_t multiples = 0;
      for (std::size_t value = 0; value < kValues; value += static_cast<std::size_t>(divisor))
        multiples += values_[value];
      if (static_cast<double>(multiples) >= kMultiples * static_cast<double>(count)) return divisor;
    }
    return 1;
  }

  Histogram values_ = Histogram(kValues), as_read_ = Histogram(kValues), with_swapped_ = Histogram(kValues);
};

int bitsOf(int power_of_two) {
  int bits = 0;
  while ((1 << bits) < power_of_two) ++bits;
  return bits;
}

bool haveSwappedBytes(const DepthValues& values) {
  constexpr double kLeast = 64, kSmoother = 4;  // neighbours differ by a few values in any depth image
  return values.neighbours >= kLeast && kSmoother * values.neighbours_swapped < values.neighbours;
}

/** The fault revealed by the largest common divisor; nothing if it is usual. */
std::optional<Finding> divisorFinding(const DepthValues& values, double depth_scale, Severity severity) {
  constexpr double kCoarse = 0.0015;  // [m] devices have steps of up to 1 mm
  const int n = values.divisor;
  if (n < 2 || n / depth_scale < kCoarse) return {};
  const double step = 1e3 * n / depth_scale;
  Finding found{
      "values.steps",
      severity,
      fmt::format("PNG values are multiples of {}, so that depths come in steps of {:.3g} mm", n, step),
      "",
      {{"divisor", static_cast<double>(n)}, {"step_mm", step}}};
  found.words += n == 256 || n == 257
                     ? ": they have been made of images of 8 bits, which cannot hold depths; take the "
                       "original ones"
                     : fmt::format(": depth_scale is probably {}{}", 1000 * n,
                                   (n & (n - 1)) == 0  // a power of two
                                       ? fmt::format(" (or the bits are shifted or rotated by {})", bitsOf(n))
                                       : std::string());
  return found;
}

}  // namespace

DepthValues depthValues(const DepthSequence& sequence) {
  Counter counter;
  for (const std::size_t index : internal::valueSample(sequence)) {
    const auto& path = sequence.frames()[index].path;
    if (!internal::isPng(path) || !std::filesystem::is_regular_file(path)) continue;  // a pipe is read once
    try {
      constexpr int kBits = 16;
      counter.add(readGreyPng(path, kBits));
    } catch (const IoError&) {  // the image is named when it is read as one
    }
  }
  return std::move(counter).result();
}

std::optional<Finding> opticsFinding(const Intrinsics& camera) {
  constexpr double kMostTangent = 3.73;  // tangent of half the field of view
  constexpr double kBorder = 0.1;        // share of the image
  constexpr double kTwice = 0.8;         // share of the image, about the centre of one of twice the size
  if (!camera.valid()) return {};        // clouds have none
  const double x = (camera.cx + 0.5) / camera.width, y = (camera.cy + 0.5) / camera.height;
  if (camera.width > 2 * kMostTangent * camera.fx || camera.height > 2 * kMostTangent * camera.fy)
    return Finding{"camera.field_of_view",
                   Severity::refusal,
                   fmt::format("fx = {:.4g} and fy = {:.4g} are a field of view beyond 150 deg: they are in "
                               "pixels, not in widths of the image or millimetres",
                               camera.fx, camera.fy),
                   "",
                   {{"fx", camera.fx}, {"fy", camera.fy}}};
  if (std::min({x, y, 1 - x, 1 - y}) >= kBorder) return {};
  return Finding{
      "camera.centre",
      Severity::refusal,
      fmt::format(
          "the optical axis, cx = {:.4g} and cy = {:.4g}, leaves the image of {}x{} at its border{}",
          camera.cx, camera.cy, camera.width, camera.height,
          x > kTwice && y > kTwice
              ? fmt::format(": the calibration is probably of images of {}x{}; halve fx, fy, cx and cy",
                            2 * camera.width, 2 * camera.height)
              : ": is the calibration of these images?"),
      "",
      {{"cx", camera.cx}, {"cy", camera.cy}}};
}

ValueCheck checkValues(DepthValues values, double depth_scale) {
  constexpr double kFar = 10;                      // [m]
  constexpr double kManyFar = 0.25;                // share of the pixels
  constexpr double kLeastMedian = 0.25;            // [m]
  constexpr double kNoCamera = 0.1, kNoRoom = 30;  // [m] medians of no recording
  constexpr double k8Bits = 256;
  ValueCheck check;
  check.values = std::move(values);
  const DepthValues& found = check.values;
  if (found.count == 0) return check;
  std::size_t far = 0;
  for (std::size_t value = 0; value < kValues; ++value)
    if (static_cast<double>(value) > kFar * depth_scale) far += found.histogram[value];
  check.share_beyond_10m = static_cast<double>(far) / static_cast<double>(found.count);
  check.median_depth = found.median / depth_scale;
  if (haveSwappedBytes(found)) {
    check.findings.push_back(
        {"values.bytes",
         Severity::refusal,
         fmt::format("the bytes of the PNG values are swapped: neighbouring pixels differ by {:.0f} values, "
                     "and by {:.0f} with the bytes in the other order",
                     found.neighbours, found.neighbours_swapped),
         "PNG is big-endian, write the images anew",
         {{"neighbours", found.neighbours}, {"neighbours_swapped", found.neighbours_swapped}}});
    return check;
  }
  const bool is_far = check.share_beyond_10m > kManyFar;
  const bool is_impossible = check.median_depth < kNoCamera || check.median_depth > kNoRoom;
  if (auto divisor =
          divisorFinding(found, depth_scale, is_far || is_impossible ? Severity::refusal : Severity::doubt))
    check.findings.push_back(std::move(*divisor));
  if (quantile(found.histogram, 0.999) < k8Bits && check.median_depth > kLeastMedian)
    check.findings.push_back({"values.bits", Severity::doubt,
                              "all PNG values are below 256: depths have been cut down to 8 bits",
                              "take the original ones"});
  const auto scale = [&](std::string words) {
    check.findings.push_back(
        {"values.scale",
         is_impossible ? Severity::refusal : Severity::doubt,
         std::move(words) + ": is depth_scale right? (--depth-scale tries another one)",
         "",
         {{"median_depth", check.median_depth}, {"share_beyond_10m", check.share_beyond_10m}}});
  };
  if (check.median_depth < kLeastMedian)
    scale(fmt::format("half of the depths are below {:.2f} m, nearer than depth cameras measure",
                      check.median_depth));
  else if (is_far)
    scale(fmt::format("{:.0f} % of the depths are beyond 10 m, farther than depth cameras measure",
                      100 * check.share_beyond_10m));
  return check;
}

Findings depthFindings(const std::vector<DepthImage>& images, double max_depth) {
  constexpr double kMillimetres = 1000, kLargest = kNotMeasured - 1;
  Counter counter;
  for (const DepthImage& image : images) {
    Raster<std::uint16_t> values{image.camera.width, image.camera.height, 1, {}};
    for (const float z : image.depth)
      values.data.push_back(facetloc::isMeasured(z) ? static_cast<std::uint16_t>(
                                                          std::lround(std::min(kMillimetres * z, kLargest)))
                                                    : std::uint16_t{0});
    counter.add(values);
  }
  Findings all;
  for (Finding& finding : checkValues(std::move(counter).result(), kMillimetres).findings)
    if (finding.id == "values.scale") all.push_back(std::move(finding));
  append(internal::valueFindings(images, max_depth), all);
  return all;
}

Findings readingFindings(const DepthSequence& sequence) {
  Findings all;
  for (const std::string& remark : sequence.remarks())
    all.push_back({"reading.remark", Severity::note, remark, ""});
  Counter counter;
  const internal::ValueSample sample(
      sequence, [&counter](const Raster<std::uint16_t>& values) { counter.add(values); });
  if (const auto& file = sequence.camera()) {
    if (auto optics = opticsFinding(file->camera.intrinsics)) all.push_back(std::move(*optics));
    append(checkValues(std::move(counter).result(), file->depth_scale).findings, all);
  }
  if (!firstOf(all, Severity::refusal)) append(sample.findings(), all);
  return all;
}

}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "bytes/files.h"
#include "images/depth_file.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <initializer_list>
#include <limits>
#include <utility>

namespace facetloc {

/** The depth of an image of a sequence whose stored values have been read. */
class internal::ValueSample {
public:
  static DepthImage depth(const DepthSequence& sequence, std::size_t index, Raster<std::uint16_t> values) {
    return sequence.imageOf(index, storedIn(std::move(values)));
  }
};

namespace {

constexpr std::size_t kValues = 65536;
constexpr int kLargestDivisor = 512;
constexpr double kMultiples = 0.98;          // share of the values
constexpr std::size_t kLeastDifferent = 20;  // values, of which a divisor says something

using Histogram = std::vector<std::size_t>;

bool isDepth(std::uint16_t value) { return value != 0 && value != kNotMeasured; }

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

/** The raw values of depth PNGs: of pixels that are measured, and the differences of neighbours. */
class DepthValues {
public:
  void add(const Raster<std::uint16_t>& image) {
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * image.width + u;
        const std::uint16_t value = image.data[i];
        if (!isDepth(value)) continue;
        ++values_[value];
        if (u + 1 == image.width || !isDepth(image.data[i + 1])) continue;
        const std::uint16_t next = image.data[i + 1];
        if (next == value) continue;  // as of most neighbours where a camera measures in coarse steps
        ++as_read_[static_cast<std::size_t>(std::abs(next - value))];
        ++with_swapped_[static_cast<std::size_t>(std::abs(swapped(next) - swapped(value)))];
      }
  }

  /** Number of measured pixels with values above a limit. */
  std::size_t count(double limit = 0) const {
    std::size_t count = 0;
    for (std::size_t value = 0; value < kValues; ++value)
      if (static_cast<double>(value) > limit) count += values_[value];
    return count;
  }
  /** Quantile of the values; 0 without any. */
  double valueAt(double q) const { return quantile(values_, q); }
  /** Median difference of neighbouring pixels that differ. */
  double neighbours() const { return quantile(as_read_, 0.5); }
  /** The same with the two bytes of each value swapped. */
  double neighboursSwapped() const { return quantile(with_swapped_, 0.5); }

  /** Largest number of which 98 % of the values are multiples. */
  int divisor() const {
    const auto different =
        kValues - static_cast<std::size_t>(std::count(values_.begin(), values_.end(), std::size_t{0}));
    const std::size_t all = count();
    for (int divisor = kLargestDivisor; divisor > 1 && different >= kLeastDifferent; --divisor) {
      std::size_t multiples = 0;
      for (std::size_t value = 0; value < kValues; value += static_cast<std::size_t>(divisor))
        multiples += values_[value];
      if (static_cast<double>(multiples) >= kMultiples * static_cast<double>(all)) return divisor;
    }
    return 1;
  }

private:
  Histogram values_ = Histogram(kValues), as_read_ = Histogram(kValues), with_swapped_ = Histogram(kValues);
};

/** The fault revealed by the largest common divisor; nothing if it is usual. */
std::optional<Finding> divisorFinding(const DepthValues& values, double depth_scale, Severity severity) {
  constexpr double kCoarse = 0.0015;  // [m] devices have steps of up to 1 mm
  const int n = values.divisor();
  if (n < 2 || n / depth_scale < kCoarse) return {};
  const double step = 1e3 * n / depth_scale;
  Finding found{
      "values.steps",
      severity,
      fmt::format("PNG values are multiples of {}, so that depths come in steps of {:.3g} mm", n, step),
      "",
      {{"divisor", static_cast<double>(n)}, {"step_mm", step}}};
  found.words +=
      n == 256 || n == 257
          ? ": they have been made of images of 8 bits, which cannot hold depths; take the "
            "original ones"
          : fmt::format(": depth_scale is probably {}{}", 1000 * n,
                        (n & (n - 1)) == 0  // a power of two
                            ? fmt::format(" (or the bits are shifted or rotated by {})", std::ilogb(n))
                            : std::string());
  return found;
}

/** Judges values: swapped bytes, shifted bits, 8 bits in place of 16, a wrong depth_scale.
 * \param depth_scale values per metre */
Findings valuesFindings(const DepthValues& values, double depth_scale) {
  constexpr double kFar = 10;                      // [m]
  constexpr double kManyFar = 0.25;                // share of the pixels
  constexpr double kLeastMedian = 0.25;            // [m]
  constexpr double kNoCamera = 0.1, kNoRoom = 30;  // [m] medians of no recording
  constexpr double k8Bits = 256;
  constexpr double kSteep = 64, kSmoother = 4;  // neighbours differ by a few values in any depth image
  Findings all;
  const auto count = static_cast<double>(values.count());
  if (count == 0) return all;
  const double share_beyond_10m = static_cast<double>(values.count(kFar * depth_scale)) / count;
  const double median_depth = values.valueAt(0.5) / depth_scale;
  const double neighbours = values.neighbours(), neighbours_swapped = values.neighboursSwapped();
  if (neighbours >= kSteep && kSmoother * neighbours_swapped < neighbours) {
    all.push_back(
        {"values.bytes",
         Severity::refusal,
         fmt::format("the bytes of the PNG values are swapped: neighbouring pixels differ by {:.0f} values, "
                     "and by {:.0f} with the bytes in the other order",
                     neighbours, neighbours_swapped),
         "PNG is big-endian, write the images anew",
         {{"neighbours", neighbours}, {"neighbours_swapped", neighbours_swapped}}});
    return all;
  }
  const bool is_far = share_beyond_10m > kManyFar;
  const bool is_impossible = median_depth < kNoCamera || median_depth > kNoRoom;
  if (auto divisor =
          divisorFinding(values, depth_scale, is_far || is_impossible ? Severity::refusal : Severity::doubt))
    all.push_back(std::move(*divisor));
  if (values.valueAt(0.999) < k8Bits && median_depth > kLeastMedian)
    all.push_back({"values.bits", Severity::doubt,
                   "all PNG values are below 256: depths have been cut down to 8 bits",
                   "take the original ones"});
  const auto scale = [&](std::string words) {
    all.push_back({"values.scale",
                   is_impossible ? Severity::refusal : Severity::doubt,
                   std::move(words) + ": is depth_scale right? (--depth-scale tries another one)",
                   "",
                   {{"median_depth", median_depth}, {"share_beyond_10m", share_beyond_10m}}});
  };
  if (median_depth < kLeastMedian)
    scale(fmt::format("half of the depths are below {:.2f} m, nearer than depth cameras measure",
                      median_depth));
  else if (is_far)
    scale(fmt::format("{:.0f} % of the depths are beyond 10 m, farther than depth cameras measure",
                      100 * share_beyond_10m));
  return all;
}

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

/** An image for findings on its values. */
struct ValueImage {
  DepthImage depth;        ///< as stored, at the working width, without max_depth
  bool stretched = false;  ///< to the range of its format
  std::vector<float> measured;
};

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
    if (found.size() >= kLeast) medians.push_back(internal::median(std::move(found)));
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

/** Findings on the depths, whatever their format, that no calibration explains: one value everywhere, the
 * same image again, images stretched to the range of their format, depth buffers, depths that grow towards
 * the camera, and limits stored as depths. */
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

/** The numbers of up to 16 images of a sequence, in its order. */
std::vector<std::size_t> valueSample(const DepthSequence& sequence) {
  const std::size_t all = sequence.frames().size();
  std::vector<std::size_t> numbers(std::min(all, kMostImages));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i * all / numbers.size();
  return numbers;
}

/** \param take receives the values of a PNG */
ValueImage readImage(const DepthSequence& sequence, std::size_t index,
                     const std::function<void(const Raster<std::uint16_t>&)>& take) {
  const auto& path = sequence.frames()[index].path;
  if (!internal::isPng(path)) {
    const DepthImage depth = sequence.load(index);
    ValueImage image = valueImage(depth);
    image.stretched = isStretched<float>(depth.depth, {1.0F});
    return image;
  }
  constexpr int kBits = 16;
  Raster<std::uint16_t> values = readGreyPng(path, kBits);
  take(values);
  const bool stretched = isStretched<std::uint16_t>(values.data, {255, 65535});
  ValueImage image = valueImage(internal::ValueSample::depth(sequence, index, std::move(values)));
  image.stretched = stretched;
  return image;
}

/** Up to 16 images of a sequence, each read once for all findings on their values; those that cannot be read
 * are left out. \param take receives the values of each PNG */
std::vector<ValueImage> sampledImages(const DepthSequence& sequence,
                                      const std::function<void(const Raster<std::uint16_t>&)>& take) {
  std::vector<ValueImage> images;
  if (sequence.ofSegments()) return images;
  for (const std::size_t index : valueSample(sequence)) {
    if (!fs::is_regular_file(sequence.frames()[index].path)) continue;  // a pipe is read once
    try {
      ValueImage image = readImage(sequence, index, take);
      if (image.measured.size() >= kLeastPixels) images.push_back(std::move(image));
    } catch (const std::exception&) {  // the image is named when it is read for its content
    }
  }
  return images;
}

/** The same findings on images that are in memory, whose format is not known. */
Findings valueFindings(const std::vector<DepthImage>& images, double max_depth) {
  std::vector<ValueImage> values;
  for (const DepthImage& image : images)
    if (ValueImage value = valueImage(image); value.measured.size() >= kLeastPixels)
      values.push_back(std::move(value));
  return judged(values, max_depth);
}

}  // namespace

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

Findings depthFindings(const std::vector<DepthImage>& images, double max_depth) {
  constexpr double kMillimetres = 1000, kLargest = kNotMeasured - 1;
  DepthValues values;
  for (const DepthImage& image : images) {
    Raster<std::uint16_t> raster{image.camera.width, image.camera.height, 1, {}};
    for (const float z : image.depth)
      raster.data.push_back(
          isMeasured(z) ? static_cast<std::uint16_t>(std::lround(std::min(kMillimetres * z, kLargest)))
                        : std::uint16_t{0});
    values.add(raster);
  }
  Findings all;
  for (Finding& finding : valuesFindings(values, kMillimetres))
    if (finding.id == "values.scale") all.push_back(std::move(finding));
  append(valueFindings(images, max_depth), all);
  return all;
}

Findings readingFindings(const DepthSequence& sequence) {
  Findings all;
  for (const std::string& remark : sequence.remarks())
    all.push_back({"reading.remark", Severity::note, remark, ""});
  DepthValues values;
  const std::vector<ValueImage> images =
      sampledImages(sequence, [&values](const Raster<std::uint16_t>& image) { values.add(image); });
  double max_depth = std::numeric_limits<double>::infinity();
  if (const auto& file = sequence.camera()) {
    max_depth = file->camera.max_depth;
    if (auto optics = opticsFinding(file->camera.intrinsics)) all.push_back(std::move(*optics));
    append(valuesFindings(values, file->depth_scale), all);
  }
  if (!firstOf(all, Severity::refusal)) append(judged(images, max_depth), all);
  return all;
}

}  // namespace facetloc

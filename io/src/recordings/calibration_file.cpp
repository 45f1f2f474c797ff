// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/yaml_entries.h"
#include "recordings/recording_layout.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <initializer_list>
#include <stdexcept>

namespace facetloc::internal {
namespace {

using Names = std::initializer_list<const char*>;

class CalibrationReader {
public:
  CalibrationReader(std::vector<YamlEntry> entries, const std::string& source)
      : entries_(std::move(entries)), source_(source) {}

  std::optional<Calibration> read() const {
    Calibration found;
    if (!findIntrinsics(found.intrinsics)) return {};
    if (const auto resolution = list({"resolution", "image_size", "imagesize"}); resolution.size() == 2)
      found.intrinsics.width = side(resolution[0]), found.intrinsics.height = side(resolution[1]);
    if (const auto w = number({"image_width", "width", "w"})) found.intrinsics.width = side(*w);
    if (const auto h = number({"image_height", "height", "h"})) found.intrinsics.height = side(*h);
    if (const auto scale =
            number({"depth_scale", "depthmapfactor", "depth_factor", "png_depth_scale", "scale"});
        scale && *scale > 1)
      found.depth_scale = *scale;
    found.of_scanner = find({"cameraposearframe", "transform_matrix"}) != nullptr;
    if (found.of_scanner) found.depth_scale.reset();  // their scale is the scene's
    try {
      found.lens = lens();
    } catch (const std::invalid_argument& e) {
      throw IoError(source_, e.what());
    }
    return found;
  }

private:
  static int side(double value) {
    constexpr double kLargest = 65535;
    return value >= 1 && value <= kLargest && value == std::floor(value) ? static_cast<int>(value) : 0;
  }

  const YamlEntry* find(Names names) const {
    for (const char* name : names)
      for (const YamlEntry& entry : entries_)
        if (entry.key == name) return &entry;
    return nullptr;
  }
  std::optional<double> number(Names names) const {
    const YamlEntry* entry = find(names);
    return entry && entry->numbers.size() == 1 ? std::optional(entry->numbers[0]) : std::nullopt;
  }
  std::string word(Names names) const {
    const YamlEntry* entry = find(names);
    return entry && !entry->words.empty() ? entry->words.back() : std::string();
  }

  /** Behind the key, or behind the key "data" of the matrix that it is. */
  std::vector<double> list(Names names) const {
    const YamlEntry* entry = find(names);
    if (!entry) return {};
    if (!entry->numbers.empty()) return entry->numbers;
    constexpr std::ptrdiff_t kParts = 5;  // rows, cols, dt, data
    const YamlEntry* end = entries_.data() + entries_.size();
    for (const YamlEntry* next = entry + 1; next < end && next - entry <= kParts; ++next) {
      if (next->key == "data") return next->numbers;
      if (next->key != "rows" && next->key != "cols" && next->key != "dt") return {};
    }
    return {};
  }

  bool findIntrinsics(Intrinsics& k) const {
    std::vector<double> m =
        list({"camera_matrix", "cameramatrix", "intrinsic_matrix", "intrinsicmatrix", "k"});
    if (m.size() != 9) m = list({"intrinsics", "intrinsic"});
    if (m.size() == 9) {
      const bool by_columns = m[2] == 0 && m[6] != 0;  // as Open3D's
      k.fx = m[0], k.fy = m[4], k.cx = by_columns ? m[6] : m[2], k.cy = by_columns ? m[7] : m[5];
      return true;
    }
    if (m.size() == 4) return k.fx = m[0], k.fy = m[1], k.cx = m[2], k.cy = m[3], true;
    const auto fx = number({"fx", "fl_x"}), fy = number({"fy", "fl_y"}), cx = number({"cx", "ppx"}),
               cy = number({"cy", "ppy"});
    if (!fx || !fy || !cx || !cy) return false;
    return k.fx = *fx, k.fy = *fy, k.cx = *cx, k.cy = *cy, true;
  }

  LensDistortion lens() const {
    std::vector<double> d = list({"distortion_coefficients", "distortion_coeffs", "distcoeffs", "dist_coeffs",
                                  "d", "coeffs", "distortion"});
    if (d.empty())
      for (const char* name : {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"})
        d.push_back(number({name}).value_or(0));
    std::string model = word({"distortion_model"});
    if (model.empty()) model = word({"camera_model", "model"});
    return lensOf(model, d);
  }

  std::vector<YamlEntry> entries_;
  const std::string& source_;
};

}  // namespace

LensDistortion lensOf(const std::string& model, const std::vector<double>& d) {
  constexpr std::size_t kPlain = 4, kThird = 5, kRational = 8;
  const bool none = std::all_of(d.begin(), d.end(), [](double c) { return c == 0; });
  if (none) return {};
  const std::string name = text::lower(model);
  const auto has = [&name](const char* part) { return name.find(part) != std::string::npos; };
  if (has("equi") || has("fish") || has("fov") || has("omni") || has("kannala") || has("thin") ||
      has("inverse"))
    throw std::invalid_argument(
        fmt::format("its lens is of the model {}, which is not supported: undistort the images, or calibrate "
                    "them with the model of OpenCV (plumb_bob or rational_polynomial)",
                    model));
  const bool known = d.size() == kPlain || d.size() == kThird || d.size() >= kRational;
  const bool more =
      d.size() > kRational && std::any_of(d.begin() + kRational, d.end(), [](double c) { return c != 0; });
  if (!known || more)
    throw std::invalid_argument(fmt::format(
        "its lens has {} coefficients, which are not those of k1 k2 p1 p2 [k3 [k4 k5 k6]]", d.size()));
  if (!std::all_of(d.begin(), d.end(), [](double c) { return std::isfinite(c); }))
    throw std::invalid_argument("its lens has a coefficient that is not finite");
  LensDistortion lens;
  lens.k1 = d[0], lens.k2 = d[1], lens.p1 = d[2], lens.p2 = d[3];
  if (d.size() >= kThird) lens.k3 = d[4];
  if (d.size() >= kRational) lens.k4 = d[5], lens.k5 = d[6], lens.k6 = d[7];
  return lens;
}

std::optional<Calibration> parseCalibration(std::string_view text, const std::string& source) {
  const auto found = CalibrationReader(yamlEntries(text), source).read();
  if (!found) return {};
  Intrinsics k = found->intrinsics;
  k.width = std::max(k.width, 1), k.height = std::max(k.height, 1);
  return k.valid() ? found : std::nullopt;
}

}  // namespace facetloc::internal

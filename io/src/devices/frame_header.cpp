// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/plausible.h"

#include <facetloc/io/pipe_frames.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <json/json.h>
#include <memory>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr int kLargestSide = 1 << 14;  // [px]
constexpr int kMostPixels = 1 << 24;   // more than any depth camera has
constexpr double kUsualGravityStdDeg = 1;

/** Null unless the line is a JSON object. */
Json::Value objectIn(const std::string& line) {
  Json::CharReaderBuilder builder;
  Json::CharReaderBuilder::strictMode(&builder.settings_);
  const std::unique_ptr<Json::CharReader> reader(builder.newCharReader());
  Json::Value value;
  std::string ignored;
  try {
    if (reader->parse(line.data(), line.data() + line.size(), &value, &ignored) && value.isObject())
      return value;
  } catch (const std::exception&) {  // nested too deeply
  }
  return {};
}

double numberOf(const Json::Value& value, const char* key) {
  if (!value.isNumeric() || !std::isfinite(value.asDouble()))
    throw std::invalid_argument(fmt::format("its {} is no number", key));
  return value.asDouble();
}

int sideOf(const Json::Value& header, const char* key) {
  if (!header.isMember(key)) throw std::invalid_argument(fmt::format("it has no {}", key));
  const double side = numberOf(header[key], key);
  if (!(side >= 1 && side <= kLargestSide && side == std::floor(side)))
    throw std::invalid_argument(fmt::format("its {} of {} is impossible: it is a whole number up to {}", key,
                                            text::shortest(side), kLargestSide));
  return static_cast<int>(side);
}

std::optional<Gravity> gravityOf(const Json::Value& header) {
  const Json::Value& vector = header["gravity"];
  if (vector.isNull()) return {};
  if (!vector.isArray() || vector.size() != 3)
    throw std::invalid_argument("its gravity has not three numbers");
  const Eigen::Vector3d down(numberOf(vector[0], "gravity"), numberOf(vector[1], "gravity"),
                             numberOf(vector[2], "gravity"));
  const Json::Value& std = header["gravity_std_deg"];
  return gravityAlong(down,
                      (std.isNull() ? kUsualGravityStdDeg : numberOf(std, "gravity_std_deg")) * kDegree);
}

/** A value of a camera.ini, as it is written there. */
std::string wordOf(const Json::Value& value, const std::string& key) {
  if (value.isNumeric()) return text::shortest(numberOf(value, key.c_str()));
  if (!value.isString()) throw std::invalid_argument(fmt::format("its {} is neither number nor name", key));
  return value.asString();
}

}  // namespace

std::optional<FrameHeader> parseFrameHeader(const std::string& line) {
  const Json::Value json = objectIn(line);
  if (json.isNull())
    throw std::invalid_argument("it is no JSON object; is the frame before it longer than it says?");
  if (!(json.isMember("width") || json.isMember("height"))) return {};
  FrameHeader header;
  header.width = sideOf(json, "width"), header.height = sideOf(json, "height");
  if (header.width > kMostPixels / header.height)
    throw std::invalid_argument(fmt::format("its {} x {} pixels are more than any depth camera has ({})",
                                            header.width, header.height, kMostPixels));
  if (!json.isMember("stamp")) throw std::invalid_argument("it has no stamp");
  header.stamp = numberOf(json["stamp"], "stamp");
  if (!plausible::isStamp(header.stamp))
    throw std::invalid_argument(fmt::format("its stamp of {} is impossible: it is a time in seconds up to {}",
                                            text::shortest(header.stamp),
                                            text::shortest(plausible::kLatest)));
  header.gravity = gravityOf(json);
  for (const std::string& key : json.getMemberNames())
    if (isCameraKey(key)) header.camera.emplace_back(key, wordOf(json[key], key));
  return header;
}

}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/map_page.h"

#include "cli/text.h"
#include "drawing/depth_drawing.h"
#include "drawing/html_text.h"
#include "drawing/plan_view.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <json/value.h>
#include <limits>

namespace facetloc {
namespace {

constexpr std::size_t kMostSegments = 40000;
constexpr std::size_t kMostPlaces = 20;                            // Poses listed per answer.
constexpr std::size_t kPictureBytes = 1 << 20;                     // that pictures and matches share, about
constexpr std::size_t kLargePicture = 2900, kSmallPicture = 1600;  // encoded, with its matches [bytes]

template <class Matrix>
Json::Value rowsOf(const Matrix& matrix) {
  Json::Value value(Json::arrayValue);
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) value.append(static_cast<double>(matrix(r, c)));
  return value;
}

Json::Value poseOf(const Eigen::Isometry3d& T) {
  Eigen::Matrix<double, 7, 1> values;
  values << T.translation(), Eigen::Quaterniond(T.linear()).coeffs();  // x, y, z, w
  return rowsOf(values);
}

/** Principal axes of the position's uncertainty, each as long as its standard deviation. */
Eigen::Matrix3d axesOf(const Matrix6d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(P.bottomRightCorner<3, 3>());
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/** Which images have a picture, and how wide it is, so that all of them fit. */
class Pictures {
public:
  explicit Pictures(std::size_t images)
      : width_(images * kLargePicture <= kPictureBytes ? 160 : 80),
        every_(std::max<std::size_t>(1, (images * kSmallPicture + kPictureBytes - 1) / kPictureBytes)) {}

  bool has(std::size_t image) const { return width_ > 80 || image % every_ == 0; }
  void add(const View& view, Json::Value& to) const {
    const std::string bytes = depthThumbnail(view, width_);
    if (!bytes.empty()) to["image"] = base64(bytes);
  }

private:
  int width_;          // [px]
  std::size_t every_;  // image has one
};

/** Measured depths of all local models, on a grid so coarse that they fit. */
class Points {
public:
  explicit Points(const Map& map) {
    double pixels = 0;
    for (std::size_t i = 0; i < map.models.size(); ++i)
      pixels += static_cast<double>(map.view(static_cast<int>(i))->depth.inverse_depth.size());
    step_ = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMostPoints))));
  }

  void add(const DepthPicture& picture, Json::Value& to) const {
    const Intrinsics& camera = picture.camera;
    if (picture.empty()) return;
    std::string bytes;
    for (int v = 0; v < camera.height; v += step_)
      for (int u = 0; u < camera.width; u += step_) {
        const unsigned q = picture.inverse_depth[static_cast<std::size_t>(v) * camera.width + u];
        bytes += static_cast<char>(q & 255), bytes += static_cast<char>(q >> 8);
      }
    to["points"]["columns"] = (camera.width + step_ - 1) / step_;
    to["points"]["step"] = static_cast<double>(step_) / camera.width;
    to["points"]["inverse"] = base64(bytes);
  }

private:
  static constexpr double kMostPoints = 1 << 17;
  int step_;  // [px]
};

/** The hulls of all segments: corners as whole multiples of a quantum above the lowest, 16 bits each. */
class Hulls {
public:
  void add(const Segment& segment, const Eigen::Isometry3d& T_w_m) {
    hulls_.push_back(cornersOf(segment, T_w_m));
    areas_.push_back(segment.area());
  }

  /** \return how many are left out. */
  std::size_t write(Json::Value& data) {
    const std::size_t left_out = keepLargest();
    Eigen::AlignedBox3d box;
    for (const auto& hull : hulls_)
      for (const Eigen::Vector3d& p : hull) box.extend(p);
    const Eigen::Vector3d low = box.isEmpty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : box.min();
    const double quantum = std::max(box.isEmpty() ? 0 : box.sizes().maxCoeff(), 1e-3) / kLargest;
    std::string sizes, corners;
    for (const auto& hull : hulls_) {
      sizes += static_cast<char>(hull.size());
      for (const Eigen::Vector3d& p : hull)
        for (int i = 0; i < 3; ++i) {
          const auto n = static_cast<std::uint16_t>(std::lround((p[i] - low[i]) / quantum));
          corners += static_cast<char>(n & 255), corners += static_cast<char>(n >> 8);
        }
    }
    data["low"] = rowsOf(low);
    data["quantum"] = quantum;
    data["sizes"] = base64(sizes);
    data["corners"] = base64(corners);
    return left_out;
  }

private:
  static constexpr double kLargest = std::numeric_limits<std::uint16_t>::max();

  std::size_t keepLargest() {
    if (hulls_.size() <= kMostSegments) return 0;
    std::vector<double> sorted = areas_;
    const auto last = sorted.begin() + kMostSegments;
    std::nth_element(sorted.begin(), last, sorted.end(), std::greater<>());
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < hulls_.size(); ++i)
      if (areas_[i] <= *last) hulls_[i].clear(), ++left_out;
    return left_out;
  }

  std::vector<std::vector<Eigen::Vector3d>> hulls_;  // world coordinates; empty if not drawn
  std::vector<double> areas_;                        // [m^2]
};

/** Where a segment is in the image of a view, in permille of its width and height; empty if it reaches behind
 * the camera. */
Json::Value outlineOf(const Segment& segment, const Intrinsics& camera) {
  constexpr double kNearest = 0.05;  // [m]
  Json::Value outline(Json::arrayValue);
  for (const Eigen::Vector3d& p : cornersOf(segment, Eigen::Isometry3d::Identity())) {
    if (p.z() < kNearest) return Json::Value(Json::arrayValue);
    const Eigen::Vector2d pixel = camera.project(p);
    outline.append(static_cast<int>(std::clamp(1000 * pixel.x() / camera.width, -9999.0, 9999.0)));
    outline.append(static_cast<int>(std::clamp(1000 * pixel.y() / camera.height, -9999.0, 9999.0)));
  }
  return outline;
}

/** The writer of a page's data. */
class Writer {
public:
  Writer(const Map& map, const MapPage& page)
      : map_(map),
        page_(page),
        part_(mainPart(map)),
        numbers_(map.models.size(), -1),
        pictures_(imageCount()),
        points_(map) {}

  Json::Value write(const std::filesystem::path& path) {
    addModels();
    if (data_["models"].empty())
      throw IoError(path.string(), "cannot be drawn: no local model of the map has a pose");
    data_["up"] = rowsOf(rotationBetween(upInPart(map_, part_), Eigen::Vector3d::UnitZ()));
    data_["most_links"] = kMostLinks;
    data_["inverse_quantum"] = 1 / DepthPicture::kQuantum;
    addOwnViews();
    addLinks();
    addRuns();
    addChanges();
    for (const Finding& finding : page_.findings)
      data_["findings"].append(printable(toString(finding.severity) + (": " + finding.text())));
    data_["answers"] = Json::arrayValue;
    for (std::size_t i = 0; i < page_.answers.size(); ++i) addAnswer(i);
    return data_;
  }

private:
  std::size_t imageCount() const { return map_.models.size() + (page_.view ? page_.answers.size() : 0); }

  bool isDrawn(const LocalModel& model) const { return model.T_w_m && model.part == part_; }

  void addModels() {
    Hulls hulls;
    std::size_t elsewhere = 0;
    data_["models"] = Json::arrayValue;
    for (std::size_t i = 0; i < map_.models.size(); ++i) {
      const LocalModel& model = map_.models[i];
      if (!isDrawn(model)) {
        ++elsewhere;
        continue;
      }
      const auto view = map_.view(static_cast<int>(i));
      for (const Segment& segment : view->segments) hulls.add(segment, *model.T_w_m);
      noteCamera(*view);
      Json::Value value;
      value["name"] = printable(model.name);
      value["pose"] = poseOf(*model.T_w_m);
      value["by_links"] = model.by_links;
      value["n"] = static_cast<Json::UInt64>(view->segments.size());
      if (pictures_.has(i)) pictures_.add(*view, value);
      points_.add(view->depth, value);
      numbers_[i] = static_cast<int>(data_["models"].size());
      data_["models"].append(value);
    }
    noteLeftOut(hulls.write(data_), elsewhere);
  }

  void addOwnViews() {
    for (const OwnView& view : page_.own_views) {
      if (numbers_[view.model] < 0) continue;
      Json::Value& value = data_["models"][numbers_[view.model]]["own"];
      value["verdict"] = view.verdict();
      value["p"] = view.probability;
      value["reason"] = printable(view.reason);
      if (view.nees) value["inside"] = view.isInside();
      if (!view.mistaken_for) continue;
      value["taken_for"] = numbers_[*view.mistaken_for];
      if (view.distance) value["off"] = *view.distance;
    }
  }

  /** The camera of all local models, in units of the width and the height of its image. */
  void noteCamera(const View& view) {
    const Intrinsics& c = view.intrinsics;
    if (data_.isMember("camera") || !c.valid()) return;
    data_["camera"] =
        rowsOf(Eigen::RowVector4d(c.fx / c.width, c.fy / c.height, c.cx / c.width, c.cy / c.height));
    data_["shape"] = static_cast<double>(c.height) / c.width;
  }

  void noteLeftOut(std::size_t segments, std::size_t models) {
    std::string words;
    if (models) words = fmt::format("{} in other parts or without a pose", counted(models, "local model"));
    if (segments) words += fmt::format("{}{} smaller segments", words.empty() ? "" : ", ", segments);
    data_["left_out"] = words.empty() ? "" : "not shown: " + words;
  }

  void addLinks() {
    data_["links"] = Json::arrayValue;
    for (const Link& link : map_.links) {
      const auto known = [&](int i) {
        return i >= 0 && static_cast<std::size_t>(i) < numbers_.size() && numbers_[i] >= 0;
      };
      if (!known(link.from) || !known(link.to)) continue;
      Json::Value value(Json::arrayValue);
      value.append(numbers_[link.from]);
      value.append(numbers_[link.to]);
      data_["links"].append(value);
    }
  }

  void addRuns() {
    data_["runs"] = Json::arrayValue;
    for (const DrawnRun& run : page_.runs) {
      Json::Value value;
      value["name"] = printable(run.name);
      value["colour"] = run.colour.toString();
      value["points"] = Json::arrayValue;
      for (const Eigen::Isometry3d& T : run.T_w_c)
        for (int i = 0; i < 3; ++i) value["points"].append(T.translation()[i]);
      data_["runs"].append(value);
    }
  }

  void addChanges() {
    for (const SurfaceChange& change : page_.changes) {
      if (change.part != part_) continue;
      Json::Value value;
      value["kind"] = change.name();
      value["area"] = change.area;
      value["p"] = change.probability;
      value["looks"] = static_cast<Json::UInt64>(change.looks);
      value["seen_by"] = printable(change.seen_by);
      value["centre"] = rowsOf(change.centre);
      for (const Eigen::Vector3d& corner : change.outline) value["outline"].append(rowsOf(corner));
      data_["changes"].append(value);
    }
  }

  Json::Value valueOf(const PagePlace& place) const {
    Json::Value value;
    value["pose"] = poseOf(place.T_w_c);
    value["p"] = place.probability;
    value["sd_m"] = place.sd_trans_m;
    value["sd_deg"] = place.sd_rot_deg;
    value["model"] = place.model < 0 ? -1 : numbers_.at(place.model);
    return value;
  }

  void addAnswer(std::size_t i) {
    const PageAnswer& answer = page_.answers[i];
    Json::Value value;
    value["name"] = printable(answer.run.empty() ? answer.frame : answer.run + " " + answer.frame);
    value["state"] = toString(answer.state);
    value["wrong"] = answer.wrong;
    value["reason"] = printable(answer.reason);
    value["places"] = Json::arrayValue;
    const std::size_t places = std::min(answer.places.size(), kMostPlaces);
    for (std::size_t k = 0; k < places; ++k) value["places"].append(valueOf(answer.places[k]));
    if (answer.places.size() > places)
      value["more"] = static_cast<Json::UInt64>(answer.places.size() - places);
    if (answer.P_w_c && places > 0) value["axes"] = rowsOf(axesOf(*answer.P_w_c));
    if (answer.shares)
      for (const auto& [name, share] : ViewShares::kNamed) value["shares"][name] = (*answer.shares).*share;
    if (answer.truth) value["truth"] = poseOf(*answer.truth);
    if (answer.error_m && answer.error_deg) {
      value["error"] = rowsOf(Eigen::RowVector2d(*answer.error_m, *answer.error_deg));
      value["relative"] = answer.relative;
    }
    if (page_.view && pictures_.has(i)) addView(i, value);
    data_["answers"].append(value);
  }

  /** An image that cannot be read has an answer, but no picture. */
  std::optional<View> viewOf(std::size_t i) const try { return page_.view(i); } catch (const IoError&) {
    return {};
  }

  void addView(std::size_t i, Json::Value& value) const {
    const std::optional<View> view = viewOf(i);
    if (!view) return;
    pictures_.add(*view, value);
    const PageAnswer& answer = page_.answers[i];
    if (answer.places.empty() || answer.places[0].model < 0) return;
    const PagePlace& place = answer.places[0];
    value["matches"] = Json::arrayValue;
    for (const SegmentPair& pair : matchedSegments(*view, *map_.view(place.model), place.T_m_c)) {
      Json::Value match;
      match["model"] = pair.model;
      match["outline"] = outlineOf(view->segments[pair.scene], view->intrinsics);
      value["matches"].append(match);
    }
  }

  const Map& map_;
  const MapPage& page_;
  const int part_;
  std::vector<int> numbers_;  // Indices on the page by local model; -1 = not drawn.
  const Pictures pictures_;
  const Points points_;
  Json::Value data_;
};

}  // namespace

Json::Value mapPageData(const Map& map, const MapPage& page, const std::filesystem::path& path) {
  return Writer(map, page).write(path);
}

void writeMapPage(const std::filesystem::path& path, const Map& map, const MapPage& content) {
  const std::string scripts = pageFile("three_license.js") + pageFile("three.js") + "\n" +
                              pageFile("orbit.js") + "\n" + pageFile("map.js");
  const std::string page = filledPage("map.html", {{"TITLE", htmlEscaped(printable(content.title))},
                                                   {"STYLE", pageFile("map.css")},
                                                   {"SCRIPT", scripts},
                                                   {"DATA", scriptText(mapPageData(map, content, path))}});
  writeTextAtomically(path, [&](std::ostream& out) { out << page; });
}

}  // namespace facetloc

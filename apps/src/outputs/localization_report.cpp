// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/localization_report.h"

#include "base/median.h"
#include "base/text.h"
#include "cli/text.h"

#include <facetloc/localization/localizer.h>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace facetloc {
namespace {

ResultRow resultRow(const std::string& frame, int rank, const Hypothesis& h, const Map& map) {
  ResultRow row;
  row.frame = frame;
  row.rank = rank;
  row.model = map.models[h.model].name;
  row.probability = h.probability;
  row.score = h.score;
  row.T_m_c = h.T_m_c.T;
  row.T_w_c = h.T_w_c;
  row.part = map.partOf(h.model);
  row.sd_rot_deg = largestRotationStd(h.T_m_c.P) / kDegree;
  row.sd_trans_m = largestTranslationStd(h.T_m_c.P);
  if (h.depth_assisted) row.reason = "depth-assisted";
  if (const auto& T_w_m = map.models[h.model].T_w_m; rank == 1 && T_w_m && h.T_w_c)
    row.P_w_c = (*T_w_m * h.T_m_c).P;
  return row;
}

std::string vectorText(const Eigen::Vector3d& v, int decimals) {
  // Adding zero makes -0 positive.
  return fmt::format("{0:.{3}f} {1:.{3}f} {2:.{3}f}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0, decimals);
}

constexpr double kHardlyAny = 0.1;    // share of sure answers
constexpr int kEnoughImages = 5;      // to speak of a share
constexpr std::size_t kModels = 500;  // sampled to learn the typical number of segments

std::vector<double> allOf(const std::vector<ViewTraits>& views, double ViewTraits::*trait) {
  std::vector<double> values;
  for (const ViewTraits& view : views) values.push_back(view.*trait);
  return values;
}

std::vector<ViewTraits> traitsOf(const Map& map) {
  std::vector<ViewTraits> traits;
  const std::size_t step = std::max<std::size_t>(1, map.models.size() / kModels);
  for (std::size_t i = 0; i < map.models.size(); i += step)
    traits.push_back(ViewTraits::of(*map.view(static_cast<int>(i))));
  return traits;
}

/** "its images ..., those of the map ...", and how unlike they are. */
struct Comparison {
  Comparison(const std::vector<ViewTraits>& views, const std::vector<ViewTraits>& models,
             double ViewTraits::*trait)
      : of_images(medianOfKnown(allOf(views, trait))), of_map(medianOfKnown(allOf(models, trait))) {}

  bool isKnown() const { return of_images > 0 && of_map > 0; }
  double ratio() const { return isKnown() ? std::max(of_images / of_map, of_map / of_images) : 1; }
  std::string toString(int decimals, const std::string& unit) const {
    return fmt::format("{0:.{3}f}{2}, the map's images have {1:.{3}f}{2}", of_images, of_map, unit, decimals);
  }

  double of_images, of_map;
};

}  // namespace

std::vector<ResultRow> resultRows(const std::string& frame, const Localization& answer, const Map& map,
                                  int max_hypotheses) {
  if (answer.hypotheses.empty()) return {noHypothesis(frame, answer.reason)};
  std::vector<ResultRow> rows;
  for (const Hypothesis& h : answer.hypotheses) {
    if (static_cast<int>(rows.size()) == max_hypotheses) break;
    rows.push_back(resultRow(frame, static_cast<int>(rows.size()) + 1, h, map));
    rows.back().state = answer.state;
    rows.back().not_in_map = answer.not_in_map;
  }
  rows.front().maps = probabilitiesOfMaps(answer, map);
  rows.front().shares = answer.shares;
  std::string& reason = rows.front().reason;
  if (!reason.empty() && !answer.reason.empty()) reason += "; ";
  reason += answer.reason;
  rows.front().next_look = answer.next_look;
  return rows;
}

void printPoses(std::ostream& out, const std::vector<ResultRow>& rows, const std::string& world) {
  TextTable table({"rank", "probability", "score", "in", "translation [m]", "rotation vector [deg]",
                   "angle [deg]", "std [m]", "std [deg]", "remarks"});
  table.setWordsLast();
  for (const ResultRow& row : rows) {
    const Eigen::Isometry3d& T = row.T_w_c ? *row.T_w_c : row.T_m_c;
    const Eigen::Vector3d rotation = logSO3(T.linear()) / kDegree;
    table.add({std::to_string(row.rank), text::decimals(row.probability, 4), text::decimals(row.score, 1),
               !row.T_w_c         ? row.model
               : row.part.empty() ? world
                                  : row.part,
               vectorText(T.translation(), 3), vectorText(rotation, 2), text::decimals(rotation.norm(), 2),
               text::decimals(row.sd_trans_m, 3), text::decimals(row.sd_rot_deg, 2), row.reason});
  }
  out << table;
}

std::string toString(const NextLook& look) {
  const double degrees = std::round(look.yaw / kDegree);
  std::string words;
  if (degrees != 0)
    words = fmt::format("turn {}° to the {}", std::abs(degrees), degrees > 0 ? "left" : "right");
  if (look.ahead > 0)
    words += fmt::format("{}drive {:.1f} m ahead", words.empty() ? "" : ", then ", look.ahead);
  return words;
}

void addMinProbability(CommandLine& line, double& min_probability) {
  line.addOption("min-probability", min_probability, "P",
                 "Minimum probability of a sure answer. A calibrated map has its own default.");
  line.addCheck([&min_probability] {
    if (!(min_probability > 0 && min_probability <= 1))
      throw UsageError("min-probability must be above 0 and at most 1");
  });
}

void StateCounts::add(AnswerState state) {
  ++(state == AnswerState::sure ? sure : state == AnswerState::doubtful ? doubtful : unknown);
}

std::string toString(const StateCounts& counts) {
  return fmt::format("{}: {} sure, {} doubtful, {} unknown",
                     counted(static_cast<std::size_t>(counts.all()), "image"), counts.sure, counts.doubtful,
                     counts.unknown);
}

ViewTraits ViewTraits::of(const View& view) {
  ViewTraits traits;
  const Intrinsics& k = view.intrinsics;
  if (k.valid()) traits.fov = 2 * std::atan2(k.width / 2.0, k.fx) / kDegree;
  std::vector<double> depths;
  for (const std::uint16_t inverse : view.depth.inverse_depth)
    if (inverse > 0) depths.push_back(1 / (inverse * DepthPicture::kQuantum));
  traits.depth = medianOfKnown(std::move(depths));
  return traits;
}

double medianOfKnown(std::vector<double> values) {
  values.erase(std::remove(values.begin(), values.end(), 0.0), values.end());
  if (values.empty()) return 0;
  return internal::median(values.begin(), values.end());
}

Findings whatToLookAt(const StateCounts& counts, const std::vector<ViewTraits>& views, const Map& map) {
  constexpr double kOtherOptics = 1.05, kOtherScale = 1.4;  // ratios that are hardly chance
  if (counts.all() < kEnoughImages || counts.sure >= kHardlyAny * counts.all()) return {};
  const std::vector<ViewTraits> models = traitsOf(map);
  const Comparison fov(views, models, &ViewTraits::fov), depth(views, models, &ViewTraits::depth);
  const bool other_optics = fov.ratio() > kOtherOptics, other_scale = depth.ratio() > kOtherScale;
  const Finding optics{
      "localize.optics",
      other_optics ? Severity::doubt : Severity::note,
      fmt::format("Do fx and fy fit the images? Their field of view is {}.", fov.toString(0, " deg")),
      "",
      {{"fov_deg", fov.of_images}, {"map_fov_deg", fov.of_map}}};
  const Finding scale{
      "localize.scale",
      other_scale ? Severity::doubt : Severity::note,
      fmt::format("Does depth_scale fit the images? Their median depth is {}.", depth.toString(2, " m")),
      "",
      {{"depth_m", depth.of_images}, {"map_depth_m", depth.of_map}}};
  Findings hints = {
      {"localize.hardly_sure",
       Severity::note,
       "Hardly any image is sure. Check the following:",
       "",
       {{"sure", static_cast<double>(counts.sure)}, {"images", static_cast<double>(counts.all())}}}};
  if (other_optics) hints.push_back(optics);
  if (other_scale) hints.push_back(scale);
  if (map.parts.size() > 1)
    hints.push_back({"localize.parts", Severity::note,
                     fmt::format("Do links join the local models of the map? It is in {} parts, and a place "
                                 "that two of them show may be either.",
                                 map.parts.size()),
                     ""});
  hints.push_back({"localize.place", Severity::note, "Is it the map of this place?", ""});
  hints.push_back({"localize.turned", Severity::note,
                   "Is the camera turned about its optical axis against the map's, upright or upside down? "
                   "camera.ini tells its mounting (mount_roll_deg), and --prior.rotation_std_deg 90 searches "
                   "all attitudes.",
                   ""});
  if (fov.isKnown() && !other_optics) hints.push_back(optics);
  if (depth.isKnown() && !other_scale) hints.push_back(scale);
  hints.push_back({"localize.noise", Severity::note,
                   "Does the noise of camera.ini fit the camera, and does the map hold views of the same "
                   "directions? facetloc_segment --overlay and facetloc_render show what is seen.",
                   ""});
  return hints;
}

ResultRow noHypothesis(const std::string& frame, const std::string& reason) {
  ResultRow row;
  row.frame = frame;
  row.reason = reason;
  row.not_in_map = 1;
  return row;
}

}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_status.h"

#include "base/text.h"
#include "cli/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace facetloc {
namespace {

std::size_t terminalWidth() {
  constexpr std::size_t kUsual = 80;
  winsize size = {};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

/** "x 1.20  y -3.41  z 0.98 m". */
std::string positionText(const Eigen::Vector3d& p) {
  return fmt::format("x {}   y {}   z {} m", text::decimals(p.x(), 2), text::decimals(p.y(), 2),
                     text::decimals(p.z(), 2));
}

std::string seenText(const SeenImage& image) {
  const auto& labels = image.labels.label;
  const auto labelled = labels.size() - std::count(labels.begin(), labels.end(), 0);
  const auto measured = std::count_if(image.depth.depth.begin(), image.depth.depth.end(), isMeasured);
  return fmt::format("{} on {:.0f} % of the measured pixels",
                     counted(image.view.segments.size(), "planar segment"),
                     measured ? 100.0 * labelled / measured : 0.0);
}

/** "± 12 mm, 0.30°": the largest standard deviations over directions. */
std::string accuracyText(const Matrix6d& P) {
  return fmt::format("± {:.0f} mm, {:.2f}°", 1000 * largestTranslationStd(P),
                     largestRotationStd(P) / kDegree);
}

/** "view 83 % explained, 5 % hiding, 12 % new, map 1 % missing". */
std::string sharesText(const ViewShares& shares) {
  return fmt::format("view {:.0f} % explained, {:.0f} % hiding, {:.0f} % new, map {:.0f} % missing",
                     100 * shares.explained, 100 * shares.hiding, 100 * shares.fresh, 100 * shares.missing);
}

/** The prefix of a position in a part of the map; empty in the world. */
std::string partText(const Map& map, int part) {
  const auto i = static_cast<std::size_t>(part);
  return i < map.parts.size() && !map.parts[i].empty() ? fmt::format("in part {}:  ", map.parts[i]) : "";
}

}  // namespace

std::string stateText(const LiveResult& result) {
  const std::string remark = result.remark();
  return result.state() + (remark.empty() ? "" : ": " + remark);
}

std::string timesText(const LiveResult& result, double rate) {
  std::string words = fmt::format("{:.1f} frames/s,  segmentation {:.1f} ms,  features {:.1f} ms", rate,
                                  result.segment_ms, result.features_ms);
  if (result.mapped) words += fmt::format(",  mapping {:.1f} ms", result.localize_ms);
  if (result.answer) words += fmt::format(",  localization {:.1f} ms", result.localize_ms);
  return words +
         fmt::format(",  age {:.0f} ms,  {} of {} dropped", result.age_ms, result.dropped, result.received);
}

std::string poseText(const LiveResult& result, const Map* map, std::optional<double> heading_deg,
                     std::size_t matched) {
  if (!map) return seenText(result.image);
  const Hypothesis* match = result.match();
  const PoseWithCovariance* pose = result.pose();
  if (!pose && !match) return "no pose; " + seenText(result.image);
  const std::string model = match ? map->models.at(match->model).name : "";
  std::string words =
      pose ? partText(*map, result.part()) + positionText(pose->T.translation())
           : fmt::format("in local model {}:  {}", model, positionText(match->T_m_c.T.translation()));
  if (pose && heading_deg) words += fmt::format("   heading {}°", text::decimals(*heading_deg, 1));
  words += "   " + accuracyText(pose ? pose->P : match->T_m_c.P);
  if (match)
    words += fmt::format("   {} of {} in local model {}", matched,
                         counted(result.image.view.segments.size(), "segment"), model);
  if (match && result.answer->shares) words += "   " + sharesText(*result.answer->shares);
  return words;
}

std::string segmentText(const View& view, std::size_t k) {
  const Segment& s = view.segments.at(k);
  const double tilt = std::sqrt(std::max({s.Sigma_q(0, 0), s.Sigma_q(1, 1), 0.0})) / kDegree;
  return fmt::format("segment {}: {} m², {} m away, {} px; normal ± {}°, distance ± {} mm", k + 1,
                     text::decimals(s.area(), 2), text::decimals(s.t.norm(), 2), s.num_points,
                     text::decimals(tilt, 2),
                     text::decimals(1000 * std::sqrt(std::max(0.0, s.Sigma_q(2, 2))), 1));
}

std::string modelText(const Map& map, int i) {
  const LocalModel& model = map.models.at(static_cast<std::size_t>(i));
  const auto links = std::count_if(map.links.begin(), map.links.end(),
                                   [i](const Link& link) { return link.from == i || link.to == i; });
  return fmt::format("local model {}: {}, {}; {}", model.name,
                     counted(map.view(i)->segments.size(), "segment"),
                     counted(static_cast<std::size_t>(links), "link"),
                     model.T_w_m ? positionText(model.T_w_m->translation()) : "no pose");
}

void FrameRate::update(std::uint64_t frames) {
  constexpr double kLeastInterval = 1.0;  // [s]
  const Clock::time_point now = Clock::now();
  if (since_) {
    const double seconds = std::chrono::duration<double>(now - *since_).count();
    if (seconds < kLeastInterval) return;
    value_ = static_cast<double>(frames - frames_) / seconds;
  }
  since_ = now;
  frames_ = frames;
}

void LiveStatus::show(const LiveResult& result, double rate) {
  if (!visible_) return;
  std::string line = stateText(result);
  if (const PoseWithCovariance* pose = result.isLocalized() ? result.pose() : nullptr) {
    const Eigen::Vector3d p = pose->T.translation();
    line += fmt::format("  {} {} {} m", text::decimals(p.x(), 2), text::decimals(p.y(), 2),
                        text::decimals(p.z(), 2));
  }
  line += fmt::format("  {:.1f}/s  {} of {} dropped", rate, result.dropped, result.received);
  console_.show(line.substr(0, terminalWidth() - 1));
  shown_ = true;
}

void LiveStatus::clear() {
  if (shown_) console_.show("");
  shown_ = false;
}

}  // namespace facetloc

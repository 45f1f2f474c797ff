// SPDX-License-Identifier: BSD-3-Clause
#include "tools/seen_motions.h"

#include "base/batch.h"

#include <facetloc/io/error.h>
#include <facetloc/localization/global_localization.h>

#include <algorithm>

namespace facetloc {
namespace {

constexpr std::size_t kStarts = 24;                           // images that others are registered with
constexpr double kLeastTurn = 1 * kDegree, kLeastWay = 0.02;  // a motion that tells anything [m]
constexpr double kMostTurn = 15 * kDegree, kMostWay = 0.4;    // after which no longer one is tried

/** Of the images 1, 2, 4, ... after one, as long as they show the same. */
std::vector<SeenMotion> motionsFrom(std::size_t first, const DepthSequence& sequence, ViewBuilder& builder,
                                    int width) {
  const auto viewOf = [&](std::size_t i) {
    View view = builder.build(sequence.load(i, width));
    view.camera.reset();  // whatever is known of its mounting
    return view;
  };
  std::vector<SeenMotion> motions;
  const GlobalLocalization target(std::make_shared<const Map>(mapOf(viewOf(first))));
  for (std::size_t gap = 1; first + gap < sequence.frames().size(); gap *= 2) {
    const Localization answer = target.localize(viewOf(first + gap));
    if (answer.state() != AnswerState::sure) break;
    const Eigen::Isometry3d& T = answer.hypotheses.front().T_m_c.T;
    const double turn = rotationAngle(T.linear()), way = T.translation().norm();
    if (turn > kLeastTurn || way > kLeastWay)
      motions.push_back({sequence.frames()[first].stamp, sequence.frames()[first + gap].stamp, T});
    if (turn > kMostTurn || way > kMostWay) break;
  }
  return motions;
}

}  // namespace

std::vector<SeenMotion> seenMotions(const DepthSequence& sequence, const Camera& camera,
                                    const DepthInput& input, int threads, const Console& console) {
  for (const FrameFile& frame : sequence.frames())
    if (!std::filesystem::is_regular_file(frame.path)) return {};  // such as a pipe, which can be read once
  const std::size_t images = sequence.frames().size(), starts = std::min(images, kStarts);
  std::vector<std::vector<SeenMotion>> motions(starts);
  Batch batch(threads, starts, console);
  std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, input.view));
  batch.run([&](std::size_t i) { return sequence.frames()[i * images / starts].name; },
            [&](std::size_t i, int worker) {
              try {
                motions[i] = motionsFrom(i * images / starts, sequence, builders[worker], input.width);
              } catch (const IoError&) {  // the image is named when it is read for the map
              }
            });
  std::vector<SeenMotion> all;
  for (const auto& of_start : motions) all.insert(all.end(), of_start.begin(), of_start.end());
  return all;
}

}  // namespace facetloc

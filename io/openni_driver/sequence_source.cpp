// SPDX-License-Identifier: BSD-3-Clause
#include "sequence_source.h"

#include "base/median.h"
#include "millimetres.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace facetloc {
namespace {

constexpr int kUsualRate = 30;  // [Hz]
constexpr int kHighestRate = 1000;

/** Stamps count up by whole numbers where they are indices and not times. */
bool areTimes(const std::vector<FrameFile>& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].stamp != static_cast<double>(i)) return frames.front().stamp >= 0;
  return false;
}

/** Rate by the median time between images, so that a gap does not count. */
int rateOf(const std::vector<FrameFile>& frames) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < frames.size(); ++i) steps.push_back(frames[i].stamp - frames[i - 1].stamp);
  if (steps.empty()) return kUsualRate;
  const double usual = internal::median(steps.begin(), steps.end());
  return usual > 0 ? static_cast<int>(std::clamp(std::round(1 / usual), 1.0, double(kHighestRate)))
                   : kUsualRate;
}

/** Camera of the first image that can be read. */
Intrinsics cameraOfImages(const DepthSequence& sequence) {
  for (std::size_t i = 0;; ++i) {
    try {
      return sequence.load(i).camera;
    } catch (const IoError&) {
      if (i + 1 == sequence.frames().size()) throw;
    }
  }
}

}  // namespace

SequenceSource::SequenceSource(const std::string& folder) : sequence_(DepthSequence::open(folder)) {
  has_times_ = areTimes(sequence_.frames());
  rate_ = has_times_ ? rateOf(sequence_.frames()) : kUsualRate;
  camera_ = sequence_.camera() ? sequence_.camera()->camera.intrinsics : cameraOfImages(sequence_);
  if (sequence_.camera()) mounting_ = sequence_.camera()->camera.mounting;
}

std::uint64_t SequenceSource::stamp(std::size_t index) const {
  const double seconds =
      has_times_ ? sequence_.frames().at(index).stamp : static_cast<double>(index) / kUsualRate;
  return static_cast<std::uint64_t>(std::llround(1e6 * seconds));
}

void SequenceSource::read(std::size_t index, std::uint16_t* depth) const {
  const DepthImage image = sequence_.load(index);
  if (image.camera.width != camera_.width || image.camera.height != camera_.height)
    throw IoError(sequence_.frames().at(index).path.string(), "is of another size than the first image");
  toMillimetres(image, depth);
}

}  // namespace facetloc

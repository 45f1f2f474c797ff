// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/common_place.h"

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kSigmas = 3;      // of the session's errors that are allowed for
constexpr double kTellingStd = 2;  // of the session between two keyframes, beyond which it says nothing [m]
constexpr double kTellingRotation = 20 * kDegree;  // the same

enum class Verdict : char { says_nothing, agree, contradict };

class Comparison {
public:
  Comparison(const std::vector<FoundKeyframe>& found, const RelativePose& relative,
             const PlaceTolerance& tolerance)
      : verdicts_(found.size(), std::vector<Verdict>(found.size(), Verdict::says_nothing)) {
    for (std::size_t i = 0; i < found.size(); ++i)
      for (std::size_t j = i + 1; j < found.size(); ++j)
        verdicts_[i][j] = verdicts_[j][i] = compare(found[i], found[j], relative, tolerance);
  }

  /** The largest set of those left that a greedy search from each of them finds. */
  std::vector<std::size_t> largestSet(const std::vector<std::size_t>& left) const {
    std::vector<std::size_t> best;
    for (const std::size_t first : left) {
      std::vector<std::size_t> set{first};
      for (const std::size_t other : left)
        if (other != first && std::all_of(set.begin(), set.end(), [&](std::size_t i) {
              return verdicts_[i][other] == Verdict::agree;
            }))
          set.push_back(other);
      if (set.size() > best.size()) best = std::move(set);
    }
    return best;
  }

  bool contradicts(std::size_t i, const std::vector<std::size_t>& set) const {
    return std::any_of(set.begin(), set.end(),
                       [&](std::size_t j) { return verdicts_[i][j] == Verdict::contradict; });
  }

private:
  static Verdict compare(const FoundKeyframe& a, const FoundKeyframe& b, const RelativePose& relative,
                         const PlaceTolerance& tolerance) {
    const auto in_session = relative(a.keyframe, b.keyframe);
    if (!in_session) return Verdict::says_nothing;
    const double std = largestTranslationStd(in_session->P), turn_std = largestRotationStd(in_session->P);
    if (std > kTellingStd || turn_std > kTellingRotation) return Verdict::says_nothing;
    const Vector6d off = perturbation(in_session->T, a.T_w_c.T.inverse() * b.T_w_c.T);
    const bool agree = off.tail<3>().norm() <= tolerance.distance + kSigmas * std &&
                       off.head<3>().norm() <= tolerance.rotation + kSigmas * turn_std;
    return agree ? Verdict::agree : Verdict::contradict;
  }

  std::vector<std::vector<Verdict>> verdicts_;
};

}  // namespace

std::vector<FoundKeyframe> withCommonPlace(const std::vector<FoundKeyframe>& found,
                                           const RelativePose& relative, const PlaceTolerance& tolerance,
                                           std::size_t least) {
  const Comparison comparison(found, relative, tolerance);
  std::vector<std::size_t> all(found.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::vector<std::size_t> set = comparison.largestSet(all);
  if (set.empty() || set.size() < least) return {};
  std::vector<std::size_t> against;
  for (const std::size_t i : all)
    if (std::find(set.begin(), set.end(), i) == set.end() && comparison.contradicts(i, set))
      against.push_back(i);
  if (2 * comparison.largestSet(against).size() > set.size()) return {};
  std::sort(set.begin(), set.end());
  std::vector<FoundKeyframe> out;
  for (const std::size_t i : set) out.push_back(found[i]);
  return out;
}

}  // namespace facetloc::internal

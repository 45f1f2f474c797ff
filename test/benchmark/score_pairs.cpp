// SPDX-License-Identifier: BSD-3-Clause
//
// Registration of pairs of single images from one place: how many are found, how well, how fast.
//
//   score_pairs [--param=value ...] SEQUENCE...     sequences with ground truth in one common world
//
// Pairs are 0.6-1.7 m and 20-60 deg apart by the true poses and share at least 30 % of their pixels; a fixed
// seed chooses them. The prior is 60 deg and 1.5 m about the identity. Registered = within 0.3 m and 10 deg
// of the truth; sure = with a probability of 0.9 or more, by depth and segments (PlanarRegistration) and by
// segments alone (EkfRegistration). Where the sequences reach that far, unrelated pairs follow, more than 4 m
// apart and without a pixel in common, of which none should be sure.
#include "image_overlap.h"
#include "set_parameter.h"
#include "shared/median.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/registration/pair_registration.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace {

using namespace facetloc;

constexpr int kPairs = 40, kUnrelatedPairs = 60;
constexpr double kUnrelatedDistance = 4;  // [m]
constexpr std::uint32_t kSeed = 1;
constexpr double kMaxTranslationError = 0.3, kMaxRotationError = 10 * kDegree;

struct Frame {
  std::string name;
  DepthImage image;
  Eigen::Isometry3d T_w_c;
};

double milliseconds(std::chrono::steady_clock::time_point since) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
}

std::vector<Frame> readFrames(const std::vector<std::string>& folders) {
  std::vector<Frame> frames;
  for (const std::string& folder : folders) {
    const DepthSequence sequence = DepthSequence::open(folder);
    for (std::size_t i = 0; i < sequence.frames().size(); ++i)
      if (const auto T = sequence.groundTruth().at(sequence.frames()[i].stamp))
        frames.push_back({sequence.frames()[i].name, sequence.load(i, kWorkingWidth), *T});
  }
  return frames;
}

std::vector<std::pair<int, int>> choosePairs(const std::vector<Frame>& frames) {
  std::mt19937 random(kSeed);
  std::vector<std::pair<int, int>> pairs;
  for (int attempt = 0; attempt < 200000 && static_cast<int>(pairs.size()) < kPairs; ++attempt) {
    const int i = static_cast<int>(random() % frames.size()), j = static_cast<int>(random() % frames.size());
    const Eigen::Isometry3d T = frames[j].T_w_c.inverse() * frames[i].T_w_c;
    const double distance = T.translation().norm(), angle = rotationAngle(T.linear());
    if (distance < 0.6 || distance > 1.7 || angle < 20 * kDegree || angle > 60 * kDegree) continue;
    if (benchmarks::overlap(frames[i].image, frames[j].image, T) < 0.3) continue;
    if (benchmarks::overlap(frames[j].image, frames[i].image, T.inverse()) < 0.3) continue;
    pairs.emplace_back(i, j);
  }
  return pairs;
}

std::vector<std::pair<int, int>> chooseUnrelatedPairs(const std::vector<Frame>& frames) {
  std::mt19937 random(kSeed);
  std::vector<std::pair<int, int>> pairs;
  for (int attempt = 0; attempt < 200000 && static_cast<int>(pairs.size()) < kUnrelatedPairs; ++attempt) {
    const int i = static_cast<int>(random() % frames.size()), j = static_cast<int>(random() % frames.size());
    const Eigen::Isometry3d T = frames[j].T_w_c.inverse() * frames[i].T_w_c;
    if (T.translation().norm() < kUnrelatedDistance) continue;
    if (benchmarks::overlap(frames[i].image, frames[j].image, T) > 0) continue;
    if (benchmarks::overlap(frames[j].image, frames[i].image, T.inverse()) > 0) continue;
    pairs.emplace_back(i, j);
  }
  return pairs;
}

struct PairError {
  double translation, rotation;
  bool registered() const { return translation <= kMaxTranslationError && rotation <= kMaxRotationError; }
};

PairError errorOf(const Hypothesis& h, const Eigen::Isometry3d& truth) {
  return {(h.T_m_c.T.translation() - truth.translation()).norm(),
          rotationAngle(h.T_m_c.T.linear() * truth.linear().transpose())};
}

double medianOrZero(std::vector<double> values) {
  return values.empty() ? 0 : internal::median(values.begin(), values.end());
}

struct PairAnswers {
  Localization by_depth, by_segments;
};

PairAnswers registerPair(const View& scene, const View& target, const RegistrationParams& params) {
  PairAnswers answers;
  answers.by_depth = PairRegistration(target, params).align(scene);
  View bare_scene = scene, bare_target = target;
  bare_scene.depth = bare_target.depth = {};
  answers.by_segments = PairRegistration(bare_target, params).align(bare_scene);
  return answers;
}

bool isSure(const Localization& answer) { return answer.state() == AnswerState::sure; }
double probabilityOf(const Localization& answer) {
  return answer.hypotheses.empty() ? 0 : answer.hypotheses.front().probability;
}

void scoreUnrelated(const std::vector<Frame>& frames, ViewBuilder& builder,
                    const RegistrationParams& params) {
  const std::vector<std::pair<int, int>> pairs = chooseUnrelatedPairs(frames);
  if (pairs.empty()) return;
  int sure = 0, sure_by_segments = 0, any = 0;
  double highest = 0, highest_by_segments = 0;
  for (const auto& [i, j] : pairs) {
    const View scene = builder.build(frames[i].image), target = builder.build(frames[j].image);
    const PairAnswers answers = registerPair(scene, target, params);
    const double p = probabilityOf(answers.by_depth), q = probabilityOf(answers.by_segments);
    std::printf("%-11s %-11s unrelated, %.2f m apart: probability %.3f, by segments alone %.3f\n",
                frames[i].name.c_str(), frames[j].name.c_str(),
                (frames[i].T_w_c.translation() - frames[j].T_w_c.translation()).norm(), p, q);
    any += !answers.by_depth.hypotheses.empty();
    sure += isSure(answers.by_depth);
    sure_by_segments += isSure(answers.by_segments);
    highest = std::max(highest, p);
    highest_by_segments = std::max(highest_by_segments, q);
  }
  std::printf(
      "of %zu unrelated pairs %d have a pose, %d are sure (highest probability %.3f), by segments alone "
      "%d (%.3f)\n",
      pairs.size(), any, sure, highest, sure_by_segments, highest_by_segments);
}

}  // namespace

int main(int argc, char** argv) {
  ViewParams view_params;
  RegistrationParams params;
  params.prior.rotation_std_deg = 60;
  params.prior.translation_std = 1.5;
  std::vector<std::string> folders;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("--", 0) != 0)
      folders.push_back(argument);
    else if (!benchmarks::setByArgument(view_params, argument) &&
             !benchmarks::setByArgument(params, argument)) {
      std::fprintf(stderr, "score_pairs: unknown parameter %s\n", argv[i]);
      return 2;
    }
  }
  if (folders.empty()) {
    std::fprintf(stderr, "usage: score_pairs [--param=value ...] SEQUENCE...\n");
    return 2;
  }
  const std::vector<Frame> frames = readFrames(folders);
  const std::vector<std::pair<int, int>> pairs =
      frames.empty() ? std::vector<std::pair<int, int>>{} : choosePairs(frames);
  if (pairs.empty()) {
    std::fprintf(stderr,
                 "score_pairs: no pair of frames with true poses is far enough apart and overlaps enough\n");
    return 1;
  }

  ViewBuilder builder({}, view_params);
  int registered = 0, anywhere = 0, sure = 0, sure_right = 0, segments_sure = 0, segments_right = 0;
  std::vector<double> view_ms, align_ms, translation_errors, rotation_errors;
  std::printf("source      target      distance angle | hyps  rank   error        probability | segments\n");
  for (const auto& [i, j] : pairs) {
    const Eigen::Isometry3d truth = frames[j].T_w_c.inverse() * frames[i].T_w_c;
    auto start = std::chrono::steady_clock::now();
    const View scene = builder.build(frames[i].image);
    const PairRegistration registration(builder.build(frames[j].image), params);
    view_ms.push_back(milliseconds(start));
    start = std::chrono::steady_clock::now();
    const Localization answer = registration.align(scene);
    align_ms.push_back(milliseconds(start));

    int rank = 0;
    for (std::size_t k = 0; k < answer.hypotheses.size() && !rank; ++k)
      if (errorOf(answer.hypotheses[k], truth).registered()) rank = static_cast<int>(k) + 1;
    registered += rank == 1;
    anywhere += rank > 0;
    const PairError first =
        answer.hypotheses.empty() ? PairError{9.99, kDegree * 180} : errorOf(answer.hypotheses[0], truth);
    const auto isRight = [&](const Localization& a) {
      return errorOf(a.hypotheses.front(), truth).registered();
    };
    sure += isSure(answer);
    sure_right += isSure(answer) && isRight(answer);
    const Localization by_segments = registerPair(scene, registration.target(), params).by_segments;
    segments_sure += isSure(by_segments);
    segments_right += isSure(by_segments) && isRight(by_segments);
    if (rank == 1) translation_errors.push_back(first.translation), rotation_errors.push_back(first.rotation);
    std::printf("%-11s %-11s %5.2f m %5.1f | %4zu %5d %6.3f m %6.2f %8.3f%s | %zu %zu  %.1f ms\n",
                frames[i].name.c_str(), frames[j].name.c_str(), truth.translation().norm(),
                rotationAngle(truth.linear()) / kDegree, answer.hypotheses.size(), rank, first.translation,
                first.rotation / kDegree, answer.hypotheses.empty() ? 0.0 : answer.hypotheses[0].probability,
                !answer.hypotheses.empty() && answer.hypotheses[0].depth_assisted ? "d" : " ",
                scene.segments.size(), registration.target().segments.size(), align_ms.back());
  }
  std::printf("%d of %zu pairs registered (rank 1 within %.1f m and %.0f deg), %d anywhere in the list\n",
              registered, pairs.size(), kMaxTranslationError, kMaxRotationError / kDegree, anywhere);
  std::printf("sure: %d, of these right %d; by segments alone %d, of these right %d\n", sure, sure_right,
              segments_sure, segments_right);
  std::printf(
      "median error %.3f m %.2f deg; median time per pair: views %.1f ms, registration %.1f ms (max %.1f)\n",
      medianOrZero(translation_errors), medianOrZero(rotation_errors) / kDegree, medianOrZero(view_ms),
      medianOrZero(align_ms), *std::max_element(align_ms.begin(), align_ms.end()));
  scoreUnrelated(frames, builder, params);
}

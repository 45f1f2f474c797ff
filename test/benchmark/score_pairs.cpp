// SPDX-License-Identifier: BSD-3-Clause
//
// Registration of pairs of single images from one place: how many are found, how well, how fast.
//
//   score_pairs [--param=value ...] [--clouds | --peers] SEQUENCE...
//
// The sequences have ground truth in one common world. Pairs are 0.6-1.7 m and 20-60 deg apart by the true
// poses and share at least 30 % of their pixels (--min_distance=..., see PairChoice); a fixed seed chooses
// them. The prior is 60 deg and 1.5 m about the identity. Registered = within 0.3 m and 10 deg of the truth;
// sure = with a probability of 0.9 or more, by depth and by segments alone. Where the sequences reach that
// far, unrelated pairs follow, more than 4 m apart and without a pixel in common, of which none should be
// sure.
//
// --clouds: the same pairs as organized clouds of full size, by the PCL classes with nothing set but
// --camera=PRESET.
// --peers: beside PCL's own registrations. --others=SEQUENCE: unrelated pairs are completed by one image of
// each.
#include "base/median.h"
#include "cloud_registrations.h"
#include "posed_pairs.h"
#include "programs.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/registration/pair_registration.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/organized_clouds.h>

#include <pcl/console/print.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>

namespace {

using namespace facetloc;

constexpr double kMaxTranslationError = 0.3, kMaxRotationErrorDeg = 10;

using namespace benchmarks;

bool isRegistered(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  return isNear(T, truth, kMaxTranslationError, kMaxRotationErrorDeg);
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

bool isSure(const Localization& answer) { return answer.state == AnswerState::sure; }
double probabilityOf(const Localization& answer) {
  return answer.hypotheses.empty() ? 0 : answer.hypotheses.front().probability;
}

View viewOf(const PosedFrame& frame, ViewBuilder& builder) {
  return builder.build(frame.image(kWorkingWidth));
}

void scoreUnrelated(const std::vector<PosedFrame>& frames, const std::vector<FramePair>& pairs,
                    ViewBuilder& builder, const RegistrationParams& params) {
  if (pairs.empty()) return;
  int sure = 0, sure_by_segments = 0, any = 0;
  double highest = 0, highest_by_segments = 0;
  for (const auto& [i, j] : pairs) {
    const PairAnswers answers = registerPair(viewOf(frames[i], builder), viewOf(frames[j], builder), params);
    const double p = probabilityOf(answers.by_depth), q = probabilityOf(answers.by_segments);
    std::printf("%-11s %-11s unrelated, %.2f m apart: probability %.3f, by segments alone %.3f\n",
                frames[i].name().c_str(), frames[j].name().c_str(),
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

void scoreRelated(const std::vector<PosedFrame>& frames, const std::vector<FramePair>& pairs,
                  ViewBuilder& builder, const RegistrationParams& params) {
  int registered = 0, anywhere = 0, sure = 0, sure_right = 0, segments_sure = 0, segments_right = 0;
  std::vector<double> view_ms, align_ms, translation_errors, rotation_errors;
  std::printf("source      target      distance angle | hyps  rank   error        probability | segments\n");
  for (const auto& [i, j] : pairs) {
    const Eigen::Isometry3d truth = trueMotion(frames[i], frames[j]);
    const DepthImage source_image = frames[i].image(kWorkingWidth),
                     target_image = frames[j].image(kWorkingWidth);
    auto start = std::chrono::steady_clock::now();
    const View scene = builder.build(source_image);
    const PairRegistration registration(builder.build(target_image), params);
    view_ms.push_back(milliseconds(start));
    start = std::chrono::steady_clock::now();
    const Localization answer = registration.align(scene);
    align_ms.push_back(milliseconds(start));

    int rank = 0;
    for (std::size_t k = 0; k < answer.hypotheses.size() && !rank; ++k)
      if (isRegistered(answer.hypotheses[k].T_m_c.T, truth)) rank = static_cast<int>(k) + 1;
    registered += rank == 1;
    anywhere += rank > 0;
    double translation = 9.99, rotation = kDegree * 180;  // errors of the first
    if (!answer.hypotheses.empty()) {
      const Eigen::Isometry3d& T = answer.hypotheses[0].T_m_c.T;
      translation = (T.translation() - truth.translation()).norm();
      rotation = rotationAngle(T.linear() * truth.linear().transpose());
    }
    const auto isRight = [&](const Localization& a) {
      return isRegistered(a.hypotheses.front().T_m_c.T, truth);
    };
    sure += isSure(answer);
    sure_right += isSure(answer) && isRight(answer);
    const Localization by_segments = registerPair(scene, registration.target(), params).by_segments;
    segments_sure += isSure(by_segments);
    segments_right += isSure(by_segments) && isRight(by_segments);
    if (rank == 1) translation_errors.push_back(translation), rotation_errors.push_back(rotation);
    std::printf("%-11s %-11s %5.2f m %5.1f | %4zu %5d %6.3f m %6.2f %8.3f%s | %zu %zu  %.1f ms\n",
                frames[i].name().c_str(), frames[j].name().c_str(), truth.translation().norm(),
                rotationAngle(truth.linear()) / kDegree, answer.hypotheses.size(), rank, translation,
                rotation / kDegree, probabilityOf(answer),
                !answer.hypotheses.empty() && answer.hypotheses[0].depth_assisted ? "d" : " ",
                scene.segments.size(), registration.target().segments.size(), align_ms.back());
  }
  std::printf("%d of %zu pairs registered (rank 1 within %.1f m and %.0f deg), %d anywhere in the list\n",
              registered, pairs.size(), kMaxTranslationError, kMaxRotationErrorDeg, anywhere);
  std::printf("sure: %d, of these right %d; by segments alone %d, of these right %d\n", sure, sure_right,
              segments_sure, segments_right);
  std::printf(
      "median error %.3f m %.2f deg; median time per pair: views %.1f ms, registration %.1f ms (max %.1f)\n",
      medianOrZero(translation_errors), medianOrZero(rotation_errors) / kDegree, medianOrZero(view_ms),
      medianOrZero(align_ms), *std::max_element(align_ms.begin(), align_ms.end()));
}

/** The results of one way to register clouds for all pairs. */
struct CloudScore {
  int right = 0, converged = 0, converged_right = 0, unrelated_converged = 0;
  std::vector<double> merits_of_right, ms;
  double best_wrong = -std::numeric_limits<double>::infinity();

  void add(const CloudAnswer& answer, bool is_right) {
    right += is_right, converged += answer.converged;
    converged_right += answer.converged && is_right;
    if (is_right)
      merits_of_right.push_back(answer.merit);
    else if (answer.has_pose)
      best_wrong = std::max(best_wrong, answer.merit);
  }
  void addUnrelated(const CloudAnswer& answer) {
    unrelated_converged += answer.converged;
    if (answer.has_pose) best_wrong = std::max(best_wrong, answer.merit);
  }
  /** Right answers that say more of themselves than any wrong one. */
  long toldApart() const {
    return std::count_if(merits_of_right.begin(), merits_of_right.end(),
                         [&](double merit) { return merit > best_wrong; });
  }
};

void scoreClouds(const std::vector<CloudRegistration>& ways, const std::vector<PosedFrame>& frames,
                 const std::vector<FramePair>& related, const std::vector<FramePair>& unrelated) {
  std::printf("of %zu related and %zu unrelated pairs, as clouds of full size:\n", related.size(),
              unrelated.size());
  std::printf("%-44s %5s %10s %14s %10s %11s %9s\n", "", "right", "converged", "of these right", "unrelated",
              "told apart", "ms");
  for (const CloudRegistration& way : ways) {
    CloudScore score;
    const auto align = [&](const FramePair& pair) {
      const Cloud::Ptr source = test::organizedCloud<pcl::PointXYZ>(frames[pair.first].image(0)),
                       target = test::organizedCloud<pcl::PointXYZ>(frames[pair.second].image(0));
      const auto start = std::chrono::steady_clock::now();
      const CloudAnswer answer = way.align(source, target);
      score.ms.push_back(milliseconds(start));
      return answer;
    };
    for (const FramePair& pair : related) {
      const CloudAnswer answer = align(pair);
      const Eigen::Isometry3d truth = trueMotion(frames[pair.first], frames[pair.second]);
      score.add(answer, answer.has_pose && isRegistered(answer.T, truth));
    }
    for (const FramePair& pair : unrelated) score.addUnrelated(align(pair));
    std::printf("%-44s %5d %10d %14d %10d %11ld %9.1f\n", way.name.c_str(), score.right, score.converged,
                score.converged_right, score.unrelated_converged, score.toldApart(), medianOrZero(score.ms));
    std::fflush(stdout);
  }
}

/** The command line. */
struct Options {
  ViewParams view;
  RegistrationParams registration;
  PairChoice pairs;
  Camera camera;
  bool clouds = false, with_peers = false;
  std::vector<std::string> folders, others;

  Options() { registration.prior.rotation_std_deg = 60, registration.prior.translation_std = 1.5; }
  bool take(const std::string& argument) {
    const auto valueOf = [&argument](const std::string& name) -> std::optional<std::string> {
      if (argument.rfind(name + "=", 0) != 0) return std::nullopt;
      return argument.substr(name.size() + 1);
    };
    if (argument == "--clouds") return clouds = true;
    if (argument == "--peers") return clouds = with_peers = true;
    if (const auto other = valueOf("--others")) return others.push_back(*other), true;
    if (const auto name = valueOf("--camera")) {
      const CameraPreset* preset = findCameraPreset(*name);
      if (preset) camera = preset->camera();
      return preset;
    }
    if (argument.rfind("--", 0) != 0) return folders.push_back(argument), true;
    return setByArgument(pairs, argument) || setByArgument(view, argument) ||
           setByArgument(registration, argument);
  }
};

std::vector<DepthSequence> opened(const std::vector<std::string>& folders) {
  std::vector<DepthSequence> sequences;
  for (const std::string& folder : folders) sequences.push_back(DepthSequence::open(folder));
  return sequences;
}

/** Completes unrelated pairs by one image of the sequences and one of others, which show another place. */
void addOthers(std::vector<PosedFrame>& frames, const std::vector<PosedFrame>& others, int count,
               std::vector<FramePair>& pairs) {
  std::mt19937 random(1);
  const std::size_t own = frames.size();
  frames.insert(frames.end(), others.begin(), others.end());
  while (!others.empty() && static_cast<int>(pairs.size()) < count) {
    const std::size_t i = random() % own, j = random() % others.size();
    pairs.emplace_back(i, own + j);
  }
}

void run(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i)
    if (!options.take(argv[i])) throw std::invalid_argument(std::string("unknown parameter ") + argv[i]);
  if (options.folders.empty())
    throw Usage{"score_pairs [--param=value ...] [--clouds | --peers] SEQUENCE..."};
  const std::vector<DepthSequence> sequences = opened(options.folders),
                                   other_sequences = opened(options.others);
  std::vector<PosedFrame> frames = posedFrames(sequences);
  const std::vector<FramePair> related = relatedPairs(frames, options.pairs);
  if (related.empty())
    throw std::runtime_error("no pair of frames with true poses is far enough apart and overlaps enough");
  std::vector<FramePair> unrelated = unrelatedPairs(frames, options.pairs);
  addOthers(frames, posedFrames(other_sequences), options.pairs.unrelated, unrelated);

  if (options.clouds) {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    std::vector<CloudRegistration> ways = ours(options.camera);
    if (options.with_peers)
      for (CloudRegistration& way : peers()) ways.push_back(std::move(way));
    return scoreClouds(ways, frames, related, unrelated);
  }
  ViewBuilder builder(options.camera, options.view);
  scoreRelated(frames, related, builder, options.registration);
  scoreUnrelated(frames, unrelated, builder, options.registration);
}

}  // namespace

int main(int argc, char** argv) {
  return runProgram("score_pairs", [&] { run(argc, argv); });
}

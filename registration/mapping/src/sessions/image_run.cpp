// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/image_run.h"

#include "base/median.h"
#include "base/odometry_steps.h"

#include <facetloc/registration/pair_registration.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>

namespace facetloc::internal {
namespace {

using Stage = MapProgress::Stage;

constexpr std::size_t kImagesPerThread = 16;  // views built ahead of the one that is taken
constexpr std::size_t kSample = 24;           // images
constexpr double kLeastTurn = 1 * kDegree, kLeastDistance = 0.02;  // least motion that is compared [m]
constexpr double kMostTurn = 15 * kDegree, kMostDistance = 0.4;    // after which no longer one is tried

/** Motions from keyframe to keyframe, by the images. */
std::vector<SeenMotion> motionsOf(const CameraTrajectory& trajectory) {
  std::vector<SeenMotion> motions;
  const auto stampOf = [&](int k) { return trajectory.images[trajectory.keyframes[k].image].stamp; };
  for (const KeyframeMotion& m : trajectory.motions)
    if (m.source == KeyframeMotion::Source::overlap && m.to == m.from + 1)
      motions.push_back({stampOf(m.from), stampOf(m.to), m.T_from_to.T});
  return motions;
}

/** Turn [rad] and distance [m] of a motion, equally weighted as those of steps between images. */
double lengthOf(double turn, double distance) {
  constexpr double kTurn = 10 * kDegree, kDistance = 0.2;  // [rad, m]
  return turn / kTurn + distance / kDistance;
}
double lengthOf(const Eigen::Isometry3d& T) {
  return lengthOf(rotationAngle(T.linear()), T.translation().norm());
}

/** A step between neighbouring images by their poses. */
struct PoseStep {
  std::size_t first = 0;  // image
  double length = 0;
  double excess = 0;  // beyond the median of it and the two steps before and after it
};

double medianOf(const std::vector<PoseStep>& steps, double PoseStep::*quantity) {
  std::vector<double> values;
  for (const PoseStep& step : steps) values.push_back(std::abs(step.*quantity));
  return median(std::move(values));
}

std::vector<PoseStep> stepsOf(const std::vector<MapImage>& images) {
  constexpr std::size_t kAround = 2;
  std::vector<PoseStep> steps;
  for (std::size_t i = 0; i + 1 < images.size(); ++i)
    if (images[i].T_w_c && images[i + 1].T_w_c)
      steps.push_back({i, lengthOf(images[i].T_w_c->inverse() * *images[i + 1].T_w_c), 0});
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const auto begin = steps.begin() + static_cast<std::ptrdiff_t>(k - std::min(k, kAround));
    const auto end = steps.begin() + static_cast<std::ptrdiff_t>(std::min(steps.size(), k + kAround + 1));
    steps[k].excess = steps[k].length - medianOf({begin, end}, &PoseStep::length);
  }
  return steps;
}

/** A view as of a camera in the hand, whatever is known of its mounting. */
View unmounted(View view) {
  view.camera.reset();
  return view;
}

/** Motions to the images 1, 2, 4, ... after one, as long as they show the same. */
std::vector<SeenMotion> motionsFrom(std::size_t first, const ImageRun& run, ViewBuilders& builders) {
  std::vector<SeenMotion> motions;
  const std::vector<MapImage>& images = run.images;
  const PairRegistration target(unmounted(run.viewOf(first, builders)));
  for (std::size_t gap = 1; first + gap < images.size(); gap *= 2) {
    const Localization answer = target.align(unmounted(run.viewOf(first + gap, builders)));
    if (answer.state != AnswerState::sure) break;
    const Eigen::Isometry3d& T = answer.hypotheses.front().T_m_c.T;
    const double turn = rotationAngle(T.linear()), distance = T.translation().norm();
    if (turn > kLeastTurn || distance > kLeastDistance)
      motions.push_back({images[first].stamp, images[first + gap].stamp, T});
    if (turn > kMostTurn || distance > kMostDistance) break;
  }
  return motions;
}

}  // namespace

View ViewBuilders::build(const DepthImage& image, const std::optional<Gravity>& gravity) {
  std::unique_ptr<ViewBuilder> builder;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!idle_.empty()) {
      builder = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!builder) builder = std::make_unique<ViewBuilder>(camera_, params_);
  View view = builder->build(image, gravity);
  const std::lock_guard<std::mutex> lock(mutex_);
  idle_.push_back(std::move(builder));
  return view;
}

bool ImageRun::hasPoses() const {
  return std::any_of(images.begin(), images.end(),
                     [](const MapImage& image) { return image.T_w_c.has_value(); });
}

std::vector<std::size_t> ImageRun::all() const {
  std::vector<std::size_t> numbers(images.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

std::vector<std::size_t> ImageRun::sample() const {
  std::vector<std::size_t> numbers(std::min(images.size(), kSample));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i * images.size() / numbers.size();
  return numbers;
}

DepthImage ImageRun::read(std::size_t i) const {
  const DepthImage* kept = kept_images.find(i);
  DepthImage image = kept ? *kept : images[i].load();
  if (kept_pictures.lacks(i)) kept_pictures.keep(i, DepthPicture::fromDepth(image));
  if (kept_images.lacks(i)) kept_images.keep(i, image);
  return image;
}

void ImageRun::buildViews(const std::vector<std::size_t>& numbers, Stage of_progress,
                          std::vector<UnreadImage>& unread, const Take& take) const {
  ParallelStage work = stage(of_progress, numbers.size());
  ViewBuilders builders(camera, view);
  const std::size_t chunk = kImagesPerThread * static_cast<std::size_t>(work.threads());
  for (std::size_t first = 0; first < numbers.size(); first += chunk) {
    const std::size_t last = std::min(first + chunk, numbers.size());
    std::vector<std::optional<View>> views(last - first);
    std::vector<std::string> causes(last - first);
    work.run(first, last, [&](std::size_t i) {
      try {
        views[i - first] = viewOf(numbers[i], builders);
      } catch (const std::exception& e) {
        causes[i - first] = e.what();
      }
    });
    for (std::size_t i = first; i < last; ++i) {
      if (!views[i - first]) unread.push_back({numbers[i], causes[i - first]});
      take(numbers[i], std::move(views[i - first]));
    }
  }
}

CameraTrajectory ImageRun::findTrajectory(const MappingParams& params, MapFindings& findings) const {
  TrajectoryEstimation estimation(params);
  estimation.setNumberOfThreads(threads);
  OdometrySteps steps;
  findings.unread.clear();
  findings.without_odometry = 0;
  buildViews(all(), Stage::trajectory, findings.unread, [&](std::size_t i, std::optional<View> built) {
    const auto T_o_c = odometry ? odometry(images[i].stamp) : std::nullopt;
    findings.without_odometry += odometry && !T_o_c;
    estimation.add(built ? std::move(*built) : View(), images[i].stamp, steps.to(T_o_c));
  });
  if (findings.noneRead(images.size())) return {};
  estimation.improve([this](double share) {
    if (progress) progress({Stage::loops, static_cast<std::size_t>(std::lround(100 * share)), 100});
  });
  CameraTrajectory found = estimation.trajectory();
  if (odometry) findings.odometry = checkPoses(motionsOf(found), odometry);
  return found;
}

void ImageRun::level(CameraTrajectory& trajectory) const {
  std::map<int, Eigen::Vector3d> down;  // direction in each part, weighted by accuracy
  for (std::size_t i = 0; i < trajectory.images.size(); ++i) {
    const TrajectoryPose& pose = trajectory.images[i];
    const std::optional<Gravity>& measured = images[i].gravity;
    if (!measured || !measured->valid()) continue;
    const Eigen::Vector3d in_world = pose.T_w_c.linear() * measured->down;
    down.try_emplace(trajectory.partOf(pose), Eigen::Vector3d::Zero()).first->second +=
        in_world / (measured->std * measured->std);
  }
  const auto upright = [&](int part) {
    const auto found = down.find(part);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    if (found != down.end() && found->second.norm() > 0)
      T.linear() = rotationBetween(found->second.normalized(), -Eigen::Vector3d::UnitZ());
    return T;
  };
  for (TrajectoryPose& pose : trajectory.images) pose.T_w_c = upright(trajectory.partOf(pose)) * pose.T_w_c;
  for (Keyframe& keyframe : trajectory.keyframes) keyframe.T_w_c = upright(keyframe.part) * keyframe.T_w_c;
}

std::vector<PoseJump> ImageRun::poseJumps(PoseCheck& check) const {
  constexpr double kLonger = 5, kLeast = 0.04;  // times the usual step, or excess; least usual excess
  constexpr std::size_t kMostTried = 8;
  std::vector<PoseStep> steps = stepsOf(images);
  if (steps.empty()) return {};
  const double usual = std::max(1.0, medianOf(steps, &PoseStep::length)),
               usual_excess = std::max(kLeast, medianOf(steps, &PoseStep::excess));
  std::stable_sort(steps.begin(), steps.end(),
                   [](const PoseStep& a, const PoseStep& b) { return a.excess > b.excess; });
  const double disagreement = lengthOf(check.as_given.rotation_deg * kDegree, check.as_given.translation);
  std::vector<PoseJump> jumps;
  ViewBuilders builders(camera, view);
  const auto unmountedView = [&](std::size_t i) { return unmounted(viewOf(i, builders)); };
  for (std::size_t k = 0; k < std::min(steps.size(), kMostTried) && steps[k].excess > kLonger * usual_excess;
       ++k)
    try {
      const std::size_t i = steps[k].first;
      PoseJump jump{i + 1,
                    images[i].stamp,
                    images[i + 1].stamp,
                    images[i].T_w_c->inverse() * *images[i + 1].T_w_c,
                    {},
                    images[i].timed && images[i + 1].timed};
      const bool is_far = steps[k].length > kLonger * usual;
      const Localization seen = PairRegistration(unmountedView(i)).align(unmountedView(i + 1));
      if (seen.state != AnswerState::sure) {
        if (is_far && jump.isTooFast()) jumps.push_back(std::move(jump));
        continue;
      }
      const PoseWithCovariance& by_images = seen.hypotheses.front().T_m_c;
      jump.by_images = by_images.T;
      const Eigen::Isometry3d off = by_images.T.inverse() * jump.by_poses;
      const double deviation =
          disagreement + lengthOf(largestRotationStd(by_images.P), largestTranslationStd(by_images.P));
      if (is_far && lengthOf(off) > kLonger * usual)
        jumps.push_back(std::move(jump));
      else if (lengthOf(off) > kLonger * std::max(kLeast, deviation))
        check.outliers.push_back(
            {jump.stamp_a, jump.stamp_b, rotationAngle(off.linear()) / kDegree, off.translation().norm()});
    } catch (const std::exception&) {  // the image is named when it is read for the map
    }
  return jumps;
}

std::vector<SeenMotion> ImageRun::seenMotions() const {
  const std::vector<std::size_t> starts = sample();
  std::vector<std::vector<SeenMotion>> motions(starts.size());
  ViewBuilders builders(camera, view);
  stage(Stage::poses, starts.size()).run([&](std::size_t i) {
    try {
      motions[i] = motionsFrom(starts[i], *this, builders);
    } catch (const std::exception&) {  // the image is named when it is read for the map
    }
  });
  std::vector<SeenMotion> all;
  for (const auto& of_start : motions) all.insert(all.end(), of_start.begin(), of_start.end());
  return all;
}

}  // namespace facetloc::internal

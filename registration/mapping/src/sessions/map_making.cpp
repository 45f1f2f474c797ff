// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/distortion_calibration.h"
#include "calibration/map_ambiguity.h"
#include "sessions/image_run.h"
#include "trajectory/trajectory_graph.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/mapping/map_making.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

using Stage = MapProgress::Stage;

constexpr std::size_t kCalibrationImages = 200;  // at most

/** The poses of the images themselves, at their times. */
PosesByTime posesOf(const std::vector<MapImage>& images) {
  std::map<double, Eigen::Isometry3d> by_time;
  for (const MapImage& image : images)
    if (image.T_w_c) by_time.emplace(image.stamp, *image.T_w_c);
  return [by_time](double stamp) -> std::optional<Eigen::Isometry3d> {
    const auto found = by_time.find(stamp);
    return found == by_time.end() ? std::nullopt : std::optional(found->second);
  };
}

/** A map that is made in memory. */
class MapInMemory : public MapSink {
public:
  explicit MapInMemory(std::shared_ptr<Map> map) : map_(std::move(map)) {}

  std::shared_ptr<Map> map() override { return map_; }
  void setCamera(const Camera& camera) override { map_->camera = camera; }
  void setMeta(const std::string& key, const std::string& value) override { map_->meta[key] = value; }
  void add(const Link& link) override { map_->links.push_back(link); }
  void setWhole() override { placeByLinks(*map_); }

private:
  std::shared_ptr<Map> map_;
};

AliasScores findAliases(const std::shared_ptr<const Map>& map, const MapCompletion& how) {
  AliasScores scores(map->models.size());
  const std::vector<int> models = viewsToAsk(*map);
  if (models.empty()) return scores;
  const GlobalLocalization localization(map);
  ParallelStage(MapProgress::Stage::ambiguity, models.size(), how.threads, how.progress)
      .run([&](std::size_t i) {
        if (const auto wrong = wrongPlace(localization, models[i])) scores[models[i]] = wrong->score;
      });
  return scores;
}

}  // namespace

void MapMakingParams::validate() const {
  checkRanges(places);
  checkRanges(trajectory);
  checkRanges(view);
  if (every < 0) throw std::invalid_argument("every must not be negative");
}

std::optional<FoundMounting> completeMap(MapSink& sink, const MapCompletion& how) {
  const std::shared_ptr<Map> map = sink.map();
  std::optional<FoundMounting> found;
  if (how.mounting && !map->camera.mounting) found = findMounting(*map);
  if (found) {
    map->camera.mounting = found->mounting;
    placeByLinks(*map);  // up is known now
    sink.setMounting(map->camera, *found);
  }
  sink.setPlaceIndex(*map);
  if (map->meta.count(kConsideredErrorsKey) == 0) {
    if (const std::vector<RealignedView> views = realignedViews(map, how.threads); !views.empty())
      sink.setMeta(kConsideredErrorsKey, map->meta[kConsideredErrorsKey] = toText(consideredErrors(views)));
  }
  if (map->ambiguity) return found;
  const AliasScores scores = findAliases(map, how);
  setAmbiguity(scores, *map);
  if (map->ambiguity) sink.setAmbiguity(*map->ambiguity, scores);
  return found;
}

std::optional<FoundMounting> completeMap(const std::shared_ptr<Map>& map, const MapCompletion& how) {
  MapInMemory sink(map);
  return completeMap(sink, how);
}

namespace {

/** How the trajectory contradicts the images that it was found from. */
void judge(const CameraTrajectory& trajectory, Findings& all) {
  constexpr double kContradicted = 0.2;  // share of the overlaps
  constexpr int kLeastJudged = 20;       // overlaps
  constexpr const char* kCure = "give poses (--poses) or an odometry (--odometry), or record more slowly, "
                                "with more in common between images";
  const OverlapVerdicts& overlaps = trajectory.overlaps;
  if (overlaps.judged() >= kLeastJudged && overlaps.contradictedShare() > kContradicted)
    all.push_back({"trajectory.contradicted", Severity::refusal,
                   "the trajectory found from the images is wrong: " + overlaps.toString(), kCure,
                   std::vector<Evidence>{{"contradicted_share", overlaps.contradictedShare()},
                                         {"overlaps", static_cast<double>(overlaps.judged())}}});
  if (trajectory.cut_bonds > 0)
    all.push_back({"trajectory.cut", Severity::note,
                   fmt::format("{} {} between pieces of the trajectory taken out, which overlapping images "
                               "contradict",
                               trajectory.cut_bonds, trajectory.cut_bonds == 1 ? "bond" : "bonds"),
                   ""});
  const std::vector<int> parts = trajectory.parts();
  if (parts.size() < 2) return;
  const auto outside =
      std::count_if(trajectory.images.begin(), trajectory.images.end(),
                    [&](const TrajectoryPose& pose) { return trajectory.partOf(pose) != parts.front(); });
  all.push_back({"trajectory.parts", Severity::note,
                 fmt::format("the images are not all connected: {} {} in {} {} that nothing ties to the "
                             "largest one; their local models have no pose in its world",
                             outside, outside == 1 ? "image" : "images", parts.size() - 1,
                             parts.size() == 2 ? "piece" : "pieces"),
                 ""});
}

/** A distortion that cannot be separated from the errors of the poses. */
void judge(const DistortionEstimate& found, bool own_trajectory, Findings& all) {
  constexpr double kSenselessDegrees = 20;
  if (found.reliable()) return;
  const double degrees = found.poses.rotation_std / kDegree, mm = 1e3 * found.poses.translation_std;
  const std::vector<Evidence> evidence{{"rotation_deg", degrees}, {"translation_mm", mm}};
  if (own_trajectory && degrees > kSenselessDegrees) {
    const std::string words = fmt::format(
        "the trajectory found from the images is accurate to {:.0f} deg, {:.0f} mm only", degrees, mm);
    all.push_back({"trajectory.uncertain", Severity::refusal, words,
                   "give poses (--poses) or an odometry (--odometry)", evidence});
    return;
  }
  const std::string words =
      own_trajectory ? fmt::format("the distortion of the camera is not estimated: the trajectory is "
                                   "accurate to {:.2f} deg, {:.0f} mm only",
                                   degrees, mm)
                     : fmt::format("the distortion of the camera is not removed: the poses disagree too "
                                   "much with the images ({:.2f} deg, {:.0f} mm) to find it",
                                   degrees, mm);
  all.push_back({"camera.distortion", Severity::note, words, "", evidence});
}

/** Compares the focal lengths that the angles between surfaces ask for with the turns of the poses, which
 * share no error with them. Images whose focal length is too long turn too little, or are seen to turn right
 * by chance, so that turns confirm a doubt more easily than they refute it. */
void judgeAngles(const SurfaceAngles& angles, const PoseCheck& poses, Findings& all) {
  constexpr double kCertain = 4, kLeast = 0.02;  // standard deviations; least one of a ratio
  constexpr double kAgree = 0.05;                // largest deviation of turns that agree
  const auto doubt = std::find_if(all.begin(), all.end(),
                                  [](const Finding& finding) { return finding.id == "geometry.angles"; });
  const MotionRatio& turns = poses.turns;
  if (doubt == all.end() || turns.motions == 0 || !poses.convention.empty()) return;
  const double asked = std::sqrt(angles.fx * angles.fy), margin = kCertain * std::max(turns.std, kLeast);
  const auto allow = [&](double ratio) {
    return ratio > turns.lowest - margin && ratio < turns.highest + margin;
  };
  if (poses.isKnown() && poses.cause.empty() && turns.lowest - kCertain * turns.std > 1 - kAgree &&
      turns.highest + kCertain * turns.std < 1 + kAgree && !allow(asked)) {
    all.erase(doubt);
  } else if (allow(asked) && !allow(1)) {
    doubt->severity = Severity::refusal;
    doubt->words += fmt::format(", and the images turn {:.3f} times as much as their poses", turns.ratio);
    doubt->evidence.push_back({"turns", turns.ratio, turns.std});
  }
}

}  // namespace

Findings MapFindings::list() const {
  Findings all;
  if (geometry) all = geometry->findings;
  if (geometry && geometry->angles && poses) judgeAngles(*geometry->angles, *poses, all);
  const bool mostly = without_pose > images / 2;
  if (without_pose > 0)
    all.push_back(
        {"poses.missing",
         !mostly                     ? Severity::note
         : poses && poses->isKnown() ? Severity::doubt
                                     : Severity::refusal,
         fmt::format("{} of {} images have no pose within the tolerance of their times", without_pose,
                     images),
         mostly ? "do both clocks show the same time (--time-offset)? Is --pose-tolerance too small?" : "",
         {{"without_pose", static_cast<double>(without_pose)}, {"images", static_cast<double>(images)}}});
  if (poses) append(poses->list(), all);
  for (const PoseJump& jump : jumps) all.push_back(jump.finding());
  if (trajectory) judge(*trajectory, all);
  if (distortion) judge(*distortion, trajectory.has_value(), all);
  return all;
}

struct MapMaking::Impl {
  Impl(const Camera& camera, const MapMakingParams& the_params) : params(the_params) {
    params.validate();
    run.camera = camera;
    run.view = params.view;
  }

  bool findsTrajectory() const { return params.every == 0 && !run.images.empty() && !run.hasPoses(); }
  bool hasGivenPoses() const { return run.hasPoses() || poses_by_time; }
  int partOf(std::size_t image) const {
    const auto& found = findings.trajectory;
    if (found) return found->partOf(found->images[image]);
    if (begins.empty()) return 0;
    return part_between[std::upper_bound(begins.begin(), begins.end(), image) - begins.begin()];
  }
  void split();
  /** Pose in the world of its part. */
  std::optional<Eigen::Isometry3d> poseInPart(std::size_t image) const {
    return findings.trajectory ? findings.trajectory->images[image].T_w_c : run.images[image].T_w_c;
  }
  std::optional<Eigen::Isometry3d> pose(std::size_t image) const {
    return parts.empty() || partOf(image) == parts.front() ? poseInPart(image) : std::nullopt;
  }
  std::vector<std::size_t> calibrationImages() const;
  void keepPictures() {
    if (params.distortion) run.kept_pictures.ask(calibrationImages());
  }
  std::vector<PosedPicture> pictures();
  void calibrate();
  std::vector<Link> linksOfPoses(const std::vector<std::size_t>& images) const;
  std::vector<Link> links(const std::vector<std::size_t>& images) const {
    return findings.trajectory ? trajectoryLinks(*findings.trajectory, images) : linksOfPoses(images);
  }
  bool canBeMade();
  std::vector<int> makeModels(const std::vector<MapPlace>& places, Map& map);

  MapMakingParams params;
  ImageRun run;
  PosesByTime poses_by_time;
  MapFindings findings;
  std::vector<int> parts;           // parts of the trajectory, the largest first
  std::vector<std::size_t> begins;  // images with which given poses begin anew
  std::vector<int> part_between;    // part before the first of them, and from each on
  bool calibrated = false;          // uses the final poses
};

/** Poses that begin anew are of another world, unless they come back at once: the largest part is the map's.
 */
void MapMaking::Impl::split() {
  constexpr double kAtOnce = 1;  // [s]
  if (findings.trajectory) return;
  begins.clear();
  for (const PoseJump& jump : findings.jumps)
    if (jump.isTooFast()) begins.push_back(jump.image);
  std::sort(begins.begin(), begins.end());
  part_between = {0};
  for (std::size_t k = 0; k < begins.size(); ++k) {
    part_between.push_back(static_cast<int>(k) + 1);
    if (k == 0) continue;
    const MapImage &before = run.images[begins[k - 1] - 1], &now = run.images[begins[k]];
    const PoseJump both{begins[k], before.stamp, now.stamp, before.T_w_c->inverse() * *now.T_w_c, {}};
    if (now.stamp - before.stamp <= kAtOnce && !both.isTooFast()) part_between[k + 1] = part_between[k - 1];
  }
  std::vector<std::size_t> sizes(part_between.size());
  for (std::size_t i = 0; i < run.images.size(); ++i) sizes[partOf(i)] += run.images[i].T_w_c.has_value();
  parts.resize(sizes.size());
  std::iota(parts.begin(), parts.end(), 0);
  std::stable_sort(parts.begin(), parts.end(), [&](int a, int b) { return sizes[a] > sizes[b]; });
}

/** Images of the whole run that have a pose, or will have; the same for any number of threads. */
std::vector<std::size_t> MapMaking::Impl::calibrationImages() const {
  const bool all = findsTrajectory() && !findings.trajectory;
  std::vector<std::size_t> posed;
  for (std::size_t i = 0; i < run.images.size(); ++i)
    if (all || pose(i)) posed.push_back(i);
  std::vector<std::size_t> chosen(std::min(posed.size(), kCalibrationImages));
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = posed[i * posed.size() / chosen.size()];
  return chosen;
}

/** Those that have been read for an earlier step are kept; those that cannot be read are left out. */
std::vector<PosedPicture> MapMaking::Impl::pictures() {
  const std::vector<std::size_t> chosen = calibrationImages();
  run.kept_pictures.ask(chosen);
  run.stage(Stage::distortion, chosen.size()).run([&](std::size_t i) {
    try {
      if (run.kept_pictures.lacks(chosen[i])) run.read(chosen[i]);
    } catch (const std::exception&) {  // the image is named when it is to become a local model
    }
  });
  std::vector<PosedPicture> found;
  for (const std::size_t image : chosen)
    if (const DepthPicture* picture = run.kept_pictures.find(image))
      if (const auto T_w_c = pose(image)) found.push_back({picture, *T_w_c});
  return found;
}

void MapMaking::Impl::calibrate() {
  if (std::exchange(calibrated, true)) return;
  findings.distortion = calibrateDistortion(
      pictures(), run.camera.noise,
      {params.places.pose_rotation_std_deg * kDegree, params.places.pose_translation_std}, run.threads);
  run.camera.distortion.reset();
  if (findings.distortion && findings.distortion->reliable())
    run.camera.distortion = findings.distortion->distortion;
}

/** Links from each local model to the next, by their poses. */
std::vector<Link> MapMaking::Impl::linksOfPoses(const std::vector<std::size_t>& images) const {
  const MapBuilder rule(params.places);
  std::vector<Link> links;
  for (std::size_t i = 1; i < images.size(); ++i) {
    const auto before = poseInPart(images[i - 1]), now = poseInPart(images[i]);
    if (before && now && partOf(images[i - 1]) == partOf(images[i]))
      links.push_back(rule.link(static_cast<int>(i) - 1, static_cast<int>(i), *before, *now));
  }
  return links;
}

/** Otherwise findings have the problem. */
bool MapMaking::Impl::canBeMade() {
  if (run.images.empty())
    findings.problem = "there are no images";
  else if (findings.noneRead(run.images.size()))
    findings.problem = "no image can be read: " + findings.unread.front().cause;
  else if (const Findings found = findings.list(); !params.any_reading)
    if (const Finding* refusal = firstOf(found, Severity::refusal)) findings.problem = refusal->text();
  return findings.problem.empty();
}

std::vector<int> MapMaking::Impl::makeModels(const std::vector<MapPlace>& places, Map& map) {
  std::vector<std::size_t> images;
  for (const MapPlace& place : places) images.push_back(place.image);
  std::vector<int> made;
  findings.unread.clear();
  findings.without_segments = 0;
  run.buildViews(images, Stage::models, findings.unread, [&](std::size_t i, std::optional<View> view) {
    made.push_back(-1);
    if (!view) return;
    if (view->segments.empty()) {
      ++findings.without_segments;
      return;
    }
    view->camera.reset();  // the map's
    made.back() = static_cast<int>(map.models.size());
    map.models.push_back(LocalModel{run.images[i].name, run.images[i].stamp, pose(i), std::move(*view)});
  });
  return made;
}

MapMaking::MapMaking(const Camera& camera, const MapMakingParams& params)
    : impl_(std::make_unique<Impl>(camera, params)) {}
MapMaking::MapMaking(MapMaking&&) noexcept = default;
MapMaking& MapMaking::operator=(MapMaking&&) noexcept = default;
MapMaking::~MapMaking() = default;

void MapMaking::setNumberOfThreads(int n) { impl_->run.threads = n; }
void MapMaking::setProgress(MapProgressCallback progress) { impl_->run.progress = std::move(progress); }
void MapMaking::setPosesByTime(PosesByTime poses) { impl_->poses_by_time = std::move(poses); }
void MapMaking::setOdometry(PosesByTime odometry) { impl_->run.odometry = std::move(odometry); }
void MapMaking::add(MapImage image) { impl_->run.images.push_back(std::move(image)); }
const MapFindings& MapMaking::findings() const { return impl_->findings; }
const Camera& MapMaking::camera() const { return impl_->run.camera; }
std::optional<Eigen::Isometry3d> MapMaking::pose(std::size_t image) const { return impl_->pose(image); }

void MapMaking::findTrajectory() {
  Impl& m = *impl_;
  if (!m.findsTrajectory()) return;
  // A second trajectory is found without the distortion that the first one shows. Its poses are
  // better, which is why findDistortion() estimates the distortion once more, for the local models.
  for (const bool again : {false, true}) {
    m.keepPictures();
    CameraTrajectory found = m.run.findTrajectory(m.params.trajectory, m.findings);
    if (m.findings.noneRead(m.run.images.size())) return;
    if (!m.run.camera.mounting) m.run.level(found);  // else its world is the robot's
    m.parts = found.parts();
    m.findings.trajectory = std::move(found);
    m.calibrated = false;
    if (again || !m.params.distortion) return;
    m.calibrate();
    if (!m.run.camera.distortion) return;
  }
}

void MapMaking::checkGeometry() {
  Impl& m = *impl_;
  const std::vector<std::size_t> sample = m.run.sample();
  m.keepPictures();
  if (m.hasGivenPoses()) m.run.kept_images.ask(sample);
  std::vector<DepthImage> images(sample.size());
  m.run.stage(Stage::poses, images.size()).run([&](std::size_t i) {
    try {
      images[i] = m.run.read(sample[i]);
      dropBeyond(m.run.camera.max_depth, images[i]);
    } catch (const std::exception&) {  // the image is named when it is read for the map
    }
  });
  images.erase(
      std::remove_if(images.begin(), images.end(), [](const DepthImage& image) { return !image.valid(); }),
      images.end());
  m.findings.geometry = facetloc::checkGeometry(images, m.run.camera);
}

void MapMaking::checkPoses() {
  Impl& m = *impl_;
  if (!m.hasGivenPoses()) return;
  m.keepPictures();
  m.findings.images = m.run.images.size();
  m.findings.without_pose = static_cast<std::size_t>(std::count_if(
      m.run.images.begin(), m.run.images.end(), [](const MapImage& image) { return !image.T_w_c; }));
  m.findings.poses =
      internal::checkPoses(m.run.seenMotions(), m.poses_by_time ? m.poses_by_time : posesOf(m.run.images));
  m.findings.jumps = m.run.poseJumps(*m.findings.poses);
  m.run.kept_images.ask({});
  m.split();
}

std::vector<MapPlace> MapMaking::places() const {
  const Impl& m = *impl_;
  std::vector<MapPlace> places;
  std::map<int, MapBuilder> rules;  // rules of each part
  for (std::size_t i = 0; i < m.run.images.size(); ++i) {
    const auto by_rule = m.poseInPart(i);
    MapBuilder& rule = rules.try_emplace(m.partOf(i), m.params.places).first->second;
    if (m.params.every > 0 ? i % static_cast<std::size_t>(m.params.every) == 0
                           : by_rule && rule.accept(*by_rule))
      places.push_back({i, m.pose(i)});
  }
  return places;
}

void MapMaking::findDistortion() { impl_->calibrate(); }

void MapMaking::setDistortion(const std::optional<DepthDistortion>& distortion) {
  impl_->run.camera.distortion = distortion;
}

std::vector<Link> MapMaking::links(const std::vector<std::size_t>& images) const {
  const Impl& m = *impl_;
  for (const std::size_t image : images)
    if (image >= m.run.images.size())
      throw std::invalid_argument(fmt::format("links: there is no image {}", image));
  return m.links(images);
}

Map MapMaking::finish() {
  Impl& m = *impl_;
  m.findings.problem.clear();
  checkGeometry();
  if (!m.canBeMade()) return {};
  findTrajectory();
  checkPoses();
  if (!m.canBeMade()) return {};
  auto map = std::make_shared<Map>();
  map->camera = m.run.camera;
  MapInMemory sink(map);
  if (!finish(sink, [&](const std::vector<MapPlace>& places) { return m.makeModels(places, *map); }))
    return {};
  return std::move(*map);
}

bool MapMaking::finish(MapSink& sink, const ModelMaker& make) {
  Impl& m = *impl_;
  std::set<std::pair<int, int>> linked;
  {
    const std::shared_ptr<const Map> present = sink.map();
    for (const Link& link : present->links) linked.emplace(link.from, link.to);
    if (!present->models.empty()) {
      setDistortion(present->camera.distortion);
    } else {
      if (m.params.distortion) findDistortion();
      if (m.run.camera.distortion || present->camera.distortion) sink.setCamera(m.run.camera);
    }
    m.run.kept_pictures.ask({});
  }
  if (const auto& found = m.findings.trajectory) sink.setMeta(kTrajectoryKey, found->overlaps.toString());

  const std::vector<MapPlace> places = this->places();
  const std::vector<int> made = make(places);
  std::vector<std::size_t> images;
  std::vector<int> models;
  for (std::size_t i = 0; i < made.size(); ++i)
    if (made[i] >= 0) images.push_back(places[i].image), models.push_back(made[i]);
  if (images.empty()) {
    m.findings.problem = "none of the images makes a local model";
    return false;
  }
  for (Link link : m.links(images)) {
    link.from = models[link.from], link.to = models[link.to];
    if (linked.emplace(link.from, link.to).second) sink.add(link);
  }
  sink.setWhole();
  m.findings.mounting = completeMap(sink, {true, m.run.threads, m.run.progress});
  return true;
}

}  // namespace facetloc

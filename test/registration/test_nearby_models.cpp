// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/hypothesis_ranking.h"
#include "nearby/nearby_models.h"

#include <facetloc/registration/registration_params.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace facetloc {

using namespace internal;
namespace {

// Cameras all over a building, many of them in the same places; some with an unknown pose.
std::shared_ptr<const Map> building() {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> place(-15, 15), turn(-3, 3);
  auto map = std::make_shared<Map>();
  for (int i = 0; i < 400; ++i) {
    LocalModel m;
    if (i % 9 > 0) {
      m.T_w_m = Eigen::Isometry3d::Identity();
      m.T_w_m->linear() = Eigen::AngleAxisd(turn(engine), Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                          Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitX());
      m.T_w_m->translation() << std::round(place(engine)), place(engine), 1;
    }
    m.part = i % 4 == 0 ? 3 : 0;
    View view;
    if (i % 5 > 0) view.depth.camera = {160, 120, 130, 130, 80, 60};
    m.setView(view);
    map->models.push_back(m);
  }
  return map;
}

std::vector<int> sorted(std::vector<std::pair<double, int>> found, int n) {
  std::sort(found.begin(), found.end());
  std::vector<int> models;
  for (const auto& [distance, i] : found)
    if (static_cast<int>(models.size()) < n) models.push_back(i);
  return models;
}

TEST(NearbyModels, AreThoseOfBruteForce) {
  const std::shared_ptr<const Map> map = building();
  for (const bool with_picture : {false, true}) {
    const NearbyModels near(map, with_picture);
    EXPECT_FALSE(near.empty());
    const auto isOne = [&](const LocalModel& m) { return m.T_w_m && (m.hasPicture() || !with_picture); };
    for (std::size_t k = 1; k < map->models.size(); k += 3) {
      if (!map->models[k].T_w_m) continue;
      const Eigen::Isometry3d& T = *map->models[k].T_w_m;
      for (const ViewReach reach : {ViewReach{2.5, 0.9}, ViewReach{4, 1.05}, ViewReach{100, 4}}) {
        std::vector<std::pair<double, int>> by_sight, by_place;
        for (std::size_t i = 0; i < map->models.size(); ++i) {
          if (!isOne(map->models[i]) || map->models[i].part != map->models[k].part) continue;
          const double distance = viewDistance(*map->models[i].T_w_m, T, reach);
          if (std::isfinite(distance)) by_sight.emplace_back(distance, static_cast<int>(i));
          by_place.emplace_back((map->models[i].T_w_m->translation() - T.translation()).squaredNorm(),
                                static_cast<int>(i));
        }
        for (const int n : {0, 1, 5, 1000}) {
          EXPECT_EQ(near.bySight(map->models[k].part, T, reach, n), sorted(by_sight, n));
          EXPECT_EQ(near.byPlace(map->models[k].part, T.translation(), n), sorted(by_place, n));
        }
      }
    }
  }
}

TEST(NearbyModels, OfAnEmptyMapAreEmpty) {
  const NearbyModels none(std::make_shared<Map>());
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(none.byPlace(0, {0, 0, 0}, 5).empty());
  EXPECT_TRUE(none.bySight(0, Eigen::Isometry3d::Identity(), kTrackingReach, 5).empty());
  const NearbyModels near(building());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(near.byPlace(0, {nan, 0, 0}, 5).empty());
  EXPECT_TRUE(near.byPlace(1, {0, 0, 0}, 5).empty()) << "no such part";
  EXPECT_EQ(near.byPlace(0, {5000, 0, 0}, 5).size(), 5u);
  const Eigen::Isometry3d nowhere(Eigen::Translation3d(nan, 0, 0));
  EXPECT_TRUE(near.bySight(0, nowhere, kTrackingReach, 5).empty());
}

using testing::HasSubstr;

/** Standard deviations of one rotation and one translation; the others are small. */
Matrix6d covariance(double rotation_deg, double translation) {
  Vector6d std;
  std << rotation_deg * kDegree, 1e-3, 1e-3, translation, 1e-3, 1e-3;
  return std.cwiseAbs2().asDiagonal();
}

Localization answerWith(double probability, const Matrix6d& P) {
  Localization answer;
  answer.hypotheses.resize(1);
  answer.hypotheses[0].probability = probability, answer.hypotheses[0].T_m_c.P = P;
  internal::concludePose({}, answer);
  return answer;
}

TEST(PoseLimits, AreTwoStandardDeviations) {
  const PoseLimits limits;
  EXPECT_TRUE(limits.hold(covariance(2.49, 0.149)));
  EXPECT_FALSE(limits.hold(covariance(2.51, 0.149)));
  EXPECT_FALSE(limits.hold(covariance(2.49, 0.151)));
}

TEST(PoseLimits, NameTheMotionThatIsOpen) {
  const PoseLimits limits;
  EXPECT_EQ(limits.whyNotFixed(covariance(1, 1), Eigen::Matrix3d::Identity()),
            "nothing in view fixes translation along (1.00, 0.00, 0.00)");
  EXPECT_THAT(limits.whyNotFixed(covariance(20, 0.1), Eigen::Matrix3d::Identity()),
              HasSubstr("rotation about (1.00, 0.00, 0.00)"));
}

/** The uncertainty of the prior is no pose that one may act on, however probable its place. */
TEST(PoseLimits, BoundWhatIsSure) {
  const Localization fixed = answerWith(0.99, covariance(1, 0.05)),
                     open = answerWith(0.99, covariance(20, 1)),
                     improbable = answerWith(0.6, covariance(1, 0.05));
  EXPECT_EQ(fixed.state, AnswerState::sure);
  EXPECT_TRUE(fixed.reason.empty());
  EXPECT_EQ(open.state, AnswerState::doubtful);
  EXPECT_THAT(open.reason, HasSubstr("nothing in view fixes"));
  EXPECT_EQ(improbable.state, AnswerState::doubtful);
}

}  // namespace
}  // namespace facetloc

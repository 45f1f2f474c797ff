// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/localization/sure_calibration.h>
#include <facetloc/mapping/densified_map.h>
#include <facetloc/mapping/map_session.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>

namespace facetloc {
namespace {

using test::lookingAlong;

/** A drive across the large room and back along another line, which never looks at right angles to it. */
Map drivenMap() {
  Map map;
  const auto add = [&](const Eigen::Vector3d& place, const Eigen::Vector3d& direction) {
    const auto number = static_cast<unsigned>(map.models.size());
    const Eigen::Isometry3d T = lookingAlong(place, direction);
    View view = test::viewFrom(test::largeRoom(), T, 100 + number);
    view.camera.reset();
    map.models.emplace_back("image" + std::to_string(number), number, T, std::move(view));
  };
  for (const double x : {1.2, 1.8, 2.4, 3.0, 3.6}) add({x, 1.8, 1.2}, {1, 0.1, -0.3});
  for (const double x : {4.6, 4.0, 3.4, 2.8, 2.2}) add({x, 2.6, 1.2}, {-1, 0.1, -0.3});
  map.meta["source"] = "a room";
  return map;
}

DensifyParams few() {
  DensifyParams params;
  params.reach = 0.7, params.rotation_deg = 30;
  return params;
}

std::size_t renderedIn(const Map& map) {
  const std::vector<char> rendered = renderedViews(map);
  return static_cast<std::size_t>(std::count(rendered.begin(), rendered.end(), 1));
}

TEST(DensifiedMap, ShowsTheRoomAsItIs) {
  Map map = drivenMap();
  const std::size_t driven = map.models.size();
  map.meta[kSureKey] = "x";
  map.ambiguity = MapAmbiguity{3, 10};
  const Densification done = densify(map, few());
  EXPECT_EQ(done.driven, driven);
  EXPECT_EQ(done.removed, 0u);
  ASSERT_GE(done.rendered, 4u);
  ASSERT_EQ(map.models.size(), driven + done.rendered);
  EXPECT_EQ(renderedIn(map), done.rendered);
  EXPECT_FALSE(map.ambiguity) << "the map must be asked again";
  EXPECT_EQ(map.meta.count(kSureKey), 0u);
  EXPECT_EQ(map.meta.at("source"), "a room");
  const Eigen::AlignedBox3d room(Eigen::Vector3d::Zero(), Eigen::Vector3d(6, 5, 2.5));
  std::size_t known = 0, off = 0;
  for (std::size_t i = driven; i < map.models.size(); ++i) {
    const LocalModel& model = map.models[i];
    EXPECT_TRUE(room.contains(model.T_w_m->translation()));
    const View& view = *map.view(static_cast<int>(i));
    EXPECT_FALSE(view.segments.empty());
    const auto truth =
        DepthPicture::fromDepth(test::render(test::largeRoom(), view.intrinsics, *model.T_w_m).image);
    for (std::size_t k = 0; k < truth.inverse_depth.size(); ++k) {
      if (view.depth.inverse_depth[k] == 0) continue;
      ++known;
      const double apart = std::abs(view.depth.inverse_depth[k] - double(truth.inverse_depth[k]));
      off += DepthPicture::kQuantum * apart > 4 * view.noise();
    }
  }
  EXPECT_LT(static_cast<double>(off), 0.05 * static_cast<double>(known));
}

TEST(DensifiedMap, RenderedViewsStandApartFromEachOtherAndNearTheDrive) {
  Map map = drivenMap();
  const DensifyParams params = few();
  densify(map, params);
  const std::vector<char> rendered = renderedViews(map);
  std::set<std::string> names;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    EXPECT_TRUE(names.insert(map.models[i].name).second);
    if (!rendered[i]) continue;
    double nearest = 1e9;
    for (std::size_t k = 0; k < map.models.size(); ++k) {
      if (k == i) continue;
      EXPECT_FALSE(isNear(*map.models[i].T_w_m, *map.models[k].T_w_m, params.spacing, params.rotation_deg));
      if (rendered[k]) continue;
      nearest =
          std::min(nearest, (map.models[i].T_w_m->translation() - map.models[k].T_w_m->translation()).norm());
    }
    EXPECT_LE(nearest, params.reach + 1e-9);
    const auto link = std::find_if(map.links.begin(), map.links.end(),
                                   [&](const Link& l) { return l.to == static_cast<int>(i); });
    ASSERT_NE(link, map.links.end());
    EXPECT_TRUE((*map.models[link->from].T_w_m * link->T_from_to.T).isApprox(*map.models[i].T_w_m, 1e-9));
  }
}

/** Images that look 75 deg past any image of the drive, at walls that it has seen from elsewhere. */
TEST(DensifiedMap, FindsImagesInDirectionsThatNoImageHas) {
  const auto before = std::make_shared<const Map>(drivenMap());
  Map dense = *before;
  densify(dense);
  const internal::GlobalLocalization in_drive(before),
      in_dense(std::make_shared<const Map>(std::move(dense)));
  int found = 0, found_before = 0, sure_and_wrong = 0;
  const double angle = 110 * kDegree;
  for (const double x : {2.0, 2.1, 2.2, 2.3, 2.4, 2.5, 2.6}) {
    const Eigen::Isometry3d T = lookingAlong({x, 2.2, 1.2}, {std::cos(angle), std::sin(angle), -0.3});
    const View view = test::viewFrom(test::largeRoom(), T, static_cast<unsigned>(100 * x));
    const auto isFound = [&](const Localization& answer) {
      return !answer.hypotheses.empty() && isNear(*answer.hypotheses.front().T_w_c, T, 0.2, 2);
    };
    const Localization answer = in_dense.localize(view);
    found += isFound(answer);
    sure_and_wrong += !isFound(answer) && answer.state == AnswerState::sure;
    found_before += isFound(in_drive.localize(view));
  }
  EXPECT_GE(found, 5);
  EXPECT_GE(found, found_before + 3);
  EXPECT_EQ(sure_and_wrong, 0);
}

TEST(DensifiedMap, AgainAndWithMoreThreadsIsTheSame) {
  Map once = drivenMap();
  densify(once, few());
  Map twice = once;
  const Densification again = densify(twice, few(), {}, 2);
  EXPECT_EQ(again.removed, again.rendered);
  ASSERT_EQ(once.models.size(), twice.models.size());
  EXPECT_EQ(once.links.size(), twice.links.size());
  EXPECT_EQ(once.meta, twice.meta);
  for (std::size_t i = 0; i < once.models.size(); ++i) {
    EXPECT_EQ(once.models[i].name, twice.models[i].name);
    EXPECT_TRUE(once.models[i].T_w_m->isApprox(*twice.models[i].T_w_m, 0));
    const auto a = once.view(static_cast<int>(i)), b = twice.view(static_cast<int>(i));
    EXPECT_EQ(a->depth.inverse_depth, b->depth.inverse_depth);
    ASSERT_EQ(a->segments.size(), b->segments.size());
  }
}

TEST(DensifiedMap, WithoutKnownSpaceStaysAsItIs) {
  Map empty;
  EXPECT_EQ(densify(empty).rendered, 0u);
  Map unposed = drivenMap();
  for (LocalModel& model : unposed.models) model.T_w_m.reset();
  const std::size_t models = unposed.models.size();
  EXPECT_EQ(densify(unposed).driven, 0u);
  EXPECT_EQ(unposed.models.size(), models);
  DensifyParams wrong;
  wrong.rotation_deg = 0;
  EXPECT_THROW(densify(unposed, wrong), std::invalid_argument);
}

TEST(DensifiedMap, RefusesPosesThatNoSurfaceHas) {
  Map far = drivenMap();
  far.models.back().T_w_m->translation() = Eigen::Vector3d(1e8, 1e8, 0);
  EXPECT_THROW(densify(far), std::invalid_argument);
  far.models.back().T_w_m->translation() = Eigen::Vector3d(1e300, -1e300, 1e300);
  EXPECT_THROW(densify(far), std::invalid_argument);
}

/** Names in the meta data of a file are only names. */
TEST(DensifiedMap, StrangeNamesInTheMapMarkNothing) {
  Map map = drivenMap();
  map.meta[kRenderedKey] = "\n\nnobody\nimage3 \n";
  EXPECT_EQ(renderedIn(map), 0u);
  map.meta[kRenderedKey] = "image3\n";
  EXPECT_EQ(renderedIn(map), 1u);
}

TEST(DensifiedMap, MergedMapsKnowTheirRenderedViews) {
  Map a = drivenMap();
  const std::size_t rendered = densify(a, few()).rendered;
  const Map b = a, merged = mergedMap({a, b}, {"a", "b"});
  EXPECT_EQ(renderedIn(merged), 2 * rendered);
}

/** A rendered view shows the surfaces of the image that is localized: it would confirm it. */
TEST(DensifiedMap, OwnViewsAreAskedWithoutRenderedOnes) {
  const Map driven = drivenMap();
  Map dense = driven;
  densify(dense, few());
  SureCalibration of_driven(0.3, 0.5), of_dense(0.3, 0.5);
  addOwnViews(std::make_shared<const Map>(driven), of_driven);
  addOwnViews(std::make_shared<const Map>(dense), of_dense);
  EXPECT_EQ(of_driven.images(), of_dense.images());
}

}  // namespace
}  // namespace facetloc

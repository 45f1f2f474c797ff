// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "../io/temporary_folder.h"

#include <facetloc/io/map_database.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

namespace facetloc::test {

/** \brief The map as openMap() finds it in its file, with no view in memory but the latest. Local models
 * without a name get one. */
inline std::shared_ptr<Map> openedMap(Map map) {
  struct Opened {
    TemporaryFolder folder;
    Map map;
  };
  for (std::size_t i = 0; i < map.models.size(); ++i)
    if (map.models[i].name.empty()) map.models[i].name = std::to_string(i);
  const auto opened = std::make_shared<Opened>();
  writeMap(opened->folder / "map.flmap", map);
  opened->map = openMap(opened->folder / "map.flmap", 0);
  return {opened, &opened->map};
}

/** \brief The large room, by 18 images all around its middle. */
inline std::shared_ptr<Map> roomMap() {
  auto map = std::make_shared<Map>();
  for (int i = 0; i < 18; ++i) {
    const Eigen::Isometry3d T_w_m = onCircle(20 * i, 0.35);
    map->models.emplace_back("", 0, T_w_m, viewFrom(largeRoom(), T_w_m, 1000 + i));
  }
  return map;
}

/** \brief Two answers to the last bit. */
inline void expectSame(const Localization& a, const Localization& b) {
  EXPECT_EQ(a.reason, b.reason);
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (std::size_t i = 0; i < a.hypotheses.size(); ++i) {
    const Hypothesis &x = a.hypotheses[i], &y = b.hypotheses[i];
    EXPECT_EQ(x.model, y.model);
    EXPECT_EQ(x.probability, y.probability);
    EXPECT_EQ(x.T_m_c.T.matrix(), y.T_m_c.T.matrix());
    EXPECT_EQ(x.T_m_c.P, y.T_m_c.P);
  }
}

/** \brief The same map with all its views in memory. */
inline std::shared_ptr<Map> inMemory(const Map& map) {
  auto copy = std::make_shared<Map>(map);
  for (std::size_t i = 0; i < copy->models.size(); ++i)
    copy->models[i].setView(map.view(static_cast<int>(i)));
  return copy;
}

}  // namespace facetloc::test

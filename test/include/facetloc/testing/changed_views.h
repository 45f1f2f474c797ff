// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <cstddef>
#include <utility>

namespace facetloc::test {

/** \brief Replaces the view of local model number i by a changed copy. */
template <class Change>
void changeView(Map& map, int i, const Change& change) {
  View view = *map.view(i);
  change(view);
  map.models[static_cast<std::size_t>(i)].setView(std::move(view));
}

/** \brief The same for all local models. */
template <class Change>
void changeViews(Map& map, const Change& change) {
  for (int i = 0; i < static_cast<int>(map.models.size()); ++i) changeView(map, i, change);
}

}  // namespace facetloc::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"

#include <facetloc/features/local_model.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief "model 3 ('name')" */
std::string nameOf(int model, const std::string& name);

/** \brief Has a map file the table of gravity? */
bool hasGravity(sqlite::Connection& db);

/** \brief Reads a map, with or without its views, and places it by its links. Throws IoError unless it is
 * sound.
 */
Map readSound(sqlite::Connection& db, bool with_views);
/** \brief Adds the faults of all rows and of the place index, which are looked at, and none kept. */
void findFaults(sqlite::Connection& db, std::vector<std::string>& faults);

}  // namespace facetloc

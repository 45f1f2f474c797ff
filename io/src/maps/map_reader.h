// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"

#include <facetloc/features/local_model.h>

#include <functional>
#include <istream>
#include <memory>
#include <mutex>
#include <ostream>
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

/** The place index in a map file, as a stream of bytes in checksummed parts. */
namespace place_index_parts {

/** \brief Replaces the former index, within a transaction of the caller. */
void write(sqlite::Connection& db, const std::function<void(std::ostream&)>& writer);
void remove(sqlite::Connection& db);
/** \brief 0 if there is no index. */
int number(sqlite::Connection& db);
/** \brief Null if the map has none. A part that differs from the one written throws IoError when it is
 * reached. \param mutex is locked while the database, which must outlive the stream, is read */
std::unique_ptr<std::istream> open(sqlite::Connection& db, std::mutex& mutex);
/** \brief Its faults, in words. */
std::vector<std::string> faults(sqlite::Connection& db);

}  // namespace place_index_parts
}  // namespace facetloc

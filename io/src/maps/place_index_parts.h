// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"

#include <functional>
#include <istream>
#include <memory>
#include <mutex>
#include <ostream>
#include <string>
#include <vector>

/** \file
 * The place index in a map file, as a stream of bytes in checksummed parts; private to io. */

namespace facetloc::place_index_parts {

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

}  // namespace facetloc::place_index_parts

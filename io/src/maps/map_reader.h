// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"
#include "maps/map_rows.h"

#include <facetloc/features/local_model.h>

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/** \file
 * Reading of map files, private to io. */

namespace facetloc {

/** \brief "model 3 ('name')" */
std::string nameOf(int model, const std::string& name);

/** \brief Has a map file the table of gravity? */
bool hasGravity(sqlite::Connection& db);

/** \brief Reads a map, skips invalid rows and lists them in faults(). For one reading each: reads one
 * snapshot; writers wait until it is destroyed. */
class MapReader {
public:
  explicit MapReader(sqlite::Connection& db) : db_(db), snapshot_(db) {}

  /** \brief All of it. */
  Map read();
  /** \brief Looks at all of it and keeps no depth picture, so that a large map takes little memory. */
  void check();
  /** \brief All but the views, of which only sizes are looked at. */
  Map readWithoutViews();

  const std::vector<std::string>& faults() const { return faults_; }
  /** \brief Throws IoError with the first fault, if there is one. */
  void requireSound() const;

private:
  enum class Views { keep, look_at, leave };
  void readAll(Views views);
  template <typename Function>
  void forEachRow(const char* columns, const char* table, const char* order, const char* label,
                  const Function& function);
  std::size_t modelOf(int id, std::string& label) const;
  void readMeta();
  void readCamera();
  void readAmbiguity();
  void readModels();
  void readSegments();
  void readGravity();
  void requireMemoryForPictures();
  void readPictures(Views views);
  void readLinks();

  sqlite::Connection& db_;
  sqlite::Snapshot snapshot_;
  Map map_;
  std::vector<View> views_;  // views of the models
  std::vector<int> num_segments_;
  std::set<std::pair<int, int>> linked_;
  std::vector<std::string> faults_;
};

/** \brief Reads a map, with or without its views, and places it by its links. Throws IoError unless it is
 * sound.
 */
Map readSound(sqlite::Connection& db, bool with_views);

}  // namespace facetloc

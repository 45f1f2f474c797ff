// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_making.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief A map file while it is made. All functions throw IoError. */
class MapFile : public MapSink {
public:
  MapFile(std::filesystem::path path, MapDatabase database, const Console& console)
      : path_(std::move(path)), database_(std::move(database)), console_(console) {}

  std::shared_ptr<Map> map() override;
  std::vector<std::string> modelNames() const { return database_.modelNames(); }
  /** \brief Adds a local model; until setWhole(), the map is under way then. \return its index */
  int add(const PackedModel& model);
  void add(const Link& link) override { database_.add(link); }
  void setCamera(const Camera& camera) override { database_.setCamera(camera); }
  void setMeta(const std::string& key, const std::string& value) override { database_.setMeta(key, value); }
  void setWhole() override;
  /** \brief Says so on console.out. */
  void setMounting(const Camera& camera, const FoundMounting& found) override;
  /** \brief Keeps the index of a large map whose camera has a mounting. */
  void setPlaceIndex(const Map& map) override;
  void setAmbiguity(const MapAmbiguity& ambiguity,
                    const std::vector<std::optional<double>>& alias_scores) override {
    database_.setAmbiguity(ambiguity, alias_scores);
  }

private:
  std::filesystem::path path_;
  MapDatabase database_;
  const Console& console_;
  bool whole_ = false;
};

/** \brief Adds the missing parts of a map file: the place index of a large map, and its ambiguity.
 * \param threads 0 = all cores. \param mounting find an unknown mounting of its camera by the floor. Throws
 * IoError, and Stopped at Ctrl-C. */
void completeMap(const std::filesystem::path& map, int threads, const Console& console,
                 bool mounting = false);

/** \brief Makes and writes a map that was not there, with all that it is asked for when it is opened. Throws
 * UsageError without a path, IoError. \param make is called once it is clear that the map can be written */
Map writeNewMap(const std::string& path, bool overwrite, int threads, const Console& console,
                const std::function<Map()>& make);

/** \brief The locked file of a map that is changed: an output of that name, or else the map itself. Throws
 * UsageError to overwrite no output, IoError without the map, or if the output may not be replaced. */
std::pair<std::string, OutputLock> lockSuccessor(const std::string& map, const std::string& output,
                                                 bool overwrite);

/** \brief Writes a map in the place of one that was there, which stays as it was until the new one is
 * complete. Throws IoError, and Stopped at Ctrl-C. */
void replaceWholeMap(const std::filesystem::path& path, const Map& map, int threads, const Console& console);

/** \brief The faults of the place index in a map file, in words; empty if it is sound or missing. */
std::vector<std::string> placeIndexFaults(const std::filesystem::path& map);

/** \brief Inputs of a map file that is built, so that only the same build goes on with it. */
struct MapInputs {
  std::string map;        ///< the file, in messages
  std::string recording;  ///< its path
  const DepthSequence& sequence;
  const std::vector<MapPlace>& places;
  std::string parameters;
  std::string disagreement;  ///< poses against images, in words; empty if unknown
};

/** \brief False for an empty file, too, which holds nothing that could be lost. */
bool isThere(const std::filesystem::path& path);

/** \brief Begins a map file, or goes on with one that the same build has begun; a file without local models
 * is begun again. Throws IoError if it may not be replaced, or its local models are of other inputs. */
MapDatabase openBuild(const std::filesystem::path& path, const MapInputs& inputs, const Camera& camera,
                      bool resume, bool overwrite);

}  // namespace facetloc

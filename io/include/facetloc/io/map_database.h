// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A local model whose depth picture is packed as a map file holds it. Packing loses nothing, takes
 * longer than everything else about adding a model, and any thread can do it. The picture is to have the size
 * that its camera says. */
struct PackedModel {
  LocalModel model;
  View view;                        ///< its depth has the camera and the noise alone
  std::vector<std::uint8_t> depth;  ///< empty if there is no depth picture
};
PackedModel packed(LocalModel model, View view);

/** \brief A map file (*.flmap): one SQLite database. All functions throw IoError with file and
 * cause.
 *
 * Writing: one transaction per local model, so that a process killed at any time leaves a sound map of the
 * models added so far. Reading: read-only, columns by name, everything checked; a newer major format is
 * refused. */
class MapDatabase {
public:
  static constexpr int kApplicationId = 0x464C4D50;  ///< "FLMP"
  static constexpr int kMajor = 1;
  static constexpr int kMinor = 0;

  /** \brief Creates a new, empty map; refuses an existing file unless overwrite is set. */
  static MapDatabase create(const std::filesystem::path& path, bool overwrite = false);
  /** \brief Opens an existing map for reading and appending. */
  static MapDatabase open(const std::filesystem::path& path);
  MapDatabase(MapDatabase&&) noexcept;
  MapDatabase& operator=(MapDatabase&&) noexcept;
  ~MapDatabase();

  void setMeta(const std::string& key, const std::string& value);
  /** \brief All properties of the camera of the map's images; replaces the former ones. */
  void setCamera(const Camera& camera);
  /** \brief It is lost when a model is added. \param alias_scores of the local models, by index; none, or
   * as many as there are models, else throws std::invalid_argument */
  void setAmbiguity(const MapAmbiguity& ambiguity,
                    const std::vector<std::optional<double>>& alias_scores = {});
  /** \brief Keeps the output of PlaceIndex::write(), so that it need not be made when the map is opened. It
   * is lost when a model is added. */
  void setPlaceIndex(const std::function<void(std::ostream&)>& write);
  /** \brief Adds a local model with its segments, depth picture and given pose in one transaction; returns
   * its index. */
  int add(const LocalModel& model, const View& view);
  int add(const PackedModel& model);
  /** \brief Adds a link between two models that are already there. */
  void add(const Link& link);
  /** \brief Replaces all poses and all links, in one transaction, while a map is still moving. The former
   * ones are gone, and so are ambiguity and place index. \param T_w_m of each model, by index; nothing where
   * it is unknown. Throws std::invalid_argument if there are not as many as models. */
  void setPoses(const std::vector<std::optional<Eigen::Isometry3d>>& T_w_m, const std::vector<Link>& links);
  /** \brief The names of the models so far, by index; lets a build resume. */
  std::vector<std::string> modelNames() const;

private:
  struct Impl;
  explicit MapDatabase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/** \brief Reads a whole map through a read-only connection. The models are in the order of their index; those
 * without a pose get one by links (placeByLinks()). */
Map readMap(const std::filesystem::path& path);
/** \brief Opens a map to localize in it; models without a pose are placed by its links. A map of more local
 * models than that keeps their views in its file (Map::store), which stays open, and in memory only those
 * that were asked for last: 0.12 MB each. A fault in such a view throws IoError when it is asked for. */
Map openMap(const std::filesystem::path& path, std::size_t views_in_memory = 400);
/** \brief Writes a map beside path and renames it in the end: until then, a map that is at path is left as it
 * is. \param write creates it at the path that it gets, and closes it. */
void replaceMap(const std::filesystem::path& path,
                const std::function<void(const std::filesystem::path& temporary)>& write);
/** \brief Writes a whole map, atomically; of the poses those that were given.
 * \param place_index if not empty, writes the index for MapDatabase::setPlaceIndex() */
void writeMap(const std::filesystem::path& path, const Map& map,
              const std::function<void(std::ostream&)>& place_index = {});
/** \brief Every fault found in a map file, in words; empty for a sound one. Throws only if the file cannot be
 * opened as a map at all. */
std::vector<std::string> checkMap(const std::filesystem::path& path);

/** \brief Writes VERTEX_SE3:QUAT with the model's index as id, and EDGE_SE3:QUAT for each link.
 *
 * A comment says of which vertices the pose follows from links, in the frame of which part (its index), or is
 * unknown, and then the identity. The information of an edge is about g2o's error, the translation and the
 * quaternion's vector part (half the rotation vector) of the measured inverse times the true relative pose,
 * which lives in the frame of `to`; order (t, R). Throws IoError. */
void writeGraph(const std::filesystem::path& path, const Map& map);

/** \brief Gives the local models in the world the poses that the vertices of a g2o file have, as given ones;
 * those of other parts of the map are left where they are, since their poses in the world are unknown. All
 * other lines of the file are ignored. Throws IoError if a vertex is no local model or has an invalid pose,
 * if a local model in the world has no vertex or two, and if nothing of the map is in a world. */
void readGraphPoses(const std::filesystem::path& path, Map& map);

/** \brief Writes a map for other programs, into a folder that is made if need be:
 *
 * - models/NAME.pcd: SegmentFrame clouds in the model's frame; none for a model without segments.
 * Characters that are not at home in file names become _.
 * - poses_tum.txt: the models whose pose was given, by their stamps.
 * - graph.g2o: the models and their links (writeGraph()).
 *
 * Throws IoError. */
void exportMap(const Map& map, const std::filesystem::path& folder);

}  // namespace facetloc

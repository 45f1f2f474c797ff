// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/gravity.h>
#include <facetloc/io/trajectory.h>

#include <filesystem>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief Gravity at a time [s], in the optical frame of the camera. */
struct StampedGravity {
  double stamp = 0;
  Gravity gravity;
};

/** \brief Directions of gravity sorted by time. */
class GravityRecord {
public:
  GravityRecord() = default;
  explicit GravityRecord(std::vector<StampedGravity> samples);
  const std::vector<StampedGravity>& samples() const { return samples_; }
  bool empty() const { return samples_.empty(); }
  /** \brief Gravity at a time: between two samples that are at most five tolerances apart, or else of the
   * sample nearest in time, if it lies within the tolerance [s]. */
  std::optional<Gravity> at(double stamp, double tolerance = 0.02) const;

private:
  std::vector<StampedGravity> samples_;
};

/** \brief Reads directions of gravity: lines `stamp gx gy gz`, or with a line of names any columns among
 * which are a stamp and gx gy gz (also gravity_x ...), separated by blanks, commas or semicolons; # starts a
 * comment. Gravity points downwards, in the optical frame of the camera (x right, y down, z forward), and may
 * have any length: of g, m/s^2 or 1. Stamps in milliseconds, microseconds or nanoseconds are known by the
 * names or by their size. A column std_deg has the standard deviation of each line.
 * Throws IoError with the line. \param std of lines that do not say it [rad] */
GravityRecord readGravity(const std::filesystem::path& path, double std);

/** \brief Does a file hold directions of gravity, rather than poses? By its first line. Throws IoError. */
bool holdsGravity(const std::filesystem::path& path);

/** \brief Gravity of poses whose world is aligned with it, as the worlds of phones are. \param up_w upwards,
 * unit vector \param std [rad] */
GravityRecord gravityOf(const Trajectory& poses, const Eigen::Vector3d& up_w, double std);

/** \brief Writes lines `stamp gx gy gz` of unit vectors. */
void writeGravity(const std::filesystem::path& path, const std::vector<StampedGravity>& samples);

}  // namespace facetloc

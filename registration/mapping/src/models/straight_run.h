// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace facetloc::internal {

/** \brief A line in the plane. */
struct FittedLine {
  Eigen::Vector2d through, along;  ///< a point of it, and its direction, of unit length

  Eigen::Vector2d nearest(const Eigen::Vector2d& p) const { return through + along.dot(p - through) * along; }
};

/** \brief Total least squares of runs of points, each in constant time. */
class LineFits {
public:
  /** \param points the middles of the edges of cells along an outline [cells], which must outlive it */
  explicit LineFits(const std::vector<Eigen::Vector2d>& points);

  /** \brief Sum of the squared distances of points [begin, end) from their line. */
  double squares(std::size_t begin, std::size_t end) const;
  /** \brief The line; of a single point, along the edge whose middle it is. */
  FittedLine line(std::size_t begin, std::size_t end) const;

private:
  struct Sums {
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    double xx = 0, xy = 0, yy = 0;
  };
  struct Moments {
    Eigen::Vector2d mean;
    double xx, xy, yy;
  };
  Moments momentsOf(std::size_t begin, std::size_t end) const;

  const std::vector<Eigen::Vector2d>& points_;
  std::vector<Sums> sums_;  // sums over all points before
};

/** \brief End of the longest run of points from begin on that one line passes within half a cell: measured
 * along y if the line is more along x, along x else. */
std::size_t endOfStraightRun(const std::vector<Eigen::Vector2d>& points, std::size_t begin);

}  // namespace facetloc::internal

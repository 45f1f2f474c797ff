// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/map_database.h>
#include <facetloc/mapping/growing_map.h>

#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Where the camera has been, as lines that may be drawn for hours: no more points than needed, and
 * coarser ones the longer it gets. */
class LiveTrajectory {
public:
  using Line = std::vector<Eigen::Vector3d>;

  /** \brief The camera is here now [m]. A new line begins after an interruption, and where it jumps; all
   * begins anew in another part of the map, whose frame has nothing to do with the one before. */
  void add(const Eigen::Vector3d& position, int part = 0) {
    if (part != part_) {
      *this = LiveTrajectory();
      part_ = part;
    }
    const bool jump = !lines_.empty() && (position - lines_.back().back()).norm() > kJump + spacing_;
    if (interrupted_ || jump) {
      lines_.push_back({position});
      interrupted_ = false;
    } else if ((position - lines_.back().back()).norm() >= spacing_) {
      lines_.back().push_back(position);
    } else {
      return;
    }
    if (++points_ > kMostPoints) thin();
  }

  /** \brief Interrupts the line: the place of the camera is unknown. */
  void interrupt() { interrupted_ = true; }

  const std::vector<Line>& lines() const { return lines_; }

private:
  static constexpr double kJump = 1.0;  // [m] that no camera moves between two frames
  static constexpr std::size_t kMostPoints = 2000;

  /** Every other point of each line, and its last one. */
  void thin() {
    points_ = 0;
    spacing_ *= 2;
    for (Line& line : lines_) {
      Line kept;
      for (std::size_t i = 0; i < line.size(); i += 2) kept.push_back(line[i]);
      if (line.size() % 2 == 0) kept.push_back(line.back());
      line = std::move(kept);
      points_ += line.size();
    }
    if (2 * lines_.size() > kMostPoints) lines_.erase(lines_.begin(), lines_.begin() + kMostPoints / 4);
  }

  std::vector<Line> lines_;
  std::size_t points_ = 0;
  int part_ = 0;
  double spacing_ = 0.05;  // [m]
  bool interrupted_ = true;
};

/** \brief How far a map has come that is being made. */
struct LiveMapState {
  std::optional<PoseWithCovariance> T_w_c;  ///< pose of the camera in the part; empty while unknown
  double distance = 0;                      ///< [m]
  int keyframes = 0, loops = 0;
  std::shared_ptr<const Map> map;  ///< as it is now, without depth pictures; never null
  LiveTrajectory trajectory;       ///< where the camera was

  /** \brief "34 m, 120 keyframes, 3 loops, 40 local models". */
  std::string toString() const;
};

/** \brief Makes a map while a camera moves: follows it image by image, and in the background, on a thread
 * of low priority, closes loops and writes local models and their poses to the file. Images never wait for
 * the background.
 *
 * The file is sound at any time; it says that it is under way until finish() returns. Memory does not grow
 * with time; with new rooms grow keyframes (0.2 MB each) and local models. */
class LiveMapping {
public:
  /** \brief Creates the file. Throws IoError. The destructor ends the work under way, and leaves out
   * finish(). \param map its file, which is not there yet \param parameters recorded in the map's meta */
  LiveMapping(std::filesystem::path map, const Camera& camera, const MappingParams& trajectory,
              const MapBuilderParams& places, const std::string& parameters);

  /** \brief The next image, its name, and, with odometry, the motion of the camera since the image
   * before. Throws any exception of the background thread. */
  LiveMapState update(const View& view, const std::string& name, double stamp,
                      const std::optional<Eigen::Isometry3d>& motion = {});
  /** \brief The next image may show any other place. */
  void interrupt() { map_.interrupt(); }
  /** \brief Writes the rest, with the best poses; the file is whole then. A map without local
   * models is removed. Throws IoError. */
  void finish();
  /** \brief After the latest image, or after finish(). */
  const LiveMapState& state() const { return state_; }

private:
  using Clock = std::chrono::steady_clock;
  struct SeenModel {
    LocalModel model;
    View view;
  };
  /** Work for the background, and its result. */
  struct Job {
    GrowingMap map;
    std::vector<SeenModel> models;  // new ones
    bool improve = false;
    std::shared_ptr<const Map> result;
  };

  void follow(const View& view, const std::string& name, double stamp,
              const std::optional<Eigen::Isometry3d>& motion);
  void takeResult();
  void begin(bool improve);
  void carryOut(Job& job);

  const std::filesystem::path path_;
  const Camera camera_;
  GrowingMap map_;
  std::vector<SeenModel> unwritten_;
  std::optional<Eigen::Vector3d> last_place_;  // last position on the way
  LiveMapState state_;
  Clock::time_point improved_ = Clock::now(), next_improvement_ = improved_;
  MapDatabase database_;  // used by the job alone while there is one
  std::future<Job> job_;  // the last member: the work under way uses others
};

}  // namespace facetloc

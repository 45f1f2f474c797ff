// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "example_sequence.h"
#include "temporary_folder.h"

#include <facetloc/testing/example_bag.h>

#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace facetloc::test {

/** \brief Six images that a test writes as recordings of other programs and reads again. */
class RecordedSequence : public InAFolder {
protected:
  RecordedSequence() { example_.frames = 6; }
  void writeSequence() { sequence_.emplace(DepthSequence::open(example_.write(folder_ / "sequence"))); }
  /** \brief Writes a recording of ROS 2 or RTAB-Map under a new name. */
  std::filesystem::path recordAs(const std::string& name, const std::string& ending, const std::string& words,
                                 const Trajectory& odometry) const {
    const std::filesystem::path path = folder_ / (name + std::to_string(++count_) + ending);
    EXPECT_TRUE(writeRecording(*sequence_, path, words, odometry)) << words;
    return path;
  }

  void expectImages(const DepthSequence& read, float tolerance, const std::string& words) const {
    ASSERT_EQ(read.frames().size(), 6u) << words;
    EXPECT_TRUE(read.stamped());
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(read.frames()[i].name, example_.name(i)) << words;
      const DepthImage image = read.load(i), expected = example_.image(i);
      EXPECT_EQ(image.camera, expected.camera);
      ASSERT_EQ(image.depth.size(), expected.depth.size());
      for (std::size_t p = 0; p < image.depth.size(); ++p)
        ASSERT_NEAR(image.depth[p], expected.depth[p], tolerance) << words << ", pixel " << p;
    }
  }
  void expectToBeReadByManyThreads(const DepthSequence& read, float tolerance) const {
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (int n = 0; n < 30; ++n) {
          const int i = (7 * n + t) % 6;
          const auto depth = read.load(i).depth, expected = example_.image(i).depth;
          ASSERT_EQ(depth.size(), expected.size());
          for (std::size_t p = 0; p < depth.size(); ++p) ASSERT_NEAR(depth[p], expected[p], tolerance) << i;
        }
      });
    for (std::thread& thread : threads) thread.join();
  }
  static void expectPoses(const Trajectory& read, const std::vector<StampedPose>& written, double tolerance,
                          const std::string& words) {
    ASSERT_EQ(read.poses().size(), written.size()) << words;
    for (const StampedPose& pose : written)
      EXPECT_TRUE(read.at(pose.stamp, 1e-5)->isApprox(pose.T_w_c, tolerance)) << words;
  }

  ExampleSequence example_;
  std::optional<DepthSequence> sequence_;

private:
  mutable int count_ = 0;
};

}  // namespace facetloc::test

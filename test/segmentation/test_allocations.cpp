// SPDX-License-Identifier: BSD-3-Clause
//
// Counts the allocations of this program and of the libraries that it uses.
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

namespace {

std::atomic<long> allocations{0};

}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace facetloc {
namespace {

// What a camera that pans through a furnished room sees, with new noise in each image.
std::vector<DepthImage> pan(int images, unsigned seed) {
  std::vector<DepthImage> out;
  for (int i = 0; i < images; ++i) {
    const double angle = 0.4 + 0.05 * i;
    const Eigen::Isometry3d T_w_c =
        test::lookingAlong({1, 0.5 + 0.02 * i, 1.2}, {std::cos(angle), std::sin(angle), -0.2});
    const DepthImage image = test::render(test::furnishedRoom(), test::smallCamera(), T_w_c).image;
    out.push_back(test::noisy(image, 0.5 / kKinectGain, seed + static_cast<unsigned>(i)));
  }
  return out;
}

TEST(Allocations, AreCounted) {
  const long before = allocations;
  std::vector<int> v(10);
  v.push_back(0);
  EXPECT_EQ(allocations - before, 2);
}

TEST(Allocations, ViewsOfARunningCameraNeedNone) {
  const std::vector<DepthImage> warm_up = pan(12, 1), running = pan(12, 100);
  ViewParams params;
  params.distortion.emplace(DepthDistortion::extentOf(test::smallCamera()));
  ViewBuilder builder(params);
  View view;
  for (const DepthImage& image : warm_up) builder.build(image, view);
  const long before = allocations;
  std::size_t segments = 0;
  for (const DepthImage& image : running) {
    builder.build(image, view);
    segments += view.segments.size();
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(segments, 40u);
}

}  // namespace
}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
//
// Counts the allocations of this program and of the libraries that it uses, since operator new also calls
// malloc.
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cmath>

// Sanitizers have a malloc of their own; Clang's cannot be recognized here.
#if defined(__GLIBC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&                           \
    !defined(__SANITIZE_THREAD__)

namespace {

std::atomic<long> allocations{0};

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) noexcept {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  ++allocations;
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}
}

namespace facetloc {
namespace {

// The images of a camera that pans through a furnished room, with new noise in each image.
std::vector<DepthImage> pan(const Intrinsics& camera, int images, unsigned seed) {
  std::vector<DepthImage> out;
  for (int i = 0; i < images; ++i) {
    const double angle = 0.4 + 0.05 * i;
    const Eigen::Isometry3d T_w_c =
        test::lookingAlong({1, 0.5 + 0.02 * i, 1.2}, {std::cos(angle), std::sin(angle), -0.2});
    const DepthImage image = test::render(test::furnishedRoom(), camera, T_w_c).image;
    out.push_back(test::noisy(image, 0.5 / kKinectGain, seed + static_cast<unsigned>(i)));
  }
  return out;
}

TEST(Allocations, AreCounted) {
  const long before = allocations;
  void* volatile of_new = ::operator new(10);  // volatile: no compiler leaves it out
  void* volatile of_eigen = Eigen::internal::aligned_malloc(10);
  EXPECT_EQ(allocations - before, 2);
  ::operator delete(of_new);
  Eigen::internal::aligned_free(of_eigen);
}

void expectNone(const std::vector<DepthImage>& warm_up, const std::vector<DepthImage>& running,
                SplitMethod method) {
  Camera camera;
  camera.distortion.emplace(DepthDistortion::extentOf(running[0].camera));
  ViewParams params;
  params.split.method = method;
  ViewBuilder builder(camera, params);
  View view;
  for (const DepthImage& image : warm_up) builder.build(image, view);
  const long before = allocations;
  std::size_t segments = 0;
  for (const DepthImage& image : running) {
    builder.build(image, view);
    segments += view.segments.size();
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(3 * segments, 10 * running.size());
}

TEST(Allocations, ViewsOfARunningCameraNeedNone) {
  for (const SplitMethod method : {SplitMethod::quadtree, SplitMethod::delaunay})
    expectNone(pan(test::smallCamera(), 12, 1), pan(test::smallCamera(), 12, 100), method);
}

TEST(Allocations, LargeViewsNeedNoneOnceOnesAsComplexWereSeen) {
  const std::vector<DepthImage> images = pan(kinectIntrinsics(), 6, 1);
  for (const SplitMethod method : {SplitMethod::quadtree, SplitMethod::delaunay})
    expectNone(images, images, method);
}

}  // namespace
}  // namespace facetloc

#endif

// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/plane_fit.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using test::MatrixNear, test::Rng, test::uniform;

struct Pixel {
  double u, v, d;
};

PlaneMoments momentsOf(const std::vector<Pixel>& pixels) {
  PlaneMoments m;
  for (const Pixel& p : pixels) m.add(p.u, p.v, p.d);
  return m;
}

/** All sums: of pixels, of coordinates and disparities, and of their products. */
std::vector<double> sumsOf(const PlaneMoments& m) {
  return {double(m.n),  double(m.u),  double(m.v),  double(m.d),  double(m.uu),
          double(m.uv), double(m.vv), double(m.ud), double(m.vd), double(m.dd)};
}

std::vector<Pixel> randomPixels(Rng& rng, int n, const PixelPlane& plane, double noise) {
  std::vector<Pixel> pixels;
  for (int i = 0; i < n; ++i) {
    const double u = std::floor(uniform(rng, 0, 640)), v = std::floor(uniform(rng, 0, 480));
    pixels.push_back({u, v, plane.at(u, v) + noise * test::gaussian<1>(rng)[0]});
  }
  return pixels;
}

PixelPlane randomPlane(Rng& rng) {
  return {uniform(rng, -1e-3, 1e-3), uniform(rng, -1e-3, 1e-3), uniform(rng, 0.5, 2)};
}

TEST(PixelPlane, RoundTripsThroughSpace) {
  Rng rng(1);
  const Intrinsics camera = test::smallCamera();
  for (int i = 0; i < 200; ++i) {
    const PixelPlane plane = randomPlane(rng), again = PixelPlane::fromSpace(plane.toSpace(camera), camera);
    EXPECT_NEAR(again.a, plane.a, 1e-10);
    EXPECT_NEAR(again.b, plane.b, 1e-10);
    EXPECT_NEAR(again.c, plane.c, 1e-10);
    const Eigen::Vector3d m = 0.5 * test::gaussian<3>(rng);
    EXPECT_THAT(PixelPlane::fromSpace(m, camera).toSpace(camera), MatrixNear(m, 1e-10));
  }
}

TEST(PixelPlane, IsTheInverseDepthOfThePlaneOfSpace) {
  Rng rng(2);
  const Intrinsics camera = test::smallCamera();
  for (int i = 0; i < 200; ++i) {
    const Segment s = test::randomSegment(rng);
    const PixelPlane plane = PixelPlane::fromSpace(s.normal() / s.offset(), camera);
    const double u = uniform(rng, 0, 320), v = uniform(rng, 0, 240);
    const Eigen::Vector3d p = camera.ray(u, v) / plane.at(u, v);
    EXPECT_NEAR(s.normal().dot(p), s.offset(), 1e-9 * (1 + p.norm()));
  }
}

TEST(PlaneMoments, FitIsExactOnANoiselessPlane) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const PixelPlane plane = randomPlane(rng);
    const PlaneMoments::Fit fit = momentsOf(randomPixels(rng, 200, plane, 0)).fit();
    EXPECT_NEAR(fit.plane.a, plane.a, 1e-13);  // worst observed: 1e-17
    EXPECT_NEAR(fit.plane.b, plane.b, 1e-13);
    EXPECT_NEAR(fit.plane.c, plane.c, 1e-11);
    EXPECT_NEAR(fit.sse, 0, 1e-10);
  }
}

TEST(PlaneMoments, FitIsThatOfDenseLeastSquares) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const int n = 3 + i * 5;
    const std::vector<Pixel> pixels = randomPixels(rng, n, randomPlane(rng), 0.05);
    Eigen::MatrixX3d A(n, 3);
    Eigen::VectorXd b(n);
    for (int k = 0; k < n; ++k) {
      A.row(k) << pixels[k].u, pixels[k].v, 1;
      b[k] = pixels[k].d;
    }
    const Eigen::Vector3d x = A.colPivHouseholderQr().solve(b);
    const PlaneMoments::Fit fit = momentsOf(pixels).fit();
    EXPECT_NEAR(fit.plane.a, x[0], 1e-9);
    EXPECT_NEAR(fit.plane.b, x[1], 1e-9);
    EXPECT_NEAR(fit.plane.c, x[2], 1e-7);
    EXPECT_NEAR(fit.sse, (A * x - b).squaredNorm(), 1e-8);
  }
}

TEST(PlaneMoments, OfAUnionAreTheSum) {
  Rng rng(5);
  std::vector<Pixel> all, first, second;
  for (int i = 0; i < 500; ++i) {  // integer disparities: the sums are exact in any order
    const Pixel p{std::floor(uniform(rng, 0, 640)), std::floor(uniform(rng, 0, 480)),
                  std::floor(uniform(rng, 0, 2000))};
    all.push_back(p);
    (i % 3 ? first : second).push_back(p);
  }
  const PlaneMoments whole = momentsOf(all), sum = momentsOf(first) + momentsOf(second);
  EXPECT_EQ(sumsOf(sum), sumsOf(whole));
  EXPECT_EQ(sum.fit().sse, whole.fit().sse);
}

TEST(PlaneMoments, TooFewOrCollinearPixelsGiveTheirMean) {
  EXPECT_EQ(PlaneMoments{}.fit().sse, 0);
  const std::vector<std::vector<Pixel>> degenerate{{{3, 4, 5}},
                                                   {{3, 4, 5}, {10, 20, 9}},
                                                   {{0, 0, 1}, {1, 1, 2}, {2, 2, 3}, {600, 600, 6}},
                                                   {{7, 0, 1}, {7, 1, 2}, {7, 400, 9}}};
  for (const auto& pixels : degenerate) {
    const PlaneMoments m = momentsOf(pixels);
    const PlaneMoments::Fit fit = m.fit();
    EXPECT_EQ(fit.plane.a, 0);
    EXPECT_EQ(fit.plane.b, 0);
    EXPECT_DOUBLE_EQ(fit.plane.c, m.d / m.n);
    EXPECT_NEAR(fit.sse, m.dd - m.d * m.d / m.n, 1e-12);
  }
}

TEST(PlaneMoments, ResidualsAreNeverNegative) {
  Rng rng(6);
  for (int i = 0; i < 200; ++i) EXPECT_GE(momentsOf(randomPixels(rng, 50, {0, 0, 1e3}, 1e-12)).fit().sse, 0);
}

TEST(PlaneMoments, ShiftedOnesAreThoseOfTheShiftedPixels) {
  PlaneMoments here, there;
  for (int k = 0; k < 50; ++k) {
    const int u = (7 * k) % 13, v = (5 * k) % 11;
    const double d = 100 + 0.5 * u - 0.25 * v + k % 3;
    here.add(u, v, d);
    there.add(u + 310, v + 47, d);
  }
  EXPECT_THAT(sumsOf(here.shifted(310, 47)), testing::Pointwise(testing::DoubleEq(), sumsOf(there)));
}

}  // namespace
}  // namespace facetloc

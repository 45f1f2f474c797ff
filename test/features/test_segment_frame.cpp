// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment_frame.h>
#include <facetloc/testing/own_folder.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

namespace facetloc {
namespace {

using test::MatrixNear, test::randomSegment, test::Rng;

std::vector<Segment> randomSegments(int n) {
  Rng rng(1);
  std::vector<Segment> segments;
  for (int i = 0; i < n; ++i) segments.push_back(randomSegment(rng));
  return segments;
}

// Everything that is data; behind it there is only padding.
constexpr std::size_t kBytes = offsetof(SegmentFrame, hull) + sizeof(SegmentFrame::hull);

TEST(SegmentFrame, ComesBackAsTheSegmentItWas) {
  for (const Segment& s : randomSegments(200)) {
    Segment again;
    ASSERT_TRUE(toSegment(toSegmentFrame(s), again));
    EXPECT_THAT(again.R, MatrixNear(s.R, 1e-6));
    EXPECT_THAT(again.R, test::IsRotation());
    EXPECT_THAT(again.t, MatrixNear(s.t, 1e-6));
    EXPECT_LT((again.Sigma_q - s.Sigma_q).norm(), 1e-6 * s.Sigma_q.norm());
    EXPECT_THAT(again.Sigma_q, MatrixNear(again.Sigma_q.transpose(), 0));
    EXPECT_THAT(again.lambda, MatrixNear(s.lambda, 1e-6));
    EXPECT_EQ(again.num_points, s.num_points);
    ASSERT_EQ(again.hull.size, s.hull.size);
    for (int i = 0; i < s.hull.size; ++i) EXPECT_EQ(again.hull.vertex[i], s.hull.vertex[i]);
  }
}

TEST(SegmentFrame, NormalIsTheThirdAxis) {
  for (const Segment& s : randomSegments(50))
    EXPECT_THAT(toSegmentFrame(s).normal().cast<double>(), MatrixNear(s.normal(), 1e-6));
}

TEST(SegmentFrame, TransformedAgreesWithTheTransformedSegment) {
  Rng rng(2);
  for (const Segment& s : randomSegments(100)) {
    const Eigen::Isometry3d T = test::randomPose(rng, 3, 3);
    Segment moved;
    ASSERT_TRUE(toSegment(transformed(toSegmentFrame(s), T), moved));
    const Segment want = transformed(s, T);
    EXPECT_THAT(moved.t, MatrixNear(want.t, 1e-5));
    EXPECT_THAT(moved.R, MatrixNear(want.R, 1e-6));
    EXPECT_LT((moved.Sigma_q - want.Sigma_q).norm(), 1e-6 * want.Sigma_q.norm());
  }
}

TEST(SegmentFrame, PclReadsItsNormals) {
  const pcl::PointCloud<SegmentFrame> frames = toCloud(randomSegments(20));
  pcl::PCLPointCloud2 fields;
  pcl::toPCLPointCloud2(frames, fields);
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::PointCloud<pcl::PointNormal> normals;
  pcl::fromPCLPointCloud2(fields, points);
  pcl::fromPCLPointCloud2(fields, normals);
  ASSERT_EQ(normals.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(normals[i].getVector3fMap(), frames[i].getVector3fMap());
    EXPECT_EQ(normals[i].getNormalVector3fMap(), frames[i].normal());
  }
}

TEST(SegmentFrame, NormalsThatWereTurnedAloneAreRefused) {
  SegmentFrame frame = toSegmentFrame(randomSegments(1)[0]);
  Segment s;
  ASSERT_TRUE(toSegment(frame, s));
  SegmentFrame without = frame;
  without.normal_x = without.normal_y = without.normal_z = 0;
  EXPECT_FALSE(toSegment(without, s));
  frame.normal_x = -frame.normal_x, frame.normal_y = -frame.normal_y, frame.normal_z = -frame.normal_z;
  EXPECT_FALSE(toSegment(frame, s));
  frame.normal_x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(toSegment(frame, s));
}

TEST(SegmentFrame, CloudsAreTransformedFrameByFrame) {
  Rng rng(4);
  pcl::PointCloud<SegmentFrame> frames = toCloud(randomSegments(5));
  frames.header.frame_id = "here";
  const Eigen::Isometry3d T = test::randomPose(rng, 3, 3);
  const pcl::PointCloud<SegmentFrame> moved = transformed(frames, T);
  ASSERT_EQ(moved.size(), frames.size());
  EXPECT_EQ(moved.header.frame_id, "here");
  for (std::size_t i = 0; i < moved.size(); ++i)
    EXPECT_EQ(moved[i].normal(), transformed(frames[i], T).normal());
}

TEST(SegmentFrame, IsWrittenAsPclWritesItsPoints) {
  Segment s = randomSegments(1)[0];
  s.t << 1, 2, 3.5;
  s.R = Eigen::Matrix3d::Identity();
  s.num_points = 77;
  std::ostringstream out;
  out << toSegmentFrame(s);
  EXPECT_EQ(out.str(), "(1,2,3.5 - 0,0,1 - 77 points)");
}

class SegmentFramePcd : public testing::TestWithParam<bool> {};

TEST_P(SegmentFramePcd, RoundTripIsExactToTheByte) {
  pcl::PointCloud<SegmentFrame> cloud = toCloud(randomSegments(100)), again;
  cloud[3].x = std::numeric_limits<float>::quiet_NaN();  // invalid frames are stored like all others
  cloud[4].sigma_q[2] = std::numeric_limits<float>::infinity();
  cloud.is_dense = false;
  const test::OwnFolder folder;
  const std::string path = folder.path() / "frames.pcd";
  const bool compressed = GetParam();
  ASSERT_EQ(compressed ? pcl::io::savePCDFileBinaryCompressed(path, cloud)
                       : pcl::io::savePCDFileBinary(path, cloud),
            0);
  EXPECT_EQ(pcl::io::loadPCDFile(path, again), 0);
  ASSERT_EQ(again.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) EXPECT_EQ(std::memcmp(&again[i], &cloud[i], kBytes), 0) << i;
}

INSTANTIATE_TEST_SUITE_P(BinaryAndCompressed, SegmentFramePcd, testing::Bool());

TEST(SegmentFrame, FieldsThatAreNotFiniteAreRefused) {
  const SegmentFrame good = toSegmentFrame(randomSegments(1)[0]);
  Segment out;
  ASSERT_TRUE(toSegment(good, out));
  const Segment before = out;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    const auto refused = [&](auto set) {
      SegmentFrame f = good;
      set(f);
      EXPECT_FALSE(toSegment(f, out));
    };
    for (int i = 0; i < 3; ++i) refused([&](SegmentFrame& f) { f.data[i] = bad; });
    for (int i = 0; i < 4; ++i) refused([&](SegmentFrame& f) { f.orientation[i] = bad; });
    for (int i = 0; i < 6; ++i) refused([&](SegmentFrame& f) { f.sigma_q[i] = bad; });
    for (int i = 0; i < 2; ++i) refused([&](SegmentFrame& f) { f.lambda[i] = bad; });
    for (int i = 0; i < 2 * good.hull_size; ++i) refused([&](SegmentFrame& f) { f.hull[i] = bad; });
  }
  EXPECT_EQ(out.t, before.t);  // unchanged by refusals
  EXPECT_EQ(out.R, before.R);
  EXPECT_EQ(out.num_points, before.num_points);
}

TEST(SegmentFrame, InvalidRotationsAndCovariancesAreRefused) {
  const SegmentFrame good = toSegmentFrame(randomSegments(1)[0]);
  Segment out;
  SegmentFrame f = good;
  std::fill_n(f.orientation, 4, 0.f);
  EXPECT_FALSE(toSegment(f, out));
  f = good;
  for (float& q : f.orientation) q *= 1.1f;
  EXPECT_FALSE(toSegment(f, out));
  f = good;
  f.sigma_q[0] = -f.sigma_q[0];
  EXPECT_FALSE(toSegment(f, out));
  f = good;
  f.sigma_q[1] = 2 * std::sqrt(f.sigma_q[0] * f.sigma_q[3]);
  EXPECT_FALSE(toSegment(f, out));
  EXPECT_FALSE(toSegment(SegmentFrame{}, out));  // an empty frame has no uncertainty
  f = good;
  f.lambda[1] = -1;
  EXPECT_FALSE(toSegment(f, out));
  f = good;
  f.num_points = -1;
  EXPECT_FALSE(toSegment(f, out));
}

TEST(SegmentFrame, AnOutlineOfAnImpossibleSizeIsRefused) {
  const SegmentFrame good = toSegmentFrame(randomSegments(1)[0]);
  Segment out;
  for (const std::int32_t size : {-1, ConvexHull::kMaxVertices + 1, std::numeric_limits<std::int32_t>::max(),
                                  std::numeric_limits<std::int32_t>::min()}) {
    SegmentFrame f = good;
    f.hull_size = size;
    EXPECT_FALSE(toSegment(f, out)) << size;
  }
}

TEST(SegmentFrame, AnyBytesAreReadWithoutACrash) {
  Rng rng(3);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    SegmentFrame f = toSegmentFrame(randomSegment(rng));
    auto* bytes = reinterpret_cast<unsigned char*>(f.data);
    for (int k = 0; k < 1 + i % 40; ++k) bytes[rng() % kBytes] = static_cast<unsigned char>(rng());
    Segment out;
    if (!toSegment(f, out)) continue;
    ++accepted;
    EXPECT_TRUE(out.R.allFinite() && out.t.allFinite() && out.Sigma_q.allFinite());
    EXPECT_LE(out.hull.size, ConvexHull::kMaxVertices);
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, 20000);
}

}  // namespace
}  // namespace facetloc

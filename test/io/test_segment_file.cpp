// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/features/segment_frame.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/segment_file.h>
#include <facetloc/testing/full_disk.h>

#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

namespace facetloc::test {
namespace {

TEST(WritingSegments, AFullDiskIsReportedWithTheOutputFile) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.segments.pcd";
  const auto segments = ExampleMap().view().segments;
  for (const auto& written : {segments, std::vector<Segment>()}) {
    const FullDisk full(100);
    EXPECT_THAT(ioErrorOf([&] { writeSegments(path, written); }),
                StartsWith(path.string() + ": " + FullDisk::kWords));
    EXPECT_EQ(folder.count(), 0);
  }
}

class SegmentFile : public InAFolder {
protected:
  std::string errorOf(const std::string& file) const {
    return ioErrorOf([&] { readSegments(folder_ / file); });
  }
  void put(const std::string& file, const pcl::PCLPointCloud2& points) const {
    ASSERT_EQ(pcl::PCDWriter().writeBinaryCompressed((folder_ / file).string(), points), 0);
  }
  static pcl::PCLPointCloud2 pointsOf(const pcl::PointCloud<SegmentFrame>& frames) {
    pcl::PCLPointCloud2 points;
    pcl::toPCLPointCloud2(frames, points);
    return points;
  }
  static void drop(const std::string& prefix, pcl::PCLPointCloud2& points) {
    auto& fields = points.fields;
    fields.erase(std::remove_if(fields.begin(), fields.end(),
                                [&](const pcl::PCLPointField& f) { return f.name.rfind(prefix, 0) == 0; }),
                 fields.end());
  }
  void expectSame(const std::vector<Segment>& read) const {
    ASSERT_EQ(read.size(), segments_.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      const SegmentFrame a = toSegmentFrame(read[i]), b = toSegmentFrame(segments_[i]);
      EXPECT_EQ(a.getVector3fMap(), b.getVector3fMap());
      EXPECT_LT((a.normal() - b.normal()).norm(), 1e-6);
      EXPECT_EQ(a.num_points, b.num_points);
      EXPECT_EQ(a.hull_size, b.hull_size);
      EXPECT_TRUE(std::equal(std::begin(a.sigma_q), std::end(a.sigma_q), b.sigma_q));
      EXPECT_TRUE(std::equal(std::begin(a.hull), std::end(a.hull), b.hull));
    }
  }

  const std::vector<Segment> segments_ = ExampleMap().view().segments;
};

TEST_F(SegmentFile, ComesBackAsItWasWritten) {
  for (const std::string name : {"a.segments.pcd", "b.pcd"}) {
    writeSegments(folder_ / name, segments_);
    expectSame(readSegments(folder_ / name));
  }
  writeSegments(folder_ / "none.segments.pcd", {});
  EXPECT_TRUE(readSegments(folder_ / "none.segments.pcd").empty());
}

TEST_F(SegmentFile, WithFaultsSaysThem) {
  for (const std::string field : {"sigma_q", "normal_y"}) {
    pcl::PCLPointCloud2 points = pointsOf(toCloud(segments_));
    drop(field, points);
    put("points.pcd", points);
    EXPECT_THAT(errorOf("points.pcd"), HasAll("no field " + field, "facetloc_segment"));
  }

  pcl::PCLPointCloud2 points = pointsOf(toCloud(segments_));
  for (pcl::PCLPointField& field : points.fields)
    if (field.name == "hull_size") field.datatype = pcl::PCLPointField::FLOAT32;
  put("typed.pcd", points);
  EXPECT_THAT(errorOf("typed.pcd"), HasSubstr("hull_size of another type"));

  pcl::PointCloud<SegmentFrame> frames = toCloud(segments_);
  frames[1].hull_size = 1000000;
  put("huge.pcd", pointsOf(frames));
  EXPECT_THAT(errorOf("huge.pcd"), HasSubstr("point 1 is no segment"));

  frames = toCloud(segments_);
  frames[0].x = std::numeric_limits<float>::quiet_NaN();
  put("nan.pcd", pointsOf(frames));
  EXPECT_THAT(errorOf("nan.pcd"), HasSubstr("point 0 is no segment"));

  std::ofstream(folder_ / "text.segments.pcd") << "no points\n";
  EXPECT_THAT(errorOf("text.segments.pcd"), HasSubstr("not a PCD file"));
  EXPECT_THAT(errorOf("nowhere.segments.pcd"), HasSubstr("nowhere"));
}

TEST_F(SegmentFile, EveryCutIsAnError) {
  writeSegments(folder_ / "a.segments.pcd", segments_);
  const std::string bytes = bytesOf(folder_ / "a.segments.pcd");
  for (std::size_t n = 0; n < bytes.size(); n += 7) {
    putBytes(folder_ / "cut.segments.pcd", bytes.substr(0, n));
    EXPECT_NE(errorOf("cut.segments.pcd"), "") << n;
  }
}

TEST_F(SegmentFile, IsASequenceForThoseWhoAskForIt) {
  for (const std::string name : {"1.5", "0.5"}) {
    writeSegments(folder_ / (name + ".segments.pcd"), segments_);
    std::ofstream(folder_ / (name + ".png"));  // its labels
    std::ofstream(folder_ / (name + ".pcd"));
  }
  RecordingHints hints;
  hints.segments = true;
  const DepthSequence sequence = DepthSequence::open(folder_.path(), hints);
  ASSERT_TRUE(sequence.ofSegments());
  ASSERT_EQ(sequence.frames().size(), 2u);
  EXPECT_EQ(sequence.frames()[0].name, "0.5");
  EXPECT_EQ(sequence.frames()[1].stamp, 1.5);
  expectSame(sequence.segments(1));
  EXPECT_THROW(sequence.segments(2), std::out_of_range);
  EXPECT_THAT(ioErrorOf([&] { sequence.load(0); }), HasSubstr("no depth image"));
  EXPECT_FALSE(DepthSequence::open(folder_ / "0.5.segments.pcd", hints).frames().empty());
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_.path()); }), HasSubstr("facetloc_localize"));
  std::ofstream(folder_ / "both.txt") << "0.5.segments.pcd\n1.5.png\n";
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / "both.txt", hints); }), HasSubstr("one kind"));
}

}  // namespace
}  // namespace facetloc::test

// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment_frame_estimation.h>
#include <facetloc/testing/organized_clouds.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace facetloc {
namespace {

using test::organizedCloud, test::Rendering, testing::HasSubstr, testing::IsEmpty;

pcl::PointCloud<pcl::Label>::Ptr labelCloud(const LabelImage& labels) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::Label>>(labels.width, labels.height);
  for (std::size_t i = 0; i < labels.label.size(); ++i) (*cloud)[i].label = labels.label[i];
  return cloud;
}

template <typename PointT>
class SegmentFrameEstimationTest : public testing::Test {
protected:
  SegmentFrameEstimationTest() {
    view = test::render(test::furnishedRoom(), test::tinyCamera(),
                        test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}));
    cloud = organizedCloud<PointT>(view.image);
    labels = labelCloud(view.labels);
    estimation.setInputCloud(cloud);
    estimation.setLabels(labels);
  }
  void expectEmpty(const std::string& why) {
    estimation.compute(frames);
    EXPECT_TRUE(frames.empty());
    EXPECT_THAT(estimation.usedLabels(), IsEmpty());
    EXPECT_THAT(estimation.getReason(), HasSubstr(why));
  }

  Rendering view;
  typename pcl::PointCloud<PointT>::Ptr cloud;
  pcl::PointCloud<pcl::Label>::Ptr labels;
  SegmentFrameEstimation<PointT> estimation;
  pcl::PointCloud<SegmentFrame> frames;
};
using PointTypes = testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGB, pcl::PointXYZRGBA>;
TYPED_TEST_SUITE(SegmentFrameEstimationTest, PointTypes, );  // the comma for -Wpedantic of Clang

TYPED_TEST(SegmentFrameEstimationTest, FramesAreThoseOfTheDepthImage) {
  this->cloud->header.stamp = 42;
  this->cloud->header.frame_id = "camera";
  this->estimation.setCamera({this->view.image.camera, {}, {}, {}});
  this->estimation.compute(this->frames);
  EXPECT_EQ(this->estimation.getReason(), "");
  EXPECT_EQ(this->frames.header.stamp, 42u);
  EXPECT_EQ(this->frames.header.frame_id, "camera");
  std::vector<int> kept;
  const std::vector<Segment> want = estimateSegments(this->view.image, this->view.labels, {}, {}, &kept);
  ASSERT_GE(want.size(), 4u);
  ASSERT_EQ(this->frames.size(), want.size());
  EXPECT_EQ(this->estimation.usedLabels(), std::vector<std::uint32_t>(kept.begin(), kept.end()));
  for (std::size_t i = 0; i < want.size(); ++i) {
    EXPECT_LT((this->frames[i].getVector3fMap() - want[i].t.template cast<float>()).norm(), 1e-6);
    EXPECT_EQ(this->frames[i].num_points, want[i].num_points);
  }
}

TYPED_TEST(SegmentFrameEstimationTest, BadDataGivesAnEmptyOutputAndAReason) {
  this->estimation.compute(this->frames);
  ASSERT_FALSE(this->frames.empty());
  const auto good = this->cloud;
  const auto setCloud = [&](auto input) { this->estimation.setInputCloud(input); };
  using Cloud = pcl::PointCloud<TypeParam>;

  setCloud(pcl::make_shared<Cloud>());
  this->expectEmpty("no input cloud");
  setCloud(typename Cloud::ConstPtr());
  this->expectEmpty("no input cloud");

  auto nan = pcl::make_shared<Cloud>(*good);
  for (auto& p : *nan) p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
  setCloud(nan);
  this->expectEmpty("camera");
  this->estimation.setCamera({this->view.image.camera, {}, {}, {}});
  this->expectEmpty("no label");

  setCloud(good);
  this->estimation.setCamera({kinectIntrinsics(), {}, {}, {}});
  this->expectEmpty("camera that was set has not the size");
  const Intrinsics of_tiny_camera = test::tinyCamera();
  this->estimation.setCamera(
      {Intrinsics{of_tiny_camera.width, of_tiny_camera.height, 0, 0, 0, 0}, {}, {}, {}});
  this->expectEmpty("camera that was set is impossible");
  this->estimation.setCamera({});
  this->estimation.setLabels({});
  this->expectEmpty("one label per point");
  auto few = pcl::make_shared<pcl::PointCloud<pcl::Label>>(*this->labels);
  few->points.pop_back();
  this->estimation.setLabels(few);
  this->expectEmpty("one label per point");

  this->estimation.setLabels(this->labels);
  this->estimation.compute(this->frames);
  EXPECT_FALSE(this->frames.empty());
  EXPECT_EQ(this->estimation.getReason(), "");
}

TYPED_TEST(SegmentFrameEstimationTest, IndicesRestrictTheSupport) {
  this->estimation.compute(this->frames);
  const auto whole = this->frames;
  const std::uint32_t chosen = this->estimation.usedLabels().at(0);
  auto indices = pcl::make_shared<pcl::Indices>();
  int left = 0;
  for (std::size_t i = 0; i < this->cloud->size(); ++i)
    if ((*this->labels)[i].label == chosen && i % this->cloud->width < 100)
      indices->push_back(static_cast<int>(i)), ++left;
  this->estimation.setIndices(indices);
  this->estimation.compute(this->frames);
  ASSERT_EQ(this->frames.size(), 1u);
  EXPECT_LE(this->frames[0].num_points, left);
  EXPECT_GT(this->frames[0].num_points, 0.99 * left);
  EXPECT_EQ(this->estimation.usedLabels(), std::vector<std::uint32_t>{chosen});

  this->estimation.setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0, 1, 2}));
  this->expectEmpty("no label");
}

// PCL's segmenters give such labels, and the largest number to points without a region.
TYPED_TEST(SegmentFrameEstimationTest, LabelsMayBeAnyNumbers) {
  this->estimation.compute(this->frames);
  const auto before = this->frames;
  const auto used = this->estimation.usedLabels();
  constexpr std::uint32_t kOffset = 65536;
  for (auto& l : *this->labels) l.label = l.label ? l.label + kOffset : 0xffffffffu;
  this->estimation.compute(this->frames);
  ASSERT_EQ(this->frames.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(this->frames[i].getVector3fMap(), before[i].getVector3fMap());
    EXPECT_EQ(this->estimation.usedLabels()[i], used[i] + kOffset);
  }
  std::uint32_t next = 1;
  for (auto& l : *this->labels) l.label = next++;
  this->expectEmpty(this->labels->size() > 65535 ? "more than 65535" : "no label");
}

TYPED_TEST(SegmentFrameEstimationTest, ACloudThatTheCameraDoesNotSeeSoIsRefused) {
  this->estimation.setCamera({this->view.image.camera, {}, {}, {}});
  for (auto& p : *this->cloud) p.x += 0.5f;
  this->expectEmpty("not where the camera that was set sees them");
}

// Eighteen planes gave eleven frames without a word.
TYPED_TEST(SegmentFrameEstimationTest, LabelsThatAreNoSegmentsAreListedWithTheirReason) {
  for (int k = 0; k < 6; ++k) (*this->labels)[static_cast<std::size_t>(k)].label = 900;
  this->estimation.compute(this->frames);
  ASSERT_FALSE(this->frames.empty());
  std::set<std::uint32_t> given;
  for (const pcl::Label& l : *this->labels)
    if (l.label) given.insert(l.label);
  const auto& left_out = this->estimation.leftOut();
  EXPECT_EQ(this->frames.size() + left_out.size(), given.size());
  const auto small =
      std::find_if(left_out.begin(), left_out.end(), [](const auto& l) { return l.label == 900; });
  ASSERT_NE(small, left_out.end());
  EXPECT_THAT(small->reason, HasSubstr("too few"));
  EXPECT_THAT(toString(left_out, given.size()), HasSubstr("900"));
  EXPECT_EQ(toString({}, 5), "");
}

TYPED_TEST(SegmentFrameEstimationTest, FilteredCloudsAreSeenFromTheirViewpoint) {
  this->estimation.compute(this->frames);
  const pcl::PointCloud<SegmentFrame> organized = this->frames;
  const Eigen::Vector3f moved(0.5f, -1, 2);
  auto filtered = pcl::make_shared<pcl::PointCloud<TypeParam>>();
  auto left_labels = pcl::make_shared<pcl::PointCloud<pcl::Label>>();
  for (std::size_t i = 0; i < this->cloud->size(); ++i)
    if (auto p = (*this->cloud)[i]; std::isfinite(p.z) && i % 3 == 0) {
      p.getVector3fMap() += moved;
      filtered->push_back(p);
      left_labels->push_back((*this->labels)[i]);
    }
  this->estimation.setInputCloud(filtered);
  this->estimation.setLabels(left_labels);
  this->estimation.setViewpoint(moved);
  this->estimation.compute(this->frames);
  ASSERT_GE(this->frames.size() + 2, organized.size());
  for (const SegmentFrame& f : this->frames) {
    const bool is_known = std::any_of(organized.begin(), organized.end(), [&](const SegmentFrame& o) {
      return f.normal().dot(o.normal()) > 0.999f &&
             std::abs(o.normal().dot(f.getVector3fMap() - moved - o.getVector3fMap())) < 0.02f;
    });
    EXPECT_TRUE(is_known) << f;
  }
  EXPECT_EQ(this->frames.size(), this->estimation.usedLabels().size());
}

TYPED_TEST(SegmentFrameEstimationTest, FramesKnowTheNoiseOfTheirCloud) {
  this->estimation.compute(this->frames);
  const float usual = this->frames[0].noise;
  EXPECT_NEAR(usual, SensorNoise{}.inverse_depth_std, 1e-6);
  this->estimation.setInputCloud(
      organizedCloud<TypeParam>(test::noisy(this->view.image, 4 * SensorNoise{}.inverse_depth_std, 1)));
  this->estimation.compute(this->frames);
  ASSERT_FALSE(this->frames.empty());
  EXPECT_GT(this->frames[0].noise, 3 * usual);
  EXPECT_GT(this->estimation.getNoise().inverse_depth_std, 3 * SensorNoise{}.inverse_depth_std);
}

}  // namespace
}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/planar_segmentation.h>
#include <facetloc/testing/organized_clouds.h>

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <set>

namespace facetloc::test {

/** \brief A point type that no library knows. */
struct EIGEN_ALIGN16 PointOfAUser {
  PCL_ADD_POINT4D;
  double confidence = 0;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace facetloc::test

POINT_CLOUD_REGISTER_POINT_STRUCT(facetloc::test::PointOfAUser,
                                  (float, x, x)(float, y, y)(float, z, z)(double, confidence, confidence))

namespace facetloc {
namespace {

using test::organizedCloud, testing::HasSubstr;

template <typename PointT>
class PlanarSegmentationTest : public testing::Test {
protected:
  using Cloud = pcl::PointCloud<PointT>;

  PlanarSegmentationTest() {
    const DepthImage image = test::render(test::furnishedRoom(), test::smallCamera(),
                                          test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}))
                                 .image;
    cloud = organizedCloud<PointT>(test::noisy(image, 0.5 / kKinectGain, 1));
    (*cloud)[7].x = (*cloud)[7].y = (*cloud)[7].z = std::numeric_limits<float>::quiet_NaN();
    segmentation = pcl::make_shared<PlanarSegmentation<PointT>>();
  }
  // Fills the outputs from a good cloud, then expects a bad one to leave nothing of them.
  void expectNothingFrom(const typename Cloud::ConstPtr& bad, const std::string& why) {
    segmentation->setInputCloud(cloud);
    segmentation->segment(segments, planes);
    ASSERT_FALSE(segments.empty());
    ASSERT_EQ(segmentation->getReason(), "");
    segmentation->setInputCloud(bad);
    segmentation->segment(segments, planes);
    EXPECT_TRUE(segments.empty());
    EXPECT_TRUE(planes.empty());
    EXPECT_THAT(segmentation->getReason(), HasSubstr(why));
    segmentation->segment(segments);
    EXPECT_TRUE(segments.empty());
    EXPECT_TRUE(segmentationOf().getSegmentation().planes.empty());
    pcl::PointCloud<pcl::Label> labels(3, 2);
    segmentationOf().segment(labels);
    for (const pcl::Label& l : labels) EXPECT_EQ(l.label, 0u);
  }
  PlanarSegmentation<PointT>& segmentationOf() {
    return dynamic_cast<PlanarSegmentation<PointT>&>(*segmentation);
  }

  typename Cloud::Ptr cloud;
  typename pcl::Segmentation<PointT>::Ptr segmentation;  // everything through the base
  std::vector<pcl::PointIndices> segments;
  std::vector<pcl::ModelCoefficients> planes;
};
using PointTypes =
    testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGB, pcl::PointXYZRGBA, test::PointOfAUser>;
TYPED_TEST_SUITE(PlanarSegmentationTest, PointTypes, );  // the comma for -Wpedantic of Clang

TYPED_TEST(PlanarSegmentationTest, PointsOfASegmentLieOnItsPlaneWhichFacesTheSensor) {
  this->cloud->header.frame_id = "camera";
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->segment(this->segments, this->planes);
  ASSERT_GE(this->segments.size(), 4u);
  ASSERT_EQ(this->planes.size(), this->segments.size());
  std::set<int> seen;
  std::size_t size_before = this->cloud->size();
  for (std::size_t k = 0; k < this->segments.size(); ++k) {
    EXPECT_EQ(this->segments[k].header.frame_id, "camera");
    EXPECT_EQ(this->planes[k].header.frame_id, "camera");
    ASSERT_EQ(this->planes[k].values.size(), 4u);
    const Eigen::Vector3f n(this->planes[k].values[0], this->planes[k].values[1], this->planes[k].values[2]);
    const float d = this->planes[k].values[3];
    EXPECT_NEAR(n.norm(), 1, 1e-5);
    EXPECT_GT(d, 0);  // the sensor, at the origin, lies in front
    double sum = 0;
    for (const int i : this->segments[k].indices) {
      EXPECT_TRUE(seen.insert(i).second) << "point " << i << " is in two segments";
      const Eigen::Vector3f p = (*this->cloud)[i].getVector3fMap();
      EXPECT_LT(n.dot(p), 0);
      sum += n.dot(p) + d;
      EXPECT_NEAR(n.dot(p) + d, 0,
                  0.02 * p.z() * p.z());  // five times the noise, and the distortion of the ray
    }
    EXPECT_NEAR(sum / this->segments[k].indices.size(), 0, 0.005);
    EXPECT_LE(this->segments[k].indices.size(), size_before);
    size_before = this->segments[k].indices.size();
  }
  EXPECT_EQ(seen.count(7), 0u);  // the point that is not one
}

TYPED_TEST(PlanarSegmentationTest, LabelsAndIndicesSayTheSame) {
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->segment(this->segments);
  pcl::PointCloud<pcl::Label> labels;
  this->segmentationOf().segment(labels);
  EXPECT_EQ(labels.width, this->cloud->width);
  EXPECT_EQ(labels.height, this->cloud->height);
  std::size_t labelled = 0;
  for (const pcl::Label& l : labels) labelled += l.label != 0;
  for (std::size_t k = 0; k < this->segments.size(); ++k) {
    labelled -= this->segments[k].indices.size();
    for (const int i : this->segments[k].indices) EXPECT_EQ(labels[i].label, k + 1);
  }
  EXPECT_EQ(labelled, 0u);
}

TYPED_TEST(PlanarSegmentationTest, BadCloudsLeaveNothingOfTheCallBefore) {
  using Points = pcl::PointCloud<TypeParam>;
  this->expectNothingFrom(nullptr, "no input cloud");
  this->expectNothingFrom(pcl::make_shared<Points>(), "no input cloud");
  auto unorganized = pcl::make_shared<Points>(*this->cloud);
  unorganized->width *= unorganized->height;
  unorganized->height = 1;
  this->expectNothingFrom(unorganized, "not organized");
  auto nan = pcl::make_shared<Points>(*this->cloud);
  for (auto& p : *nan) p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
  this->expectNothingFrom(nan, "camera");
  auto two_by_two = pcl::make_shared<Points>(2, 2);
  this->expectNothingFrom(two_by_two, "camera");
}

TYPED_TEST(PlanarSegmentationTest, AnImpossibleCameraOrOneOfAnotherSizeIsRefused) {
  const Intrinsics camera = test::smallCamera();
  this->segmentation->setInputCloud(this->cloud);
  this->segmentationOf().setCamera({Intrinsics{camera.width, camera.height, 0, 0, 0, 0}, {}, {}, {}});
  this->segmentation->segment(this->segments);
  EXPECT_TRUE(this->segments.empty());
  EXPECT_THAT(this->segmentation->getReason(), HasSubstr("camera that was set is impossible"));
  this->segmentationOf().setCamera({kinectIntrinsics(), {}, {}, {}});
  this->segmentation->segment(this->segments);
  EXPECT_TRUE(this->segments.empty());
  EXPECT_THAT(this->segmentation->getReason(), HasSubstr("camera that was set has not the size"));
}

TYPED_TEST(PlanarSegmentationTest, IndicesBeyondTheCloudAreRefused) {
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0, 320 * 240}));
  this->segmentation->segment(this->segments);
  EXPECT_TRUE(this->segments.empty());
  EXPECT_THAT(this->segmentation->getReason(), HasSubstr("indices"));
}

TYPED_TEST(PlanarSegmentationTest, AnAllInvalidCloudOfAKnownCameraHasNoSegment) {
  this->segmentationOf().setCamera({test::smallCamera(), {}, {}, {}});
  auto nan = pcl::make_shared<pcl::PointCloud<TypeParam>>(*this->cloud);
  for (auto& p : *nan) p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
  this->expectNothingFrom(nan, "no planar segment");
}

TYPED_TEST(PlanarSegmentationTest, PointsBehindTheCameraAreNamed) {
  auto turned = pcl::make_shared<pcl::PointCloud<TypeParam>>(*this->cloud);
  for (auto& p : *turned) p.y = -p.y, p.z = -p.z;
  this->expectNothingFrom(turned, "behind the camera");
  this->segmentationOf().setCamera({test::smallCamera(), {}, {}, {}});
  this->expectNothingFrom(turned, "behind the camera");
}

TYPED_TEST(PlanarSegmentationTest, ACloudAlignedToAFinerImageIsSegmentedWithoutItsHoles) {
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->segment(this->segments);
  const std::size_t dense = this->segments.size();
  auto sparse = pcl::make_shared<pcl::PointCloud<TypeParam>>(*this->cloud);
  for (std::uint32_t v = 0; v < sparse->height; ++v)
    for (std::uint32_t u = 0; u < sparse->width; ++u)
      if (auto& p = (*sparse)(u, v); u % 2 == 0 || v % 2 == 0)
        p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
  this->segmentation->setInputCloud(sparse);
  this->segmentation->segment(this->segments);
  EXPECT_GE(double(this->segments.size()), 0.7 * double(dense));
  for (const auto& segment : this->segments)
    for (const auto i : segment.indices) ASSERT_TRUE(std::isfinite((*sparse)[std::size_t(i)].z));
}

TYPED_TEST(PlanarSegmentationTest, IndicesAreRespected) {
  auto indices = pcl::make_shared<pcl::Indices>();
  for (int v = 0; v < 240; ++v)
    for (int u = 150; u < 320; ++u) indices->push_back(320 * v + u);
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->setIndices(indices);
  this->segmentation->segment(this->segments, this->planes);
  ASSERT_FALSE(this->segments.empty());
  for (const auto& s : this->segments)
    for (const int i : s.indices) EXPECT_GE(i % 320, 150);
  this->segmentation->setIndices(pcl::make_shared<pcl::Indices>());
  this->segmentation->segment(this->segments, this->planes);
  EXPECT_TRUE(this->segments.empty());
  EXPECT_NE(this->segmentation->getReason(), "");
}

TYPED_TEST(PlanarSegmentationTest, GettersReturnTheValuesSet) {
  PlanarSegmentation<TypeParam>& s = this->segmentationOf();
  s.setMinInliers(777);
  EXPECT_EQ(s.getMinInliers(), 777u);
  EXPECT_EQ(s.getParams().labels.min_support, 777);
  Camera camera;
  camera.noise.inverse_depth_std = 0.01;
  s.setCamera(camera);
  EXPECT_EQ(s.getCamera().noise.inverse_depth_std, 0.01);
  EXPECT_EQ(this->segmentation->getClassName(), "PlanarSegmentation");
  s.setMinInliers(1000000);
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->segment(this->segments);
  EXPECT_TRUE(this->segments.empty());
  EXPECT_THAT(this->segmentation->getReason(), HasSubstr("minimum support"));
}

// Most planes of a cloud are found in every third of its points, as indices or as a cloud of their own.
TYPED_TEST(PlanarSegmentationTest, ThinnedCloudsHaveTheirPlanes) {
  this->segmentation->setInputCloud(this->cloud);
  this->segmentation->segment(this->segments);
  const std::size_t all = this->segments.size();
  auto third = pcl::make_shared<pcl::Indices>();
  auto thinned = pcl::make_shared<pcl::PointCloud<TypeParam>>();
  for (std::size_t i = 0; i < this->cloud->size(); i += 3)
    if (std::isfinite((*this->cloud)[i].z)) third->push_back(static_cast<int>(i));
  for (std::size_t i = 0; i < third->size(); i += 3)
    thinned->push_back((*this->cloud)[std::size_t((*third)[i])]);
  this->segmentation->setIndices(third);
  this->segmentation->segment(this->segments);
  EXPECT_GE(2 * this->segments.size(), all) << this->segmentation->getReason();
  for (const auto& segment : this->segments)
    for (const auto i : segment.indices) ASSERT_EQ(i % 3, 0);

  PlanarSegmentation<TypeParam> of_thinned;
  of_thinned.setCamera({test::smallCamera(), {}, {}, {}});
  of_thinned.setInputCloud(thinned);
  of_thinned.segment(this->segments);
  EXPECT_GE(3 * this->segments.size(), all) << of_thinned.getReason();

  auto sparse = pcl::make_shared<pcl::PointCloud<TypeParam>>();
  for (std::size_t i = 0; i < thinned->size(); i += 97) sparse->push_back((*thinned)[i]);
  of_thinned.setInputCloud(sparse);
  of_thinned.segment(this->segments);
  EXPECT_TRUE(this->segments.empty());
  EXPECT_THAT(of_thinned.getReason(), HasSubstr("too sparse"));
}

// A filtered cloud is seen by the camera that is set.
TYPED_TEST(PlanarSegmentationTest, FilteredCloudsAreSegmentedByTheirCamera) {
  this->segmentation->setInputCloud(this->cloud);
  this->segmentationOf().setCamera({test::smallCamera(), {}, {}, {}});
  this->segmentation->segment(this->segments);
  const std::size_t organized = this->segments.size();
  auto filtered = pcl::make_shared<pcl::PointCloud<TypeParam>>();
  for (const auto& p : *this->cloud)
    if (std::isfinite(p.z)) filtered->push_back(p);
  this->segmentation->setInputCloud(filtered);
  this->segmentation->segment(this->segments);
  EXPECT_EQ(this->segments.size(), organized) << this->segmentation->getReason();
  for (const auto& segment : this->segments)
    for (const auto i : segment.indices) ASSERT_LT(static_cast<std::size_t>(i), filtered->size());
  for (auto& p : *filtered) p.x += 100;
  this->expectNothingFrom(filtered, "does not see most of its points");
  this->segmentationOf().setCamera({});
  this->expectNothingFrom(filtered, "set a camera");
}

}  // namespace
}  // namespace facetloc

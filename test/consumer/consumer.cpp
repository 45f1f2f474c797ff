// SPDX-License-Identifier: BSD-3-Clause
//
// An outside project: the PCL classes through their base pointers, with a built-in and a custom point type,
// and the grabber with the virtual camera of the package.
#include <facetloc/openni/openni_grabber.h>
#include <facetloc/registration/ekf_registration.h>
#include <facetloc/registration/planar_registration.h>
#include <facetloc/segmentation/planar_segmentation.h>
#include <facetloc/simulation/simulated_camera.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <future>
#include <limits>
#include <utility>

struct EIGEN_ALIGN16 RadarPoint {
  PCL_ADD_POINT4D;
  float strength = 0;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};
POINT_CLOUD_REGISTER_POINT_STRUCT(RadarPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(float, strength, strength))

namespace {

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr roomCloud(double heading) {
  facetloc::SimulatedCamera camera(facetloc::kinectIntrinsics().subsampled(2), {}, 1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = facetloc::expSO3({0, 0, heading});
  T = T * facetloc::CameraMounting{1.0, 10.0}.T_b_c();
  const facetloc::DepthImage image = camera.render(facetloc::randomRoom(2, 16), T, 0).depth;
  auto cloud = pcl::make_shared<pcl::PointCloud<PointT>>(image.camera.width, image.camera.height);
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const float z = image.at(u, v);
      const float nan = std::numeric_limits<float>::quiet_NaN();
      (*cloud)(u, v).getVector3fMap() =
          z > 0 ? Eigen::Vector3f(z * image.camera.ray(u, v).cast<float>()) : Eigen::Vector3f(nan, nan, nan);
    }
  cloud->is_dense = false;
  return cloud;
}

template <typename PointT>
std::size_t segments(const typename pcl::PointCloud<PointT>::Ptr& cloud) {
  typename pcl::Segmentation<PointT>::Ptr segmentation(new facetloc::PlanarSegmentation<PointT>);
  segmentation->setInputCloud(cloud);
  std::vector<pcl::PointIndices> found;
  segmentation->segment(found);
  return found.size();
}

// A frame of the virtual camera, whose driver comes with the package.
int columnsOfTheVirtualCamera() {
  std::ofstream("room.scene") << "scene = room\nframes = 3\nwidth = 320\n";
  facetloc::OpenNIGrabber grabber("room.scene");
  std::promise<int> columns;
  bool seen = false;
  grabber.registerCallback(std::function<void(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr&)>(
      [&](const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& cloud) {
        if (!std::exchange(seen, true)) columns.set_value(static_cast<int>(cloud->width));
      }));
  grabber.start();
  auto found = columns.get_future();
  const bool in_time = found.wait_for(std::chrono::seconds(60)) == std::future_status::ready;
  grabber.stop();
  return in_time ? found.get() : 0;
}

}  // namespace

int main() {
  const auto source = roomCloud<pcl::PointXYZ>(0.2), target = roomCloud<pcl::PointXYZ>(0.0);
  const std::size_t built_in = segments<pcl::PointXYZ>(target),
                    custom = segments<RadarPoint>(roomCloud<RadarPoint>(0.0));

  const auto planar = pcl::make_shared<facetloc::PlanarRegistration<pcl::PointXYZ>>();
  planar->setMinProbability(0.3);  // an empty room may be any other, but this one leaves no motion free
  const pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>::Ptr registration = planar;
  registration->setInputSource(source);
  registration->setInputTarget(target);
  pcl::PointCloud<pcl::PointXYZ> aligned;
  registration->align(aligned);
  const Eigen::Matrix3d R = registration->getFinalTransformation().topLeftCorner<3, 3>().cast<double>();
  const double turn = facetloc::rotationAngle(R);
  std::printf("segments: %zu built-in, %zu custom; converged %d, turned by %.3f rad of 0.200\n", built_in,
              custom, registration->hasConverged(), turn);
  const int columns = columnsOfTheVirtualCamera();
  std::printf("virtual camera: %d columns\n", columns);
  const bool good = columns == 320 && built_in > 2 && custom == built_in && registration->hasConverged() &&
                    std::abs(turn - 0.2) < 0.02;
  return good ? 0 : 1;
}

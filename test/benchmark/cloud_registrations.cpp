// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_registrations.h"

#include <facetloc/features/segment_frame_estimation.h>
#include <facetloc/registration/ekf_registration.h>
#include <facetloc/registration/planar_registration.h>
#include <facetloc/segmentation/planar_segmentation.h>

namespace facetloc::benchmarks {
namespace {

template <class Registration>
CloudAnswer answerOf(const Registration& registration) {
  CloudAnswer answer;
  answer.has_pose = !registration.getHypotheses().empty();
  answer.T = registration.getFinalPose();
  answer.converged = registration.hasConverged();
  answer.merit = registration.getProbability();
  return answer;
}

CloudAnswer alignPlanar(const Camera& camera, const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setCamera(camera);
  registration.setInputSource(source);
  registration.setInputTarget(target);
  Cloud aligned;
  registration.align(aligned);
  return answerOf(registration);
}

pcl::PointCloud<SegmentFrame>::Ptr framesOf(const Camera& camera, const Cloud::ConstPtr& cloud) {
  PlanarSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setCamera(camera);
  segmentation.setInputCloud(cloud);
  const auto labels = pcl::make_shared<pcl::PointCloud<pcl::Label>>();
  segmentation.segment(*labels);
  SegmentFrameEstimation<pcl::PointXYZ> estimation;
  estimation.setCamera(camera);
  estimation.setInputCloud(cloud);
  estimation.setLabels(labels);
  const auto frames = pcl::make_shared<pcl::PointCloud<SegmentFrame>>();
  estimation.compute(*frames);
  return frames;
}

CloudAnswer alignFrames(const Camera& camera, const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
  EkfRegistration registration;
  registration.setInputSource(framesOf(camera, source));
  registration.setInputTarget(framesOf(camera, target));
  pcl::PointCloud<SegmentFrame> aligned;
  registration.align(aligned);
  return answerOf(registration);
}

}  // namespace

std::vector<CloudRegistration> ours(const Camera& camera) {
  const auto with = [&camera](auto* align) {
    return [camera, align](const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
      return align(camera, source, target);
    };
  };
  return {{"PlanarRegistration", with(alignPlanar)}, {"EkfRegistration", with(alignFrames)}};
}

}  // namespace facetloc::benchmarks

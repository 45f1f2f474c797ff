// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/organized_cloud.h>
#include <facetloc/registration/ranked_registration.h>
#include <facetloc/segmentation/view_builder.h>

namespace facetloc {

/** \brief Registers organized clouds by their planes: the drop-in where code holds a
 * pcl::Registration<PointT, PointT>.
 *
 * Source and target are depth images as organized clouds; they need no overlap guess better than the prior,
 * no normals and no search tree. Indices restrict the source's points. Clouds that are not organized, as
 * after a filter, need a camera with intrinsics (setCamera), at the origin of their coordinates. */
template <typename PointT>
class PlanarRegistration : public RankedRegistration<PointT> {
public:
  using Ptr = pcl::shared_ptr<PlanarRegistration<PointT>>;
  using ConstPtr = pcl::shared_ptr<const PlanarRegistration<PointT>>;
  PlanarRegistration() { this->reg_name_ = "PlanarRegistration"; }

  void setViewParams(const ViewParams& params) { view_params_ = checked(params), this->forgetTarget(); }
  const ViewParams& getViewParams() const { return view_params_; }
  /** \brief Camera of both clouds: a Kinect-class one unless set. Without intrinsics these are
   * recovered from the points. */
  void setCamera(const Camera& camera) { camera_ = camera, this->forgetTarget(); }
  const Camera& getCamera() const { return camera_; }
  /** \brief Width that clouds are subsampled to before segmentation [px]; 0 = full size. 320 unless set.
   * Larger clouds that have no sure answer so are registered once more at full size. */
  void setWorkingWidth(int width) { working_width_ = width, this->forgetTarget(); }

protected:
  View makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                std::string& why_empty) override;
  std::optional<View> makeFinerView(const pcl::PointCloud<PointT>& cloud,
                                    const pcl::Indices* indices) override;

private:
  ViewParams view_params_;
  Camera camera_;
  int working_width_ = kWorkingWidth;
};

}  // namespace facetloc

#include <facetloc/registration/impl/planar_registration.hpp>

extern template class facetloc::PlanarRegistration<pcl::PointXYZ>;
extern template class facetloc::PlanarRegistration<pcl::PointXYZI>;
extern template class facetloc::PlanarRegistration<pcl::PointXYZRGB>;
extern template class facetloc::PlanarRegistration<pcl::PointXYZRGBA>;

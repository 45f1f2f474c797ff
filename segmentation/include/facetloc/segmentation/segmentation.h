// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/pcl_base.h>

#include <string>
#include <vector>

#if __has_include(<pcl/segmentation/segmentation.h>)
#include <pcl/segmentation/segmentation.h>
#else
namespace pcl {

/** \brief The abstract base of segmentations. PCL has no class of this name; each of its own derives from
 * PCLBase.
 *
 * Input cloud and indices come from PCLBase. Outputs are cleared first; bad data leaves them empty and the
 * reason in getReason(), never an exception or the answer of the call before. */
template <typename PointT>
class Segmentation : public PCLBase<PointT> {
public:
  using Ptr = shared_ptr<Segmentation<PointT>>;
  using ConstPtr = shared_ptr<const Segmentation<PointT>>;

  ~Segmentation() override = default;

  /** \brief The points of each segment, as indices into the input cloud. */
  virtual void segment(std::vector<PointIndices>& segments) = 0;
  /** \brief The same with the model of each segment; planes as (n_x, n_y, n_z, d), n . p + d = 0. */
  virtual void segment(std::vector<PointIndices>& segments, std::vector<ModelCoefficients>& coefficients) = 0;

  /** \brief Why the last output is empty; empty if all went well. */
  const std::string& getReason() const { return status_; }
  virtual std::string getClassName() const = 0;

protected:
  std::string status_;
};

}  // namespace pcl
#endif

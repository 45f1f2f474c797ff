// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/planar_segmentation.h>

template class facetloc::PlanarSegmentation<pcl::PointXYZ>;
template class facetloc::PlanarSegmentation<pcl::PointXYZI>;
template class facetloc::PlanarSegmentation<pcl::PointXYZRGB>;
template class facetloc::PlanarSegmentation<pcl::PointXYZRGBA>;

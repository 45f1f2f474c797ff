// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/planar_registration.h>

template class facetloc::PlanarRegistration<pcl::PointXYZ>;
template class facetloc::PlanarRegistration<pcl::PointXYZI>;
template class facetloc::PlanarRegistration<pcl::PointXYZRGB>;
template class facetloc::PlanarRegistration<pcl::PointXYZRGBA>;

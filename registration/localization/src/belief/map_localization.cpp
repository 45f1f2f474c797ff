// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/localization/map_localization.h>

template class facetloc::MapLocalization<pcl::PointXYZ>;
template class facetloc::MapLocalization<pcl::PointXYZI>;
template class facetloc::MapLocalization<pcl::PointXYZRGB>;
template class facetloc::MapLocalization<pcl::PointXYZRGBA>;

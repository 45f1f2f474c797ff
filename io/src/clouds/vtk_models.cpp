// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/vtk_models.h"

#include "base/module.h"

#include <facetloc/io/error.h>

namespace facetloc {

pcl::PolygonMesh readByVtk(const std::filesystem::path& path) {
  pcl::PolygonMesh mesh;
#ifdef FACETLOC_VTK_MODULE
  std::string problem;
  const auto read = internal::loadFunction<VtkModelReader>(FACETLOC_VTK_MODULE, "facetlocReadByVtk", problem);
  if (!read)
    throw IoError(path.string(),
                  "is read by VTK, whose part of facetloc cannot be loaded: install the package "
                  "libfacetloc-vtk, or convert the file to .ply (" +
                      problem + ")");
  read(path, mesh);
#else
  facetlocReadByVtk(path, mesh);
#endif
  return mesh;
}

}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a scan or mesh, of the kind that the first one names.
#include "fuzz_file.h"

#include <facetloc/io/cloud_file.h>
#include <facetloc/io/error.h>
#include <facetloc/mapping/mesh_surface.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  const char* names[] = {"a.ply", "a.obj", "a.stl", "a.pcd", "a.off"};
  const auto path = folder.put(names[(data[0] - '0') % std::size(names)], fuzz::asText(data + 1, size - 1));
  pcl::PolygonMesh mesh;
  if (!fuzz::accepts<IoError>([&] { mesh = readModel(path); })) return 0;
  fuzz::require(mesh.cloud.width > 0 && mesh.cloud.data.size() >= mesh.cloud.point_step, "no points");
  fuzz::accepts<std::invalid_argument>([&] {
    const MeshSurface surface(mesh);
    surface.render({4, 3, 4, 4, 1.5, 1}, Eigen::Isometry3d::Identity());
  });
  return 0;
}

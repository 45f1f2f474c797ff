// SPDX-License-Identifier: BSD-3-Clause
//
// A map of a recording that has poses: what facetloc_map build does at its core.
//
//   build_map RECORDING MAP.flmap
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/segmentation/view_builder.h>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: build_map RECORDING MAP.flmap\n";
    return 2;
  }
  const auto recording = facetloc::DepthSequence::open(argv[1]);
  const facetloc::Camera camera = recording.camera() ? recording.camera()->camera : facetloc::Camera();
  facetloc::ViewBuilder builder(camera);
  facetloc::MapBuilder rule;  // which images become local models
  auto map = facetloc::MapDatabase::create(argv[2], true);
  map.setCamera(camera);
  for (std::size_t i = 0; i < recording.frames().size(); ++i) {
    facetloc::LocalModel model;
    model.name = recording.frames()[i].name;
    model.stamp = recording.frames()[i].stamp;
    model.T_w_m = recording.groundTruth().at(model.stamp);
    if (!model.T_w_m || !rule.accept(*model.T_w_m)) continue;
    model.view = builder.build(recording.load(i, 320));
    map.add(model);  // one transaction: from here on it is safe
  }
  std::cout << map.modelNames().size() << " local models in " << argv[2] << "\n";
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}

// SPDX-License-Identifier: BSD-3-Clause
//
// A map of a recording, with its poses or without: the same map that facetloc_map build makes.
//
//   build_map RECORDING MAP.flmap
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/mapping/map_making.h>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: build_map RECORDING MAP.flmap\n";
    return 2;
  }
  const auto recording = facetloc::DepthSequence::open(argv[1]);
  facetloc::MapMaking making(recording.camera() ? recording.camera()->camera : facetloc::Camera());
  for (std::size_t i = 0; i < recording.frames().size(); ++i) {
    const facetloc::FrameFile& frame = recording.frames()[i];
    making.add({frame.name, frame.stamp, [&recording, i] { return recording.load(i, 320); },
                recording.groundTruth().at(frame.stamp)});
  }
  const facetloc::Map map = making.finish();
  if (map.models.empty()) throw std::runtime_error(making.findings().problem);
  facetloc::writeMap(argv[2], map, facetloc::placeIndexOf(map));
  std::cout << map.models.size() << " local models in " << argv[2] << "\n";
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}

// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <facetloc/simulation/simulated_place.h>

#include <stdexcept>

namespace facetloc {

const std::vector<std::string>& simulatedPlaceNames() {
  static const std::vector<std::string> names = {"office", "home",  "hall",    "corridor", "hotel",
                                                 "boards", "doors", "passage", "box"};
  return names;
}

SimulatedPlace simulatedPlace(const std::string& name, std::uint64_t seed) {
  if (name == "office") return officeFloor(seed);
  if (name == "home") return homeFloor(seed);
  if (name == "hall") return hallFloor(seed);
  if (name == "corridor") return bareCorridor(seed);
  if (name == "hotel") return equalRooms(seed);
  if (name == "boards") return bareFloor(seed);
  if (name == "doors") return equalDoors(seed, 16);
  if (name == "passage") return equalDoors(seed, 33);
  if (name == "box") return symmetricBox(seed);
  throw std::invalid_argument("there is no simulated place named '" + name + "'");
}

}  // namespace facetloc

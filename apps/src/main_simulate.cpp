// SPDX-License-Identifier: BSD-3-Clause
#include "tools/simulate_app.h"

int main(int argc, char** argv) {
  facetloc::SimulateApp app;
  return facetloc::runApp(app, argc, argv);
}

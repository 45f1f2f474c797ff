// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_app.h"

int main(int argc, char** argv) {
  facetloc::LiveApp app;
  return facetloc::runApp(app, argc, argv);
}

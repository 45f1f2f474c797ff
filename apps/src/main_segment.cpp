// SPDX-License-Identifier: BSD-3-Clause
#include "tools/segment_app.h"

int main(int argc, char** argv) {
  facetloc::SegmentApp app;
  return facetloc::runApp(app, argc, argv);
}

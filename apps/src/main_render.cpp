// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render_app.h"

int main(int argc, char** argv) {
  facetloc::RenderApp app;
  return facetloc::runApp(app, argc, argv);
}

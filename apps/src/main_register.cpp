// SPDX-License-Identifier: BSD-3-Clause
#include "tools/register_app.h"

int main(int argc, char** argv) {
  facetloc::RegisterApp app;
  return facetloc::runApp(app, argc, argv);
}

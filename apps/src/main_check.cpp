// SPDX-License-Identifier: BSD-3-Clause
#include "tools/check_app.h"

int main(int argc, char** argv) {
  facetloc::CheckApp app;
  return facetloc::runApp(app, argc, argv);
}

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/localize_app.h"

int main(int argc, char** argv) {
  facetloc::LocalizeApp app;
  return facetloc::runApp(app, argc, argv);
}

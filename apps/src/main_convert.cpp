// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert_app.h"

int main(int argc, char** argv) {
  facetloc::ConvertApp app;
  return facetloc::runApp(app, argc, argv);
}

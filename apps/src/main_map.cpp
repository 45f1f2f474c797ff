// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_apps.h"

int main(int argc, char** argv) {
  return facetloc::runMapTool({argv + 1, argv + argc}, facetloc::standardConsole());
}

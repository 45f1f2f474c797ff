// SPDX-License-Identifier: BSD-3-Clause
#include "cli/tools.h"

int main(int argc, char** argv) {
  return facetloc::mapProgram().run({argv + 1, argv + argc}, facetloc::standardConsole());
}

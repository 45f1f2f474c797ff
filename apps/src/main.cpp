// SPDX-License-Identifier: BSD-3-Clause
#include "cli/tools.h"

/** One of the tools, as CMakeLists.txt defines. */
int main(int argc, char** argv) { return facetloc::runApp(*facetloc::FACETLOC_TOOL(), argc, argv); }

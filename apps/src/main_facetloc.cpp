// SPDX-License-Identifier: BSD-3-Clause
#include "cli/tools.h"

int main(int argc, char** argv) {
  std::error_code unknown;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", unknown);
  return facetloc::frontProgram(self.parent_path()).run({argv + 1, argv + argc}, facetloc::standardConsole());
}

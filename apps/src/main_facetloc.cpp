// SPDX-License-Identifier: BSD-3-Clause
#include "tools/front.h"

int main(int argc, char** argv) {
  std::error_code unknown;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", unknown);
  return facetloc::runFront({argv + 1, argv + argc}, facetloc::standardConsole(), self.parent_path());
}

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace facetloc {

/** \brief A file or folder could not be read or written; what() names it and the cause. */
class IoError : public std::runtime_error {
public:
  IoError(const std::string& path, const std::string& cause) : std::runtime_error(path + ": " + cause) {}
};

}  // namespace facetloc

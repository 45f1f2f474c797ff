// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace facetloc {

/** \brief What an option of version 0.1 is called now; empty if it never was one or is gone.
 * \param name with underscores, without dashes in front */
std::string newNameOf(const std::string& name);

}  // namespace facetloc

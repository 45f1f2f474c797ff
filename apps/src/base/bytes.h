// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace facetloc {

/** \brief A value as bytes, every number to the last bit, for another process of the same program on a
 * machine of the same kind: no format for files. For the types that bytes.cpp lists at its end. */
template <class T>
std::string toBytes(const T& value);
/** \brief The value again. Throws std::runtime_error if the bytes are not those of such a value. */
template <class T>
T fromBytes(const std::string& bytes);

}  // namespace facetloc

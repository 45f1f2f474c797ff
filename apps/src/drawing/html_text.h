// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace Json {
class Value;
}

namespace facetloc {

/** \brief Text with &, <, > and quotes as HTML wants them; control characters become spaces. */
std::string htmlEscaped(std::string_view text);
/** \brief Base64 (RFC 4648) with padding, on one line. */
std::string base64(std::string_view bytes);
/** \brief JSON for a script element: no tag begins in it. Numbers have six digits. */
std::string scriptText(const Json::Value& value);

}  // namespace facetloc

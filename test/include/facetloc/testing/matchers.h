// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <type_traits>

namespace facetloc::test {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::AnyOf;
using testing::Contains;
using testing::ContainsRegex;
using testing::DoubleNear;
using testing::Each;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Key;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;
using testing::UnorderedElementsAre;

/** \brief Matches a text that has each of these words; a matcher in place of words must match. */
template <class... Words>
auto HasAll(const Words&... words) {
  const auto matcher = [](const auto& word) {
    if constexpr (std::is_convertible_v<decltype(word), std::string>)
      return HasSubstr(std::string(word));
    else
      return word;
  };
  return AllOf(matcher(words)...);
}

/** \brief The message of this exception of a call; empty without one. Any other exception fails the test. */
template <class Exception, class Call>
std::string messageOf(const Call& call) {
  try {
    call();
  } catch (const Exception& e) {
    return e.what();
  }
  return {};
}

}  // namespace facetloc::test

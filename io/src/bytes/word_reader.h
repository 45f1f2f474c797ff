// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"

#include <algorithm>
#include <string_view>

namespace facetloc {

/** \brief The words of a text, one after the other. */
class WordReader {
public:
  /** \param text must outlive the object */
  explicit WordReader(std::string_view text) : rest_(text) {}
  /** \brief The next word; empty at the end. */
  std::string_view next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(text::kBlank), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(text::kBlank));
    rest_.remove_prefix(word.size());
    return word;
  }
  std::string_view rest() const { return rest_; }

private:
  std::string_view rest_;
};

}  // namespace facetloc

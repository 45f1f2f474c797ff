// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace facetloc {

/** \brief Text with &, <, > and quotes as HTML wants them; control characters become spaces. */
std::string htmlEscaped(std::string_view text);
/** \brief Base64 (RFC 4648) with padding, on one line. */
std::string base64(std::string_view bytes);

/** \brief A page in one file: its style and pictures are inside, it has no scripts and no links. All texts
 * are plain and escaped here. */
class HtmlPage {
public:
  explicit HtmlPage(const std::string& title);
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /** \brief The first row is the header. A row with nothing but its first cell is the title of those below
   * it. */
  void table(const std::string& caption, const TextTable& table);
  /** \brief A PNG file, embedded. Throws IoError if it cannot be read. */
  void picture(const std::filesystem::path& png, const std::string& caption);
  std::string str() const;

private:
  std::string title_;
  std::string body_;
};

}  // namespace facetloc

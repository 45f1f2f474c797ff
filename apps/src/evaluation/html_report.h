// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/text.h"
#include "drawing/html_text.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief A page in one file: its style, pictures and the script that draws its charts are inside. All texts
 * are plain and escaped here. */
class HtmlPage {
public:
  explicit HtmlPage(std::string title) : title_(std::move(title)) {}
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /** \brief A link to a file beside the page. */
  void link(const std::string& file, const std::string& text);
  /** \brief The first row is the header. A row with nothing but its first cell is the title of those below
   * it. */
  void table(const std::string& caption, const TextTable& table);
  /** \brief A PNG file, embedded. Throws IoError if it cannot be read. */
  void picture(const std::filesystem::path& png, const std::string& caption);
  /** \brief Puts the following, up to end(), into an element with a class, or folds it below a title until it
   * is opened. */
  void begin(const std::string& css_class);
  void beginFolded(const std::string& title);
  void end();
  /** \brief Charts, which the page draws, once in a page. Instead of them says that facetloc was built
   * without Chart.js. \param data chartData() */
  void charts(const Json::Value& data);
  /** \brief Elements that are HTML already, such as svgFloorMap(). */
  void insert(const std::string& html) { body_ += html; }
  std::string str() const;

private:
  std::string title_;
  std::string body_;
  std::string scripts_;            // elements
  std::vector<std::string> open_;  // elements
};

}  // namespace facetloc

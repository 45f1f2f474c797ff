// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/text.h"
#include "drawing/html_text.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <json/value.h>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Numbers of a chart. */
inline Json::Value chartRow(std::initializer_list<double> values) {
  Json::Value cells(Json::arrayValue);
  for (const double value : values) cells.append(value);
  return cells;
}

/** \brief A page in one file: its style, pictures and the script that draws its plan and charts are inside.
 * All texts are plain and escaped here. */
class HtmlPage {
public:
  explicit HtmlPage(std::string title) : title_(std::move(title)) {}
  void heading(const std::string& text) { body_ += element("h2", text) + "\n"; }
  void paragraph(const std::string& text) { body_ += element("p", text) + "\n"; }
  /** \brief A link to a file beside the page. */
  void link(const std::string& file, const std::string& text) {
    body_ += "<p>" + element("a", text, fmt::format(" href=\"{}\"", htmlEscaped(file))) + "</p>\n";
  }

  /** \brief The first row is the header. A row with nothing but its first cell is the title of those below
   * it. */
  void table(const std::string& caption, const TextTable& table) {
    body_ += fmt::format("<div class=\"wide\"><table{}>{}\n<thead><tr>",
                         table.wordsLast() ? " class=\"words\"" : "", element("caption", caption));
    for (const std::string& cell : table.rows().front()) body_ += element("th", cell);
    body_ += "</tr></thead>\n<tbody>\n";
    for (std::size_t i = 1; i < table.rows().size(); ++i) body_ += bodyRow(table.rows()[i]);
    body_ += "</tbody></table></div>\n";
  }

  /** \brief A PNG file, embedded. Throws IoError if it cannot be read. */
  void picture(const std::filesystem::path& png, const std::string& caption) {
    std::ifstream in(png, std::ios::binary);
    if (!in) throw IoError(png.string(), "cannot be read");
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    body_ += fmt::format("<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"/>{}</figure>\n",
                         htmlEscaped(caption), base64(bytes), element("figcaption", caption));
  }

  /** \brief Puts the following, up to end(), into an element with a class, or folds it below a title until it
   * is opened. */
  void begin(const std::string& css_class) {
    body_ += fmt::format("<div class=\"{}\">\n", htmlEscaped(css_class));
    open_.push_back("div");
  }

  void beginFolded(const std::string& title) {
    body_ += "<details>" + element("summary", title) + "\n";
    open_.push_back("details");
  }

  void end() {
    body_ += "</" + open_.back() + ">\n";
    open_.pop_back();
  }

  /** \brief A plan or charts, which the page's script draws, each once in a page. Instead of charts says if
   * facetloc was built without Chart.js. \param id "plan" with planData(), "charts" with chartData() */
  void drawing(const std::string& id, const Json::Value& data) {
    if (id == "charts" && !hasPageFile("chart.js"))
      return paragraph("Charts are missing: facetloc was built without Chart.js, which draws them (Debian's "
                       "libjs-chart.js).");
    body_ += fmt::format("<div id=\"{}\"><noscript>JavaScript draws this.</noscript></div>\n", id);
    drawings_[id] = data;
  }

  /** \brief Elements that are HTML already. */
  void insert(const std::string& html) { body_ += html; }
  std::string str() const {
    return filledPage("report.html", {{"TITLE", htmlEscaped(title_)},
                                      {"STYLE", pageFile("report.css")},
                                      {"BODY", body_},
                                      {"SCRIPTS", scripts()}});
  }

private:
  static std::string element(const std::string& tag, const std::string& text,
                             const std::string& attributes = "") {
    return fmt::format("<{0}{1}>{2}</{0}>", tag, attributes, htmlEscaped(text));
  }

  static bool isTitle(const std::vector<std::string>& row) {
    return row.size() > 1 && std::all_of(row.begin() + 1, row.end(), [](const auto& c) { return c.empty(); });
  }

  /** Text tables indent the lines of a group by spaces. */
  static std::string firstCell(const std::string& text) {
    const std::size_t indent = std::min(text.find_first_not_of(' '), text.size());
    return element("td", text.substr(indent), indent > 0 ? " class=\"part\"" : "");
  }

  static std::string bodyRow(const std::vector<std::string>& row) {
    if (isTitle(row))
      return fmt::format("<tr>{}</tr>\n", element("th", row[0], fmt::format(R"( colspan="{}")", row.size())));
    std::string html = "<tr>" + firstCell(row[0]);
    for (std::size_t c = 1; c < row.size(); ++c) html += element("td", row[c]);
    return html + "</tr>\n";
  }

  std::string scripts() const {
    if (drawings_.isNull()) return {};
    const bool has_charts = drawings_.isMember("charts");
    return fmt::format("<script id=\"data\" type=\"application/json\">{}</script>\n<script>\n{}{}</script>\n",
                       scriptText(drawings_),
                       has_charts ? pageFile("chart_license.js") + pageFile("chart.js") + "\n" : "",
                       pageFile("report.js"));
  }

  std::string title_;
  std::string body_;
  Json::Value drawings_;           // data by the id of the element that shows them
  std::vector<std::string> open_;  // elements
};

}  // namespace facetloc

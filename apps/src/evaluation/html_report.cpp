// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/html_report.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <fstream>
#include <iterator>

namespace facetloc {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;max-width:1200px;margin:2em auto;padding:0 1em;color:#222}"
    "h1{font-size:1.6em}h2{font-size:1.25em;margin-top:2em;border-bottom:1px solid #ccc}"
    ".wide{overflow-x:auto;margin:1em 0}"
    "table{border-collapse:collapse;font-size:14px}"
    "caption{text-align:left;font-weight:600;padding:.3em 0}"
    "th,td{padding:.15em .7em;text-align:right;border-bottom:1px solid #e4e4e4}"
    "th:first-child,td:first-child,.words td:last-child,.words th:last-child{text-align:left}"
    "thead th{border-bottom:2px solid #999;vertical-align:bottom}"
    "tbody th{font-weight:600;padding-top:.6em}"
    "td.part{padding-left:1.8em}"
    "figure{margin:1.5em 0}figcaption{font-size:14px;color:#555}"
    "img{max-width:100%;border:1px solid #ddd}";

std::string element(const std::string& tag, const std::string& text, const std::string& attributes = "") {
  return fmt::format("<{0}{1}>{2}</{0}>", tag, attributes, htmlEscaped(text));
}

bool isTitle(const std::vector<std::string>& row) {
  return row.size() > 1 && std::all_of(row.begin() + 1, row.end(), [](const auto& c) { return c.empty(); });
}

/** Text tables indent the lines of a group by spaces. */
std::string firstCell(const std::string& text) {
  const std::size_t indent = std::min(text.find_first_not_of(' '), text.size());
  return element("td", text.substr(indent), indent > 0 ? " class=\"part\"" : "");
}

std::string bodyRow(const std::vector<std::string>& row) {
  if (isTitle(row))
    return fmt::format("<tr>{}</tr>\n", element("th", row[0], fmt::format(R"( colspan="{}")", row.size())));
  std::string html = "<tr>" + firstCell(row[0]);
  for (std::size_t c = 1; c < row.size(); ++c) html += element("td", row[c]);
  return html + "</tr>\n";
}

}  // namespace

std::string htmlEscaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
    case '&':
      html += "&amp;";
      break;
    case '<':
      html += "&lt;";
      break;
    case '>':
      html += "&gt;";
      break;
    case '"':
      html += "&quot;";
      break;
    default:
      html += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return html;
}

std::string base64(std::string_view bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

HtmlPage::HtmlPage(const std::string& title) : title_(title) { body_ = element("h1", title) + "\n"; }

void HtmlPage::heading(const std::string& text) { body_ += element("h2", text) + "\n"; }

void HtmlPage::paragraph(const std::string& text) { body_ += element("p", text) + "\n"; }

void HtmlPage::table(const std::string& caption, const TextTable& table) {
  body_ += fmt::format("<div class=\"wide\"><table{}>{}\n<thead><tr>",
                       table.wordsLast() ? " class=\"words\"" : "", element("caption", caption));
  for (const std::string& cell : table.rows().front()) body_ += element("th", cell);
  body_ += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 1; i < table.rows().size(); ++i) body_ += bodyRow(table.rows()[i]);
  body_ += "</tbody></table></div>\n";
}

void HtmlPage::picture(const std::filesystem::path& png, const std::string& caption) {
  std::ifstream in(png, std::ios::binary);
  if (!in) throw IoError(png.string(), "cannot be read");
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  body_ += fmt::format("<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"/>{}</figure>\n",
                       htmlEscaped(caption), base64(bytes), element("figcaption", caption));
}

std::string HtmlPage::str() const {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>{}<style>{}</style></head>\n"
      "<body>\n{}</body></html>\n",
      element("title", title_), kStyle, body_);
}

}  // namespace facetloc

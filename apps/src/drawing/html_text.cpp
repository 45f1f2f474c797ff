// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/html_text.h"

#include <algorithm>
#include <cstdint>
#include <json/writer.h>

namespace facetloc {

std::string htmlEscaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    const char* entity = c == '&'   ? "&amp;"
                         : c == '<' ? "&lt;"
                         : c == '>' ? "&gt;"
                         : c == '"' ? "&quot;"
                                    : nullptr;
    if (entity)
      html += entity;
    else
      html += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
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

std::string scriptText(const Json::Value& value) {
  Json::StreamWriterBuilder builder;
  builder["indentation"] = "";
  builder["precision"] = 6;
  std::string text;
  for (const char c : Json::writeString(builder, value)) c == '<' ? text += "\\u003c" : text += c;
  return text;
}

}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace facetloc::test {

/** \brief Writes the records of an .oni file, as OpenNI does. */
class OniWriter {
public:
  explicit OniWriter(bool old = false) : old_(old) {
    bytes_ = "NI10";
    bytes_ += {1, 0, static_cast<char>(old ? 0 : 1), 0};
    number(std::uint32_t(old ? 5 : 0)), number(std::uint64_t(0)), number(std::uint32_t(1));
  }
  OniWriter& node(std::uint32_t id, std::uint32_t type, const std::string& codec) {
    std::string fields = text("node " + std::to_string(id)) + packed(type) + codec;
    fields += packed(std::uint32_t(1)) + packed(std::uint64_t(0)) + packed(std::uint64_t(0));
    return record(old_ ? 0x0C : 0x0D, id, fields + (old_ ? "" : packed(std::uint64_t(0))));
  }
  OniWriter& property(std::uint32_t id, const std::string& name, std::uint64_t value) {
    return record(0x03, id, text(name) + packed(std::uint32_t(8)) + packed(value));
  }
  OniWriter& property(std::uint32_t id, const std::string& name, const std::string& data) {
    return record(0x06, id, text(name) + packed(static_cast<std::uint32_t>(data.size())) + data);
  }
  OniWriter& mode(std::uint32_t id, std::uint32_t w, std::uint32_t h) {
    return property(id, "xnMapOutputMode", packed(w) + packed(h) + packed(std::uint32_t(30)));
  }
  OniWriter& view(std::uint32_t id, double horizontal, double vertical) {
    return property(id, "xnFOV", packed(horizontal) + packed(vertical));
  }
  OniWriter& frame(std::uint32_t id, std::uint64_t stamp, const std::string& data) {
    return record(0x0A, id, packed(stamp) + packed(std::uint32_t(1)), data);
  }
  std::string end() { return record(0x0B, 0, "").bytes_; }
  std::string bytes() const { return bytes_; }

  template <typename T>
  static std::string packed(T value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }

private:
  static std::string text(const std::string& s) {
    return packed(static_cast<std::uint32_t>(s.size() + 1)) + s + '\0';
  }
  template <typename T>
  void number(T value) {
    bytes_ += packed(value);
  }
  OniWriter& record(std::uint32_t type, std::uint32_t id, const std::string& fields,
                    const std::string& data = {}) {
    const std::uint32_t header = old_ ? 24 : 28;
    number(std::uint32_t(0x0052494E)), number(type), number(id);
    number(static_cast<std::uint32_t>(header + fields.size())),
        number(static_cast<std::uint32_t>(data.size()));
    old_ ? number(std::uint32_t(0)) : number(std::uint64_t(0));
    bytes_ += fields + data;
    return *this;
  }

  bool old_;
  std::string bytes_;
};

}  // namespace facetloc::test

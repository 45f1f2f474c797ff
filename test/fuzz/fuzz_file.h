// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "../include/facetloc/testing/own_folder.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string_view>

/** \file
 * The common part of the fuzz targets: input as a file, and answers that are no finding. */

namespace facetloc::fuzz {

inline std::string_view asText(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/** \brief A folder for files of input, gone when the program ends. It is where $TMPDIR says, or else in
 * memory. */
class Folder : public test::OwnFolder {
public:
  Folder() : OwnFolder(std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/dev/shm") {}
  /** \brief Removes the files of an earlier input, so that they cannot change the result of the next one. */
  void clear() const {
    for (const auto& entry : std::filesystem::directory_iterator(path()))
      std::filesystem::remove_all(entry.path());
  }
  std::filesystem::path put(const char* name, std::string_view bytes) const {
    const std::filesystem::path file = path() / name;
    std::FILE* out = std::fopen(file.c_str(), "wb");
    if (!out || std::fwrite(bytes.data(), 1, bytes.size(), out) != bytes.size() || std::fclose(out) != 0)
      throw std::runtime_error(file.string() + ": cannot be written");
    return file;
  }
};

/** \brief Calls a function that may refuse its input with one of these exceptions; any other is a finding, as
 * it ends the program. \return false if it was refused. */
template <class... Refusals, class Call>
bool accepts(const Call& call) {
  try {
    call();
    return true;
  } catch (const std::exception& e) {
    if (!(dynamic_cast<const Refusals*>(&e) || ...)) throw;
    return false;
  }
}

/** \brief A finding unless the condition holds. */
inline void require(bool condition, const char* fault) {
  if (condition) return;
  std::fprintf(stderr, "%s\n", fault);
  std::abort();
}

}  // namespace facetloc::fuzz

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

/** \file
 * The common part of the fuzz targets: input as a file, and answers that are no finding. */

namespace facetloc::fuzz {

inline std::string_view asText(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/** \brief A folder for files of input, gone when the program ends. It is where $TMPDIR says, or else in
 * memory. */
class Folder {
public:
  Folder() {
    const char* set = std::getenv("TMPDIR");
    std::string name = std::string(set ? set : "/dev/shm") + "/facetloc_fuzz_XXXXXX";
    if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  const std::filesystem::path& path() const { return path_; }
  /** \brief Removes the files of an earlier input, so that they cannot change the result of the next one. */
  void clear() const {
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      std::filesystem::remove_all(entry.path());
  }
  std::filesystem::path put(const char* name, std::string_view bytes) const {
    const std::filesystem::path file = path_ / name;
    std::FILE* out = std::fopen(file.c_str(), "wb");
    if (!out || std::fwrite(bytes.data(), 1, bytes.size(), out) != bytes.size() || std::fclose(out) != 0)
      throw std::runtime_error(file.string() + ": cannot be written");
    return file;
  }

private:
  std::filesystem::path path_;
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

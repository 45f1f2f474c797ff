// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/error.h>
#include <facetloc/testing/matchers.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace facetloc::test {

/** \brief A folder of its own for a test, removed with all that is in it. */
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "facetloc_XXXXXX").string();
    if (!mkdtemp(name.data())) ADD_FAILURE() << "no temporary folder";
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  /** \brief The number of files and folders directly in it. */
  int count() const {
    return static_cast<int>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

private:
  std::filesystem::path path_;
};

/** \brief Tests that each have a folder. */
class InAFolder : public testing::Test {
protected:
  TemporaryFolder folder_;
};

inline std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::filesystem::path putBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/** \brief The message of the IoError of a call; empty without one. */
template <typename Call>
std::string ioErrorOf(const Call& call) {
  return messageOf<IoError>(call);
}

}  // namespace facetloc::test

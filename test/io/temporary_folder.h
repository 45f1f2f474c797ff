// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/error.h>
#include <facetloc/testing/matchers.h>
#include <facetloc/testing/own_folder.h>

#include <fstream>
#include <iterator>

namespace facetloc::test {

/** \brief A folder of its own for a test. */
class TemporaryFolder : public OwnFolder {
public:
  std::filesystem::path operator/(const std::string& name) const { return path() / name; }
  /** \brief The number of files and folders directly in it. */
  int count() const {
    return static_cast<int>(std::distance(std::filesystem::directory_iterator(path()), {}));
  }
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

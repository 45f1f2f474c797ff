// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/io/segment_file.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facetloc {
namespace {

using test::ioErrorOf;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(SegmentFile, AFullDiskIsToldWithTheFileThatIsWritten) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.segments.pcd";
  const auto segments = test::ExampleMap().map(1).models[0].view.segments;
  for (const auto& written : {segments, std::vector<Segment>()}) {
    std::filesystem::create_symlink("/dev/full", path.string() + ".tmp");
    EXPECT_THAT(ioErrorOf([&] { writeSegments(path, written); }),
                AllOf(StartsWith(path.string() + ": cannot be written: "), HasSubstr("No space left")));
    EXPECT_EQ(folder.count(), 0);
  }
}

}  // namespace
}  // namespace facetloc

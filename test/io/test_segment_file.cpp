// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/io/segment_file.h>
#include <facetloc/testing/full_disk.h>

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
    const test::FullDisk full(100);
    EXPECT_THAT(ioErrorOf([&] { writeSegments(path, written); }),
                StartsWith(path.string() + ": " + test::FullDisk::kWords));
    EXPECT_EQ(folder.count(), 0);
  }
}

}  // namespace
}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace facetloc {
namespace {

using test::bytesOf;
using test::ioErrorOf;
using test::putBytes;
using test::TemporaryFolder;
using testing::HasSubstr;

TEST(AtomicFile, WritesTheWholeFileAndNothingElse) {
  const TemporaryFolder folder;
  writeTextAtomically(folder / "a.txt", [](std::ostream& out) { out << "hello\n" << 1.5 << 12345; });
  EXPECT_EQ(bytesOf(folder / "a.txt"), "hello\n1.512345");
  EXPECT_EQ(folder.count(), 1);
}

TEST(AtomicFile, ReplacesAnOlderFile) {
  const TemporaryFolder folder;
  putBytes(folder / "a.txt", "a longer, older text");
  writeTextAtomically(folder / "a.txt", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(bytesOf(folder / "a.txt"), "new");
}

TEST(AtomicFile, AFailedWriterLeavesTheOlderFileAndNoTemporaryOne) {
  const TemporaryFolder folder;
  putBytes(folder / "a.txt", "old");
  const auto fail = [](std::ostream& out) {
    out << "half";
    throw std::runtime_error("in the middle");
  };
  EXPECT_THROW(writeTextAtomically(folder / "a.txt", fail), std::runtime_error);
  EXPECT_EQ(bytesOf(folder / "a.txt"), "old");
  EXPECT_EQ(folder.count(), 1);
}

TEST(AtomicFile, ALinkStaysOneAndWhatItLeadsToIsWritten) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "elsewhere");
  putBytes(folder / "elsewhere/there", "old");
  std::filesystem::create_symlink("elsewhere/there", folder / "a");
  std::filesystem::create_symlink("elsewhere/not_yet", folder / "b");
  for (const char* link : {"a", "b"}) {
    writeTextAtomically(folder / link, [](std::ostream& out) { out << "new"; });
    EXPECT_TRUE(std::filesystem::is_symlink(folder / link)) << link;
    EXPECT_EQ(bytesOf(folder / link), "new") << link;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "elsewhere/not_yet"));
}

TEST(AtomicFile, ANameThatIsTooLongIsAnErrorLikeAnyOther) {
  const TemporaryFolder folder;
  const auto path = folder / std::string(300, 'x');
  EXPECT_THAT(ioErrorOf([&] { createFolders(path); }), HasSubstr("xxx"));
  EXPECT_THAT(ioErrorOf([&] { writeTextAtomically(path, [](std::ostream&) {}); }), HasSubstr("xxx"));
}

TEST(AtomicFile, MissingFolderIsAnError) {
  const TemporaryFolder folder;
  const auto message = ioErrorOf([&] { writeTextAtomically(folder / "none/a.txt", [](std::ostream&) {}); });
  EXPECT_THAT(message, HasSubstr("none"));
  EXPECT_THAT(message, HasSubstr("does not exist"));
}

TEST(AtomicFile, AFolderInTheWayIsAnError) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "a.txt");
  EXPECT_THAT(ioErrorOf([&] { writeTextAtomically(folder / "a.txt", [](std::ostream&) {}); }),
              HasSubstr("a.txt"));
}

TEST(AtomicFile, NeverReplacesADevice) {
  if (!std::filesystem::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full";
  EXPECT_NE(ioErrorOf([] { writeTextAtomically("/dev/full", [](std::ostream&) {}); }), "");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, AFullDiskIsAnError) {
  if (!std::filesystem::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const TemporaryFolder folder;
  putBytes(folder / "a.txt", "old");
  std::filesystem::create_symlink("/dev/full", folder / "a.txt.tmp");
  const auto message =
      ioErrorOf([&] { writeTextAtomically(folder / "a.txt", [](std::ostream& out) { out << "new"; }); });
  EXPECT_THAT(message, HasSubstr("No space left"));
  EXPECT_EQ(bytesOf(folder / "a.txt"), "old");
  EXPECT_EQ(folder.count(), 1);
}

TEST(AtomicFile, AStreamThatWentBadIsAnError) {
  const TemporaryFolder folder;
  const auto spoil = [](std::ostream& out) { out.setstate(std::ios::failbit); };
  EXPECT_NE(ioErrorOf([&] { writeTextAtomically(folder / "a.txt", spoil); }), "");
  EXPECT_EQ(folder.count(), 0);
}

}  // namespace
}  // namespace facetloc

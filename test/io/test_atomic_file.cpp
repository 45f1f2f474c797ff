// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/growing_file.h>
#include <facetloc/testing/full_disk.h>

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

/** A link in a folder that others write to may lead to any file of the user. */
TEST(AtomicFile, ALinkIsReplacedAndItsTargetIsLeftAlone) {
  const TemporaryFolder folder;
  putBytes(folder / "precious", "old");
  for (const char* name : {"a", "b"}) {
    std::filesystem::create_symlink("precious", folder / name);
    if (*name == 'a')
      writeTextAtomically(folder / name, [](std::ostream& out) { out << "new"; });
    else
      GrowingFile(folder / name, "new");
    EXPECT_FALSE(std::filesystem::is_symlink(folder / name));
    EXPECT_EQ(bytesOf(folder / name), "new");
    EXPECT_EQ(bytesOf(folder / "precious"), "old");
  }
}

TEST(AtomicFile, FilesWithGuessableNamesAreLeftAlone) {
  const TemporaryFolder folder;
  putBytes(folder / "precious", "old");
  const std::vector<std::string> guesses = {"a.txt.tmp", "a.txt~", ".a.txt.tmp", "a.txt.part"};
  for (const std::string& guess : guesses) std::filesystem::create_symlink("precious", folder / guess);
  writeTextAtomically(folder / "a.txt", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(bytesOf(folder / "precious"), "old");
  for (const std::string& guess : guesses) EXPECT_TRUE(std::filesystem::is_symlink(folder / guess)) << guess;
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
  const TemporaryFolder folder;
  putBytes(folder / "a.txt", "old");
  const auto write = [&] { writeTextAtomically(folder / "a.txt", [](std::ostream& out) { out << "new"; }); };
  {
    const test::FullDisk full(2);
    EXPECT_THAT(ioErrorOf(write), HasSubstr(test::FullDisk::kWords));
    EXPECT_THROW(write(), WriteError);
  }
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

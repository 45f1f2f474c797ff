// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/testing/full_disk.h>

#include <stdexcept>

namespace facetloc::test {
namespace {

using AtomicFile = InAFolder;

TEST_F(AtomicFile, WritesTheWholeFileAndNothingElse) {
  writeTextAtomically(folder_ / "a.txt", [](std::ostream& out) { out << "hello\n" << 1.5 << 12345; });
  EXPECT_EQ(bytesOf(folder_ / "a.txt"), "hello\n1.512345");
  EXPECT_EQ(folder_.count(), 1);
}

TEST_F(AtomicFile, ReplacesAnOlderFile) {
  putBytes(folder_ / "a.txt", "a longer, older text");
  writeTextAtomically(folder_ / "a.txt", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(bytesOf(folder_ / "a.txt"), "new");
}

TEST_F(AtomicFile, AFailedWriterLeavesTheOlderFileAndNoTemporaryOne) {
  putBytes(folder_ / "a.txt", "old");
  const auto fail = [](std::ostream& out) {
    out << "half";
    throw std::runtime_error("in the middle");
  };
  EXPECT_THROW(writeTextAtomically(folder_ / "a.txt", fail), std::runtime_error);
  EXPECT_EQ(bytesOf(folder_ / "a.txt"), "old");
  EXPECT_EQ(folder_.count(), 1);
}

/** A link in a folder that others write to may lead to any file of the user. */
TEST_F(AtomicFile, ALinkIsReplacedAndItsTargetIsLeftAlone) {
  putBytes(folder_ / "precious", "old");
  for (const char* name : {"a", "b"}) {
    std::filesystem::create_symlink("precious", folder_ / name);
    if (*name == 'a')
      writeTextAtomically(folder_ / name, [](std::ostream& out) { out << "new"; });
    else
      GrowingFile(folder_ / name, "new");
    EXPECT_FALSE(std::filesystem::is_symlink(folder_ / name));
    EXPECT_EQ(bytesOf(folder_ / name), "new");
    EXPECT_EQ(bytesOf(folder_ / "precious"), "old");
  }
}

TEST_F(AtomicFile, FilesWithGuessableNamesAreLeftAlone) {
  putBytes(folder_ / "precious", "old");
  const std::vector<std::string> guesses = {"a.txt.tmp", "a.txt~", ".a.txt.tmp", "a.txt.part"};
  for (const std::string& guess : guesses) std::filesystem::create_symlink("precious", folder_ / guess);
  writeTextAtomically(folder_ / "a.txt", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(bytesOf(folder_ / "precious"), "old");
  for (const std::string& guess : guesses) EXPECT_TRUE(std::filesystem::is_symlink(folder_ / guess)) << guess;
}

TEST_F(AtomicFile, ANameThatIsTooLongIsAnErrorLikeAnyOther) {
  const auto path = folder_ / std::string(300, 'x');
  EXPECT_THAT(ioErrorOf([&] { createFolders(path); }), HasSubstr("xxx"));
  EXPECT_THAT(ioErrorOf([&] { writeTextAtomically(path, [](std::ostream&) {}); }), HasSubstr("xxx"));
}

TEST_F(AtomicFile, MissingFolderIsAnError) {
  const auto message = ioErrorOf([&] { writeTextAtomically(folder_ / "none/a.txt", [](std::ostream&) {}); });
  EXPECT_THAT(message, HasAll("none", "does not exist"));
}

TEST_F(AtomicFile, AFolderInTheWayIsAnError) {
  std::filesystem::create_directory(folder_ / "a.txt");
  EXPECT_THAT(ioErrorOf([&] { writeTextAtomically(folder_ / "a.txt", [](std::ostream&) {}); }),
              HasSubstr("a.txt"));
}

TEST_F(AtomicFile, NeverReplacesADevice) {
  if (!std::filesystem::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full";
  EXPECT_NE(ioErrorOf([] { writeTextAtomically("/dev/full", [](std::ostream&) {}); }), "");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(AtomicFile, AFullDiskIsAnError) {
  putBytes(folder_ / "a.txt", "old");
  const auto write = [&] { writeTextAtomically(folder_ / "a.txt", [](std::ostream& out) { out << "new"; }); };
  {
    const FullDisk full(2);
    EXPECT_THAT(ioErrorOf(write), HasSubstr(FullDisk::kWords));
    EXPECT_THROW(write(), WriteError);
  }
  EXPECT_EQ(bytesOf(folder_ / "a.txt"), "old");
  EXPECT_EQ(folder_.count(), 1);
}

TEST_F(AtomicFile, AStreamThatWentBadIsAnError) {
  const auto spoil = [](std::ostream& out) { out.setstate(std::ios::failbit); };
  EXPECT_NE(ioErrorOf([&] { writeTextAtomically(folder_ / "a.txt", spoil); }), "");
  EXPECT_EQ(folder_.count(), 0);
}

}  // namespace
}  // namespace facetloc::test

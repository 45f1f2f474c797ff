// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/temporary_file.h"
#include "temporary_folder.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/testing/full_disk.h>

#include <csignal>
#include <optional>
#include <stdexcept>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

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

/** Another process that has done some work and lives on until it is killed. */
class OtherProcess {
public:
  template <typename Work>
  explicit OtherProcess(const Work& work) {
    int ready[2];
    EXPECT_EQ(pipe(ready), 0);
    process_ = fork();
    if (process_ == 0) {
      work();
      EXPECT_EQ(write(ready[1], "x", 1), 1);
      pause();
    }
    char byte = 0;
    EXPECT_EQ(read(ready[0], &byte, 1), 1);
    close(ready[0]), close(ready[1]);
  }
  ~OtherProcess() { end(); }
  OtherProcess(const OtherProcess&) = delete;
  OtherProcess& operator=(const OtherProcess&) = delete;
  void end() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  pid_t id() const { return process_; }

private:
  pid_t process_;
};

TEST(OutputLock, KeepsOthersOutAndDiesWithItsProcess) {
  const TemporaryFolder folder;
  putBytes(folder / "a.flmap", "old");
  const auto lockFolder = [&] { OutputLock::ofFolder(folder.path()); };
  const auto lockFile = [&] { OutputLock::ofFile(folder / "a.flmap"); };
  std::optional<OutputLock> of_folder, of_file;
  OtherProcess other([&] {
    of_folder = OutputLock::ofFolder(folder.path());
    of_file = OutputLock::ofFile(folder / "a.flmap");
  });
  for (const std::string& error : {ioErrorOf(lockFolder), ioErrorOf(lockFile)})
    EXPECT_THAT(error, HasSubstr("is being written by process " + std::to_string(other.id())));
  other.end();
  EXPECT_EQ(ioErrorOf(lockFolder), "");
  EXPECT_EQ(ioErrorOf(lockFile), "");
  EXPECT_EQ(bytesOf(folder / "a.flmap"), "old");
  EXPECT_EQ(folder.count(), 1) << "no lock file is left";
}

TEST(OutputLock, AFileThatStaysEmptyIsRemoved) {
  const TemporaryFolder folder;
  {
    const OutputLock lock = OutputLock::ofFile(folder / "a");
    EXPECT_TRUE(std::filesystem::exists(folder / "a"));
  }
  EXPECT_EQ(folder.count(), 0);
  {
    const OutputLock lock = OutputLock::ofFile(folder / "a");
    putBytes(folder / "a", "x");
  }
  EXPECT_EQ(bytesOf(folder / "a"), "x");
}

TEST(OutputLock, LocksTheTargetOfALinkAndNoPipe) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("there", folder / "link");
  {
    const OutputLock lock = OutputLock::ofFile(folder / "link");
    EXPECT_THAT(ioErrorOf([&] { OutputLock::ofFile(folder / "there"); }), HasSubstr("is being written"));
  }
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(ioErrorOf([&] { OutputLock::ofFile(folder / "pipe"); }), HasSubstr("not a regular file"));
}

TEST(OutputLock, RemovesFilesOfKilledProgramsOnly) {
  const TemporaryFolder folder;
  const auto leave = [&] {
    auto* file = new TemporaryFile(folder / "a.txt");  // it is not removed: the process is killed
    putBytes(file->path().string() + "-journal", "x");
  };
  OtherProcess killed(leave);
  killed.end();
  EXPECT_EQ(folder.count(), 2);
  const OtherProcess writing(leave);
  EXPECT_EQ(folder.count(), 4);
  putBytes(folder / ".facetloc-notes.tmp", "of a user");
  std::filesystem::create_symlink("nowhere", folder / ".facetloc-0123456789abcdef.tmp");
  OutputLock::ofFolder(folder.path());
  EXPECT_EQ(folder.count(), 4) << "the two of the living process, the user's two";
}

}  // namespace
}  // namespace facetloc::test

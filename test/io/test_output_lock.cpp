// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/temporary_file.h"
#include "temporary_folder.h"

#include <facetloc/io/atomic_file.h>

#include <csignal>
#include <optional>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace facetloc::test {
namespace {

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

// SPDX-License-Identifier: BSD-3-Clause
// Programs that are killed, disks that are full, and several who use a map at once.
#include "map_file.h"

#include <facetloc/testing/full_disk.h>

#include <sqlite3.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <random>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace facetloc::test {
namespace {

TEST_F(MapFile, AFullDiskLeavesTheOldMap) {
  writeExample();
  const std::string before = bytesOf(path_);
  {
    const FullDisk full(32768);
    EXPECT_NE(ioErrorOf([this] { writeMap(path_, ExampleMap().map(60)); }), "");
  }
  EXPECT_EQ(bytesOf(path_), before);
  EXPECT_EQ(folder_.count(), 1);
}

/** A child process that adds models for ever and tells each one by a byte in a pipe. */
class Builder {
public:
  explicit Builder(const std::filesystem::path& path) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ == 0) {
      close(ends[0]);
      try {
        ExampleMap example;
        MapDatabase db = MapDatabase::open(path);
        for (;;) {
          db.add(example.model("model " + std::to_string(db.modelNames().size())), example.view(25));
          if (write(ends[1], "+", 1) != 1) _exit(2);
        }
      } catch (...) {
        _exit(3);
      }
    }
    close(ends[1]);
    told_ = ends[0];
  }
  /** \brief Kills the child and returns how many models it has reported; -1 if it ended on its own. */
  int kill() {
    ::kill(child_, SIGKILL);
    int status = 0;
    waitpid(child_, &status, 0);
    while (waitForModel()) {
    }
    close(told_);
    return WIFSIGNALED(status) ? count_ : -1;
  }
  /** \brief False once the child has ended and all that it told is counted. */
  bool waitForModel() {
    char byte;
    const bool told = read(told_, &byte, 1) == 1;
    count_ += told;
    return told;
  }

private:
  pid_t child_ = -1;
  int told_ = -1;
  int count_ = 0;
};

TEST_F(MapFile, SurvivesBeingKilled) {
  constexpr int kRounds = 15;
  MapDatabase::create(path_);
  std::mt19937 engine(3);
  int promised = 0;
  for (int round = 0; round < kRounds; ++round) {
    Builder builder(path_);
    if (round == 0) builder.waitForModel();  // however slow the disk, there is something to lose
    std::this_thread::sleep_for(std::chrono::microseconds(2000 + engine() % 30000));
    const int told = builder.kill();
    ASSERT_GE(told, 0) << "the builder failed";
    promised += told;
    const Map map = readMap(path_);
    EXPECT_GE(static_cast<int>(map.models.size()), promised);
    EXPECT_LE(static_cast<int>(map.models.size()), promised + 1) << "at most one was not told any more";
    EXPECT_THAT(checkMap(path_), IsEmpty());
    promised = static_cast<int>(map.models.size());
  }
  EXPECT_GT(promised, 0);
}

TEST_F(MapFile, AnUnfinishedTransactionIsRolledBack) {
  writeExample();
  const auto killed = folder_ / "killed.flmap";
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
  // A cache of one page makes SQLite write to the file before it commits.
  const char* half =
      "PRAGMA cache_size = 1; BEGIN; UPDATE segment SET num_points = 1; UPDATE model SET stamp = 0;"
      "DELETE FROM depth_picture;";
  ASSERT_EQ(sqlite3_exec(db, half, nullptr, nullptr, nullptr), SQLITE_OK);
  std::filesystem::copy_file(path_, killed);
  std::filesystem::copy_file(path_.string() + "-journal", killed.string() + "-journal");
  sqlite3_close(db);
  ASSERT_NE(bytesOf(killed), bytesOf(path_)) << "the copy is half written";

  EXPECT_THAT(checkMap(killed), IsEmpty());
  EXPECT_EQ(bytesOf(killed), bytesOf(path_));
  EXPECT_EQ(readMap(killed).models.size(), 3u);
}

TEST_F(MapFile, AReaderSeesOneSnapshotDespiteWriters) {
  writeExample(3);
  std::atomic<bool> done = false;
  std::thread writer([&] {
    MapDatabase map = MapDatabase::open(path_);
    for (int i = 0; i < 150; ++i) {
      map.add(ExampleMap(9).model("more" + std::to_string(i)), ExampleMap(9).view());
    }
    done = true;
  });
  std::size_t models = 0;
  while (!done) {
    const Map map = readMap(path_);  // throws if segments of a model are there that itself is not
    EXPECT_GE(map.models.size(), models);
    models = map.models.size();
    EXPECT_GE(openMap(path_, 1).models.size(), models);
  }
  writer.join();
}

TEST_F(MapFile, AMapThatCannotBeCreatedLeavesNoFile) {
  const FullDisk full(4096);  // less than a map takes
  EXPECT_THROW(MapDatabase::create(path_), IoError);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(MapFile, ManyReadersAtOnce) {
  writeExample();
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([this] {
      for (int k = 0; k < 20; ++k) EXPECT_EQ(readMap(path_).models.size(), 3u);
    });
  for (auto& thread : threads) thread.join();
}

}  // namespace
}  // namespace facetloc::test

// SPDX-License-Identifier: BSD-3-Clause
#include "batch/batch.h"
#include "batch/shared_batch.h"
#include "cli/progress.h"
#include "process.h"

#include <facetloc/io/error.h>

#include <atomic>
#include <sys/resource.h>

namespace facetloc::test {
namespace {

class BatchTest : public testing::TestWithParam<int> {
protected:
  std::ostringstream out_, err_;
  const Console console_{out_, err_, false, false, "facetloc_test"};
  static std::string name(std::size_t i) { return "image" + std::to_string(i); }
};

TEST_P(BatchTest, DoesEachItemOnceByAKnownWorker) {
  Batch batch(GetParam(), 100, console_);
  std::vector<int> done(100, 0);
  batch.run(name, [&](std::size_t i, int worker) {
    EXPECT_LT(worker, batch.workers());
    ++done[i];
  });
  EXPECT_THAT(done, Each(1));
  EXPECT_EQ(batch.report(), kOk);
  EXPECT_THAT(err_.str(), IsEmpty());
}

TEST_P(BatchTest, OneBadItemStopsNothing) {
  Batch batch(GetParam(), 10, console_);
  batch.run(name, [&](std::size_t i, int) {
    if (i == 7) throw std::runtime_error("is torn");
    if (i == 3) throw IoError("depth/3.png", "is no PNG");
  });
  EXPECT_EQ(batch.report(), kFailed);
  EXPECT_EQ(err_.str(), "facetloc_test: depth/3.png: is no PNG\n"
                        "facetloc_test: image7: is torn\n"
                        "facetloc_test: 2 of 10 items failed\n");
}

TEST_P(BatchTest, StopsWhereNothingCanBeWritten) {
  Batch batch(GetParam(), 1000, console_);
  std::atomic<int> begun{0};
  const auto run = [&] {
    batch.run(name, [&](std::size_t i, int) {
      ++begun;
      if (i >= 5) throw WriteError("out/5.png", "No space left on device");
    });
  };
  EXPECT_THROW(run(), WriteError);
  EXPECT_LE(begun, 5 + batch.workers());
}

TEST_P(BatchTest, StopsAtCtrlCAndSaysHowFarItIs) {
  Batch batch(GetParam(), 1000, console_);
  const auto run = [&] {
    batch.run(name, [&](std::size_t i, int) {
      if (i == 3) std::raise(SIGINT);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
  };
  EXPECT_THAT(run, testing::ThrowsMessage<Stopped>(HasAll("stopped after ", " of 1000 images")));
}

/** With an address space that has no room for the stacks of all threads. */
TEST_F(BatchTest, DoesAllWithTheThreadsThatThereAre) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "ThreadSanitizer itself dies where it gets no memory for one more thread";
#endif
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto runWithoutRoom = [&] {
    constexpr rlim_t kRoom = 512 << 20;  // [bytes]
    std::ifstream statm("/proc/self/statm");
    rlim_t pages = 0;
    statm >> pages;
    const rlim_t size = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + kRoom;
    const rlimit limit{size, size};
    if (setrlimit(RLIMIT_AS, &limit) != 0) std::_Exit(2);
    Batch batch(1000, 1000, console_);
    std::atomic<int> done{0};
    batch.run(name, [&done](std::size_t, int) { ++done; });
    std::_Exit(done == 1000 ? 0 : 1);
  };
  EXPECT_EXIT(runWithoutRoom(), testing::ExitedWithCode(0), "");
}

TEST_P(BatchTest, NothingToDo) {
  Batch batch(GetParam(), 0, console_);
  batch.run(name, [](std::size_t, int) { FAIL(); });
  EXPECT_EQ(batch.report(), kOk);
}

using Numbers = SharedBatch<std::vector<std::size_t>, std::size_t>;

class SharedBatchTest : public BatchTest {
protected:
  using Job = std::function<std::size_t(std::size_t item, int worker)>;
  Numbers batch(const Job& job) const {
    return {GetParam(), console_, [job](const std::vector<std::size_t>&, int) {
              return Numbers::Work{name, job};
            }};
  }
};

/** The first item ends when all are done that may run ahead of it. */
TEST_P(SharedBatchTest, HandsOutResultsInOrder) {
  const int threads = GetParam();
  std::atomic<std::size_t> begun{0};
  std::vector<std::size_t> taken;
  Numbers squares(threads, console_, [&](const std::vector<std::size_t>& order, int workers) {
    const std::size_t ahead = workers > 1 ? 8 * static_cast<std::size_t>(workers) : 1;
    return Numbers::Work{name, [&, order, ahead](std::size_t item, int) {
                           ++begun;
                           if (item == 0) {
                             EXPECT_TRUE(eventually([&] { return begun == ahead; }));
                           }
                           return order[item] * order[item];
                         }};
  });
  std::vector<std::size_t> order(200);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = 3 * i;
  EXPECT_FALSE(squares.helped());
  squares.run(order, order.size(),
              [&](std::size_t item, std::optional<std::size_t>&& square, const std::string&) {
                EXPECT_EQ(item, taken.size());
                taken.push_back(square.value());
              });
  ASSERT_EQ(taken.size(), order.size());
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(taken[i], 9 * i * i);
  EXPECT_EQ(squares.report(), kOk);
}

TEST_P(SharedBatchTest, OneBadItemStopsNothing) {
  Numbers numbers = batch([](std::size_t item, int) {
    if (item == 7) throw std::runtime_error("is torn");
    return item;
  });
  std::size_t taken = 0;
  numbers.run({}, 10,
              [&](std::size_t item, const std::optional<std::size_t>& number, const std::string& reason) {
                ++taken;
                EXPECT_EQ(number.has_value(), item != 7);
                EXPECT_EQ(reason, item == 7 ? "is torn" : "");
              });
  EXPECT_EQ(taken, 10u);
  EXPECT_EQ(numbers.report(), kFailed);
  EXPECT_EQ(err_.str(), "facetloc_test: image7: is torn\nfacetloc_test: 1 of 10 items failed\n");
}

TEST_P(SharedBatchTest, StopsWhereNothingCanBeWritten) {
  Numbers failing = batch([](std::size_t item, int) {
    if (item == 5) throw WriteError("out/5.png", "No space left on device");
    return item;
  });
  EXPECT_THROW(failing.run({}, 1000, [](std::size_t, auto&&, const std::string&) {}), WriteError);
  std::size_t taken = 0;
  Numbers numbers = batch([](std::size_t item, int) { return item; });
  const auto take = [&](std::size_t item, auto&&, const std::string&) {
    ++taken;
    if (item == 5) throw WriteError("results.csv", "No space left on device");
  };
  EXPECT_THROW(numbers.run({}, 1000, take), WriteError);
  EXPECT_EQ(taken, 6u);
}

TEST_P(SharedBatchTest, HandsOutAllThatIsDoneAtCtrlC) {
  std::atomic<std::size_t> done{0};
  std::size_t taken = 0;
  Numbers numbers = batch([&](std::size_t item, int) {
    if (item == 20) std::raise(SIGINT);
    ++done;
    return item;
  });
  const auto run = [&] { numbers.run({}, 1000, [&](std::size_t, auto&&, const std::string&) { ++taken; }); };
  EXPECT_THAT(run, testing::ThrowsMessage<Stopped>(HasAll("stopped after ", " of 1000 images")));
  EXPECT_EQ(taken, done);
}

INSTANTIATE_TEST_SUITE_P(Threads, SharedBatchTest, testing::Values(0, 1, 2, 5));
INSTANTIATE_TEST_SUITE_P(Threads, BatchTest, testing::Values(0, 1, 2, 5));

TEST(Progress, LineHasRateAndTimeLeft) {
  EXPECT_EQ(progressLine(0, 250, 0), "  0/250");
  EXPECT_EQ(progressLine(37, 250, 3.7), " 37/250  10.0/s  22 s left");
  EXPECT_EQ(progressLine(10, 10000, 10), "   10/10000  1.0/s  2.8 h left");
  EXPECT_EQ(progressLine(10, 1000, 10), "  10/1000  1.0/s  17 min left");
  EXPECT_EQ(progressLine(250, 250, 25), "250/250  10.0/s");
}

TEST(Progress, ShowsOnTerminalsOnly) {
  std::ostringstream out, err;
  for (const bool terminal : {false, true})
    for (const bool quiet : {false, true}) {
      err.str("");
      const Console console{out, err, terminal, quiet, {}};
      {
        Progress progress(console, 2);
        progress.step();
        progress.step();
      }
      if (terminal && !quiet)
        EXPECT_THAT(err.str(), HasSubstr("2/2"));
      else
        EXPECT_THAT(err.str(), IsEmpty());
    }
  EXPECT_THAT(out.str(), IsEmpty());
}

}  // namespace
}  // namespace facetloc::test

// SPDX-License-Identifier: BSD-3-Clause
// The tools under mpirun, as a user runs them: several processes write the same as one.
#include "../io/sql.h"
#include "batch/ranks.h"
#include "process.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/testing/places.h>

#include <algorithm>
#include <sys/stat.h>

namespace facetloc::test {
namespace {

constexpr int kFrames = 13;  // not a multiple of the numbers of ranks

TEST(Ranks, AProcessOfItsOwnIsTheFirstAndOnlyOne) {
  Ranks::join();
  const Ranks& ranks = Ranks::here();
  EXPECT_TRUE(ranks.isFirst());
  EXPECT_EQ(ranks.size(), 1);
  EXPECT_EQ(ranks.threads(), 0);
  EXPECT_EQ(ranks.share(5), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(ranks.owns(i));
  ranks.tell("to no rank");
  ranks.waitForOthers();
  ranks.leave();
  ranks.abort(1);
}

/** \param command a tool and its arguments */
std::vector<std::string> mpirun(int ranks, const std::vector<std::string>& command) {
  // Open MPI refuses to run as root, and more ranks than cores, unless asked. One run that ends removes the
  // folder of sessions in which another one begins, unless each process has a folder of its own.
  static const TemporaryFolder sessions;
  return Arguments{"/usr/bin/env",
                   "OMPI_ALLOW_RUN_AS_ROOT=1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
                   "OMPI_MCA_rmaps_base_oversubscribe=1",
                   "OMPI_MCA_orte_tmpdir_base=" + sessions / "",
                   kMpirun,
                   "-np",
                   std::to_string(ranks)} +
         command;
}

ToolRun runRanks(int ranks, const std::vector<std::string>& command) {
  setenv("HWLOC_COMPONENTS", "-gl", 1);  // or mpirun ends with the X server of any other test
  return Process(mpirun(ranks, command)).wait();
}

/** All files but timing.csv, whose contents no two runs share, and inputs.csv, which tells where images are.
 */
void expectSameFiles(const fs::path& folder, const fs::path& expected) {
  const auto files = filesOf(folder), expected_files = filesOf(expected);
  ASSERT_EQ(files.size(), expected_files.size());
  ASSERT_FALSE(files.empty());
  for (std::size_t i = 0; i < files.size(); ++i) {
    EXPECT_EQ(files[i].filename(), expected_files[i].filename());
    if (files[i].filename() == "timing.csv" || files[i].filename() == "inputs.csv") continue;
    EXPECT_EQ(contentOf(files[i]), contentOf(expected_files[i])) << files[i];
  }
}

/** The processes that this one has started and that still run. */
std::vector<pid_t> childrenOf(pid_t parent) {
  std::vector<pid_t> children;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string status = contentOf(entry.path() / "status");
    if (status.find("\nPPid:\t" + std::to_string(parent) + "\n") != std::string::npos)
      children.push_back(std::stoi(entry.path().filename().string()));
  }
  std::sort(children.begin(), children.end());
  return children;
}

/** The number of images that results have an answer for, as far as a run has come. */
std::size_t imagesIn(const std::string& results) {
  std::size_t n = 0;
  for (const auto& [frame, result] : readResults(results)) n += result.timing.models > 0;
  return n;
}

/** One simulated room for all tests of this file, and the results of a single process. */
class RanksTest : public testing::TestWithParam<int> {
protected:
  static void SetUpTestSuite() {
    if (!available()) return;
    room_ = std::make_unique<TemporaryFolder>();
    ok(runTool<simulateApp>({"room", "-o", *room_ / "", "--seed", "5", "--frames", std::to_string(kFrames),
                             "--width", "320", "--drive.turn_deg", "8"}));
    ok(runTool<mapBuildApp>({mapRun(), "-o", map(), "--map.distance", "0.1"}));
    ok(runTool<localizeApp>({map(), query(), "-o", results()}));
  }
  static void TearDownTestSuite() { room_.reset(); }
  void SetUp() override {
    if (!available()) GTEST_SKIP() << "built without MPI, or there is no mpirun";
  }
  static bool available() { return *kMpirun && fs::exists(kMpirun); }

  static std::string mapRun() { return *room_ / "map"; }
  static std::string query() { return *room_ / "query"; }
  static std::string map() { return *room_ / "map.flmap"; }
  static std::string results() { return *room_ / "results"; }

  /** A list of the query's images, one of them somewhere else. */
  std::string listWith(std::size_t index, const std::string& image) const {
    fs::create_directories(folder_ / "list");
    fs::copy_file(query() + "/camera.ini", folder_ / "list/camera.ini");
    std::ofstream list(folder_ / "list/images.txt");
    const auto files = filesOf(query() + "/depth");
    for (std::size_t i = 0; i < files.size(); ++i) list << (i == index ? image : files[i].string()) << "\n";
    return folder_ / "list/images.txt";
  }

  TemporaryFolder folder_;

private:
  static std::unique_ptr<TemporaryFolder> room_;
};
std::unique_ptr<TemporaryFolder> RanksTest::room_;

class NumberOfRanks : public RanksTest {};

TEST_P(NumberOfRanks, SegmentsAreTheSame) {
  ok(runTool<segmentApp>({query(), "-o", folder_ / "one", "--labels", "--overlay"}));
  const ToolRun run =
      ok(runRanks(GetParam(), {kSegmentTool, query(), "-o", folder_ / "several", "--labels", "--overlay"}));
  expectSameFiles(folder_ / "several", folder_ / "one");
  EXPECT_THAT(run.out, HasSubstr("13 images with "));
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1);  // the first rank alone has the word

  fs::remove(filesOf(folder_ / "several")[4]);
  EXPECT_THAT(ok(runRanks(GetParam(), {kSegmentTool, query(), "-o", folder_ / "several", "--labels",
                                       "--overlay", "--resume"}))
                  .out,
              HasAll("1 image with", "12 were done before"));
  expectSameFiles(folder_ / "several", folder_ / "one");
}

TEST_P(NumberOfRanks, TheMapIsTheSame) {
  const std::string path = folder_ / "map.flmap";
  const std::vector<std::string> build = {kMapTool, "build", mapRun(), "-o", path, "--map.distance", "0.1"};
  const ToolRun run = ok(runRanks(GetParam(), build));
  EXPECT_EQ(contentOf(path), contentOf(map()));
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 2) << "said by one rank";

  std::vector<std::string> resume = build;
  resume.push_back("--resume");
  EXPECT_THAT(ok(runRanks(GetParam(), resume)).out, HasSubstr("0 local models added"));
  EXPECT_EQ(contentOf(path), contentOf(map()));
  EXPECT_EQ(runRanks(GetParam(), build).code, kFailed);  // is there already
}

TEST_P(NumberOfRanks, PosesAreTheSame) {
  const std::string folder = folder_ / "dealt";
  const ToolRun run = ok(runRanks(GetParam(), {kLocalizeTool, map(), query(), "-o", folder}));
  EXPECT_THAT(run.out, HasSubstr("13 images: "));
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1);
  expectSameFiles(folder, results());  // no journal among them
}

TEST_P(NumberOfRanks, PosesByTheShortlistOfALargeMapAreTheSame) {
  for (const std::string aligned : {"3000", "6"}) {  // more models than this are chosen by examination
    const auto command = [&](const std::string& name) {
      std::vector<std::string> words = {kLocalizeTool, map(), query(), "-o", folder_ / (name + aligned)};
      words.insert(words.end(), {"--shortlist.exhaustive_up_to", "1", "--shortlist.size", "3"});
      words.insert(words.end(), {"--shortlist.first_models", "1", "--shortlist.aligned_models", aligned});
      return words;
    };
    ok(runRanks(1, command("one")));
    ok(runRanks(GetParam(), command("several")));
    expectSameFiles(folder_ / ("several" + aligned), folder_ / ("one" + aligned));
  }
}

TEST_P(NumberOfRanks, ABadImageIsReportedOnceAndDoneLater) {
  const std::string bad = folder_ / filesOf(query() + "/depth")[6].filename().string();
  writeContent(bad, "no PNG at all");
  const std::string input = listWith(6, bad);
  ASSERT_EQ(runTool<localizeApp>({map(), input, "-o", folder_ / "one"}).code, kFailed);
  EXPECT_THAT(runRanks(GetParam(), {kLocalizeTool, map(), input, "-o", folder_ / "several"}),
              fails(bad, "1 of 13 items failed"));
  for (const char* file : {"/hypotheses.csv", "/poses_tum.txt"})
    EXPECT_EQ(contentOf(folder_ / "several" + file), contentOf(folder_ / "one" + file)) << file;
  EXPECT_EQ(imagesIn(folder_ / "several"), 12u);

  fs::copy_file(filesOf(query() + "/depth")[6], bad, fs::copy_options::overwrite_existing);
  ok(runRanks(GetParam(), {kLocalizeTool, map(), input, "-o", folder_ / "several", "--resume"}));
  expectSameFiles(folder_ / "several", results());
}

INSTANTIATE_TEST_SUITE_P(Mpirun, NumberOfRanks, testing::Values(2, 3, 4));

/** A pipe whose writer takes its time: who reads it waits, however fast the machine is. */
class SlowPipe {
public:
  explicit SlowPipe(const std::string& path) {
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    writer_ = open(path.c_str(), O_RDWR);
  }
  ~SlowPipe() { close(writer_); }
  SlowPipe(const SlowPipe&) = delete;
  SlowPipe& operator=(const SlowPipe&) = delete;

private:
  int writer_;
};

/** One image is a pipe in which its rank waits. */
TEST_F(RanksTest, ARankThatIsKilledEndsTheJobAndLosesNothingThatWasWritten) {
  const auto images = filesOf(query() + "/depth");
  const std::string pipe = folder_ / images[7].filename().string();  // image of the second rank
  const SlowPipe waiting(pipe);
  const std::string input = listWith(7, pipe);
  const std::string results = folder_ / "results";
  Process job(mpirun(2, {kLocalizeTool, map(), input, "-o", results, "--threads", "1"}));
  ASSERT_TRUE(eventually([&] { return fs::exists(results + "/hypotheses.csv") && imagesIn(results) == 7; }));
  const auto ranks = childrenOf(job.id());
  ASSERT_EQ(ranks.size(), 2u);
  kill(ranks[1], SIGKILL);
  EXPECT_THAT(job.wait().code, AllOf(testing::Gt(0), testing::Ne(127)));
  EXPECT_EQ(imagesIn(results), 7u);

  fs::remove(pipe);
  fs::copy_file(images[7], pipe);
  fs::copy(results, folder_ / "alone");
  ok(runTool<localizeApp>({map(), input, "-o", folder_ / "alone", "--resume"}));
  ok(runRanks(3, {kLocalizeTool, map(), input, "-o", results, "--resume"}));
  expectSameFiles(folder_ / "alone", RanksTest::results());
  expectSameFiles(results, RanksTest::results());
}

TEST_F(RanksTest, AnErrorOfAllIsReportedOnceAndEndsTheJob) {
  EXPECT_THAT(
      runRanks(3, {kLocalizeTool, folder_ / "no.flmap", query(), "-o", folder_ / "x"}),
      fails("facetloc_localize: " + (folder_ / "no.flmap") + ": does not exist", Not(HasSubstr("(rank"))));
  EXPECT_EQ(runRanks(2, {kSegmentTool, query(), "--bad"}).code, kUsage);
}

/** The second rank is started with another map, which is not there. */
TEST_F(RanksTest, AnErrorOfOneRankEndsTheJob) {
  const std::string results = folder_ / "results";
  EXPECT_THAT(runRanks(1, {kLocalizeTool, map(), query(), "-o", results, ":", "-np", "1", kLocalizeTool,
                           folder_ / "no.flmap", query(), "-o", results}),
              fails("facetloc_localize (rank 1): " + (folder_ / "no.flmap") + ": does not exist\n"));
}

/** Both ranks fail in every image of theirs. */
TEST_F(RanksTest, AModelThatCannotBeReadFailsTheImagesAndNoMore) {
  Map large = readMap(map());
  const std::size_t models = large.models.size();
  for (std::size_t i = models; i < 410;
       ++i) {  // more models than this stay in the file until they are requested
    large.models.push_back(large.models[i % models]);
    large.models.back().name += "/" + std::to_string(i);
  }
  for (const char* model : {"3", "406"}) {
    const std::string path = folder_ / model + ".flmap";
    writeMap(path, large);
    sql(path, std::string("UPDATE depth_picture SET data = zeroblob(10) WHERE model_id = ") + model);
    EXPECT_THAT(runRanks(2, {kLocalizeTool, path, query(), "-o", folder_ / "several", "--shortlist.size", "0",
                             "--tree.max_expansions", "5", "--evidence.enabled", "0"}),
                fails("13 of 13 items failed", std::string("model ") + model));
  }
}

TEST_F(RanksTest, ToolsThatDealNothingOutRefuse) {
  EXPECT_THAT(runRanks(2, {kMapTool, "info", map()}), refuses("start it without mpirun"));
}

/** As a terminal stops a job. */
TEST_F(RanksTest, CtrlCEndsTheJob) {
  const std::string pipe = folder_ / filesOf(query() + "/depth")[7].filename().string();
  const SlowPipe waiting(pipe);
  Process job(mpirun(2, {kLocalizeTool, map(), listWith(7, pipe), "-o", folder_ / "results"}));
  ASSERT_TRUE(eventually([&] { return fs::exists(folder_ / "results/timing.csv"); }));
  const auto ranks = childrenOf(job.id());
  job.signal(SIGINT);
  EXPECT_GT(job.wait().code, 0);
  for (const pid_t rank : ranks)
    EXPECT_TRUE(eventually([&] { return !fs::exists("/proc/" + std::to_string(rank)); }));
}

}  // namespace
}  // namespace facetloc::test

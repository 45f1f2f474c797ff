// SPDX-License-Identifier: BSD-3-Clause
// The live tool as a user runs it: a process of its own, with the real OpenNI2 and our driver.
#include "drawing/offscreen_display.h"
#include "keyboard.h"  // the last one, because of the macros of X
#include "live/live_app.h"
#include "process.h"
#include "tools/map_apps.h"
#include "tools/simulate_app.h"
#include "tools/text.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/io/text.h>
#include <facetloc/io/trajectory.h>

#include <gmock/gmock.h>
#include <pcl/io/lzf_image_io.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <chrono>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::contentOf;
using test::eventually;
using test::kPatience;
using test::lastLine;
using test::runTool;
using test::TemporaryFolder;
using test::ToolRun;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/** The command of facetloc_live. \param display of the process; empty = it has none. */
std::vector<std::string> liveCommand(const std::vector<std::string>& arguments, const std::string& display) {
  std::vector<std::string> command = {"/usr/bin/env"};
  if (display.empty())
    command.insert(command.end(), {"-u", "DISPLAY"});
  else
    command.push_back("DISPLAY=" + display);
  command.push_back(FACETLOC_LIVE);
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

/** facetloc_live as a process. */
class LiveProcess : public test::Process {
public:
  explicit LiveProcess(const std::vector<std::string>& arguments, const std::string& display = "")
      : Process(liveCommand(arguments, display)) {}
};

ToolRun runLive(const std::vector<std::string>& arguments) { return LiveProcess(arguments).wait(); }

std::vector<std::string> linesOf(const std::string& path) {
  std::istringstream in(contentOf(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> namesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/** What must hold of a results folder, be it of a run that ended or of one that was killed. */
void expectWholeResults(const std::string& folder, std::size_t least_frames) {
  const auto rows = readHypotheses(folder);
  const auto states = linesOf(folder + "/states.csv");
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states[0], "frame,stamp,state,reason,received,dropped,age_ms");
  EXPECT_GE(rows.size(), least_frames);
  EXPECT_EQ(states.size() - 1, rows.size());
  EXPECT_EQ(readTiming(folder).size(), rows.size());
  const auto localized =
      std::count_if(rows.begin(), rows.end(), [](const ResultRow& row) { return row.rank == 1; });
  EXPECT_EQ(readTumTrajectory(folder + "/poses_tum.txt").poses().size(), static_cast<std::size_t>(localized));
  EXPECT_THAT(contentOf(folder + "/params.ini"), HasSubstr("width = 320"));
}

/** One simulated room and its map for all tests of this file. */
class LiveTool : public testing::Test {
protected:
  static void SetUpTestSuite() {
    room_ = std::make_unique<TemporaryFolder>();
    const ToolRun run = runTool<SimulateApp>({"room", "-o", *room_ / "", "--seed", "5", "--frames", "40",
                                              "--width", "320", "--turn_deg", "3", "--step", "0.05"});
    ASSERT_EQ(run.code, kOk) << run.err;
    const ToolRun build = test::captured([](const Console& console) {
      return runMapTool({"build", *room_ / "map", "-o", map(), "--model_distance", "0.2"}, console);
    });
    ASSERT_EQ(build.code, kOk) << build.err;
  }
  static void TearDownTestSuite() { room_.reset(); }

  static std::string map() { return *room_ / "map.flmap"; }
  static std::string sequence() { return *room_ / "map"; }

  /** The first images of the sequence as a folder of PCD files. */
  std::string writeClouds(std::size_t n) const {
    const std::string clouds = folder_ / "clouds";
    fs::create_directories(clouds);
    const DepthSequence images = DepthSequence::open(sequence());
    for (std::size_t i = 0; i < n; ++i) {
      const DepthImage image = images.load(i);
      pcl::PointCloud<pcl::PointXYZ> cloud(image.camera.width, image.camera.height);
      for (int v = 0; v < image.camera.height; ++v)
        for (int u = 0; u < image.camera.width; ++u) {
          const float z = image.at(u, v);
          const Eigen::Vector3f p = z * image.camera.ray(u, v).cast<float>();
          cloud(u, v) = z > 0 ? pcl::PointXYZ(p.x(), p.y(), p.z()) : pcl::PointXYZ(NAN, NAN, NAN);
        }
      pcl::io::savePCDFileBinaryCompressed(clouds + "/" + images.frames()[i].name + ".pcd", cloud);
    }
    return clouds;
  }

  /** The first images of the sequence as a folder of PCLZF files. */
  std::string writePclzf(std::size_t n) const {
    const fs::path folder = folder_ / "pclzf";
    fs::create_directories(folder);
    const DepthSequence images = DepthSequence::open(sequence());
    for (std::size_t i = 0; i < n; ++i) {
      const DepthImage image = images.load(i);
      std::vector<std::uint16_t> millimetres;
      for (const float z : image.depth) millimetres.push_back(static_cast<std::uint16_t>(1000 * z + 0.5f));
      const Intrinsics& k = image.camera;
      const std::string name = "frame_20200101T000000." + std::to_string(i) + "00000";  // each 0.1 s
      pcl::io::LZFDepth16ImageWriter writer;
      EXPECT_TRUE(writer.write(reinterpret_cast<const char*>(millimetres.data()),
                               static_cast<std::uint32_t>(k.width), static_cast<std::uint32_t>(k.height),
                               (folder / (name + "_depth.pclzf")).string()));
      EXPECT_TRUE(writer.writeParameters({k.fx, k.fy, k.cx, k.cy}, (folder / (name + ".xml")).string()));
    }
    return folder.string();
  }

  TemporaryFolder folder_;

private:
  static std::unique_ptr<TemporaryFolder> room_;
};

std::unique_ptr<TemporaryFolder> LiveTool::room_;

TEST_F(LiveTool, PlaysASequenceAsACamera) {
  const std::string results = folder_ / "results";
  const ToolRun run = runLive({"--device", sequence(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 20);
  EXPECT_THAT(lastLine(run.out), HasSubstr("40 frames received"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("segmenting 100.0 %"));
  EXPECT_THAT(lastLine(run.out), HasSubstr(results));
  for (const ResultRow& row : readHypotheses(results)) EXPECT_EQ(row.rank, 0);
}

TEST_F(LiveTool, LocalizesInAMap) {
  const std::string results = folder_ / "results";
  const ToolRun run = runLive({"--device", sequence(), "--map", map(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 20);
  const Trajectory truth = readTumTrajectory(sequence() + "/groundtruth.txt");
  const auto poses = readTumTrajectory(results + "/poses_tum.txt").poses();
  EXPECT_GE(poses.size(), 15u) << run.out;
  for (const StampedPose& pose : poses) {
    const auto true_pose = truth.nearest(pose.stamp);
    ASSERT_TRUE(true_pose) << "the stamps are those of the sequence: " << pose.stamp;
    EXPECT_LT((pose.T_w_c.translation() - true_pose->translation()).norm(), 0.1) << pose.stamp;
  }
  // No frame older than 100 ms is processed.
  for (const std::string& line : linesOf(results + "/states.csv")) {
    const auto age = text::to<double>(line.substr(line.rfind(',') + 1));
    if (age) {
      EXPECT_LE(*age, 100.0) << line;
    }
  }
}

TEST_F(LiveTool, TakesItsOwnParameters) {
  const std::string results = folder_ / "results";
  ASSERT_EQ(runLive({"--device", sequence(), "--map", map(), "--headless", "--results", results,
                     "--max-frames", "2", "--key_distance", "0.4"})
                .code,
            kOk);
  EXPECT_THAT(contentOf(results + "/params.ini"), HasSubstr("key_distance = 0.4"));
  const ToolRun again = runLive(
      {"--device", sequence(), "--headless", "--max-frames", "1", "--params", results + "/params.ini"});
  EXPECT_EQ(again.code, kOk) << again.err;
}

TEST_F(LiveTool, EndsAfterSoManyFrames) {
  const std::string results = folder_ / "results";
  const ToolRun run =
      runLive({"--device", sequence(), "--headless", "--results", results, "--max-frames", "5", "--repeat"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_EQ(readHypotheses(results).size(), 5u);
}

TEST_F(LiveTool, EndsAfterSoManySeconds) {
  const auto start = Clock::now();
  const ToolRun run = runLive({"--device", sequence(), "--headless", "--duration", "0.5", "--repeat"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_GE(Clock::now() - start, 500ms);
}

TEST_F(LiveTool, TheSameFrameGivesTheSamePicture) {
  if (!OffscreenDisplay().available()) GTEST_SKIP() << OffscreenDisplay().problem();
  std::map<std::string, std::string> pictures;  // by name
  int compared = 0;
  for (const char* run_name : {"first", "second"}) {
    const std::string shots = folder_ / run_name;
    const ToolRun run =
        runLive({"--device", sequence(), "--headless", "--screenshots", shots, "--every", "1"});
    ASSERT_EQ(run.code, kOk) << run.err;
    const auto names = namesIn(shots);
    EXPECT_THAT(lastLine(run.out), HasSubstr(counted(names.size(), "screenshot") + " in " + shots));
    for (const std::string& name : names) {
      const std::string bytes = contentOf(shots + "/" + name);
      EXPECT_GT(bytes.size(), 20000u) << "an empty picture is smaller";
      const auto [before, is_new] = pictures.emplace(name, bytes);
      if (is_new) continue;
      EXPECT_TRUE(before->second == bytes) << name;
      ++compared;
    }
  }
  EXPECT_GE(compared, 1);
}

TEST_F(LiveTool, NeedsNoDisplayWithoutPictures) {
  const ToolRun run = runLive({"--device", sequence(), "--headless", "--max-frames", "1"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
}

TEST_F(LiveTool, SaysThatAWindowNeedsADisplay) {
  const ToolRun run = runLive({"--device", sequence()});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("--headless"));
}

TEST_F(LiveTool, ShowsAWindow) {
  const OffscreenDisplay display;
  if (!display.available()) GTEST_SKIP() << display.problem();
  LiveProcess process({"--device", sequence(), "--map", map(), "--duration", "2"}, std::getenv("DISPLAY"));
  const ToolRun run = process.wait();
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
}

bool press(KeySym key) { return test::Keyboard().press(key, "facetloc_live"); }

/** Shows a device in a window, with that working directory, and presses q in the end. \param play gets the
 * process before that. */
template <class Play>
ToolRun runWithKeys(const std::string& device, const std::string& folder, const Play& play) {
  std::vector<std::string> command =
      liveCommand({"--device", device, "--repeat", "--every", "1"}, std::getenv("DISPLAY"));
  command.insert(command.begin() + 1, "--chdir=" + folder);
  test::Process process(command);
  play(process);
  EXPECT_TRUE(eventually([] { return press(XK_q); }));
  return process.wait();
}

TEST_F(LiveTool, MakesNoScreenshotsButThoseOfTheKey) {
  const OffscreenDisplay display;
  if (!display.available()) GTEST_SKIP() << display.problem();
  const ToolRun run = runWithKeys(sequence(), folder_ / "", [](const test::Process& process) {
    ASSERT_TRUE(
        eventually([&] { return press(XK_s) && process.err().find("screenshot") != std::string::npos; }));
    std::this_thread::sleep_for(1s);  // of frames that nobody wants a picture of
  });
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(namesIn(folder_ / ""), AllOf(Not(IsEmpty()), Each(HasSubstr("live_"))));
}

TEST_F(LiveTool, GoesOnAfterAKeyThatCannotBeObeyed) {
  const OffscreenDisplay display;
  if (!display.available()) GTEST_SKIP() << display.problem();
  for (const std::string& name : namesIn(sequence() + "/depth"))
    test::writeContent(folder_ / ("live_" + name), "none of our pictures");
  const ToolRun run = runWithKeys(sequence(), folder_ / "", [](const test::Process& process) {
    ASSERT_TRUE(eventually([&] { return press(XK_s) && !process.err().empty(); }));
  });
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("would overwrite"));
}

TEST_F(LiveTool, CtrlCEndsInPeaceAndLosesNothing) {
  for (const int number : {SIGINT, SIGTERM}) {
    const std::string results = folder_ / std::to_string(number);
    LiveProcess process(
        {"--device", sequence(), "--map", map(), "--headless", "--repeat", "--results", results});
    ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 5; }));
    process.signal(number);
    const ToolRun run = process.wait();
    EXPECT_EQ(run.code, kOk) << run.err;
    EXPECT_THAT(lastLine(run.out), HasSubstr("processed"));
    expectWholeResults(results, 5);
  }
}

TEST_F(LiveTool, CtrlCDoesNotReachThePrivateDisplay) {
  if (!OffscreenDisplay().available()) GTEST_SKIP() << OffscreenDisplay().problem();
  const std::string shots = folder_ / "shots", results = folder_ / "results";
  LiveProcess process({"--device", sequence(), "--headless", "--repeat", "--screenshots", shots, "--every",
                       "5", "--results", results});
  ASSERT_TRUE(eventually([&] { return fs::exists(shots) && namesIn(shots).size() > 1; }));
  process.signal(SIGINT);
  const ToolRun run = process.wait();
  EXPECT_EQ(run.code, kOk) << run.err;
  for (const std::string& name : namesIn(shots)) EXPECT_THAT(name, Not(HasSubstr("tmp")));
}

TEST_F(LiveTool, AKilledRunHasLostNothing) {
  const std::string results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--map", map(), "--headless", "--repeat", "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 5; }));
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait().code, 128 + SIGKILL);
  EXPECT_GE(readHypotheses(results).size(), 5u);
  EXPECT_NO_THROW(readTumTrajectory(results + "/poses_tum.txt"));
}

TEST_F(LiveTool, SaysThatADeviceIsMissing) {
  const auto start = Clock::now();
  const ToolRun run = runLive({"--device", "vanished://camera", "--headless"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("facetloc_live: vanished://camera"));
  EXPECT_LT(Clock::now() - start, kPatience / 2);
  const ToolRun file = runLive({"--device", folder_ / "nothing.oni", "--headless"});
  EXPECT_EQ(file.code, kFailed);
  EXPECT_THAT(file.err, HasSubstr("nothing.oni"));
  const ToolRun relative = runLive({"--device", "runs/mistyped", "--headless"});
  EXPECT_EQ(relative.code, kFailed);
  EXPECT_THAT(relative.err, HasSubstr("runs/mistyped: does not exist"));
}

TEST_F(LiveTool, WaitsForADeviceUntilToldToStop) {
  LiveProcess process({"--device", folder_ / "later.oni", "--headless", "--wait"});
  ASSERT_TRUE(eventually([&] { return process.err().find("waiting for it") != std::string::npos; }));
  std::this_thread::sleep_for(2500ms);  // it looks again, and says nothing
  process.signal(SIGINT);
  const ToolRun run = process.wait();
  EXPECT_EQ(run.code, kOk);
  EXPECT_EQ(run.err.find("waiting"), run.err.rfind("waiting")) << run.err;
}

TEST_F(LiveTool, WaitsForADeviceForSoManySecondsOnly) {
  const auto start = Clock::now();
  const ToolRun run =
      runLive({"--device", folder_ / "never.oni", "--headless", "--wait", "--duration", "1.5"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_GE(Clock::now() - start, 1500ms);
}

TEST_F(LiveTool, SaysThatNoFrameComes) {
  const std::string images = writePclzf(3), results = folder_ / "results";
  const std::vector<std::string> slow = {"--device", images, "--headless", "--speed", "0.001"};
  std::vector<std::string> arguments = slow;
  arguments.insert(arguments.end(), {"--results", results});
  const ToolRun run = runLive(arguments);
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("no frame for 3 s"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("0 processed"));
  expectWholeResults(results, 0);

  arguments = slow;
  arguments.push_back("--wait");
  LiveProcess patient(arguments);
  ASSERT_TRUE(eventually([&] { return patient.err().find("waiting for it") != std::string::npos; }));
  patient.signal(SIGINT);
  EXPECT_EQ(patient.wait().code, kOk);
}

TEST_F(LiveTool, FindsADeviceThatComesLater) {
  const std::string folder = folder_ / "camera.oni";
  LiveProcess process({"--device", folder, "--headless", "--wait"});
  ASSERT_TRUE(eventually([&] { return process.err().find("waiting for it") != std::string::npos; }));
  // A recording of two frames in the place where it is waited for.
  const ToolRun record =
      runLive({"--device", sequence(), "--headless", "--record", folder_ / "new.oni", "--duration", "1"});
  ASSERT_EQ(record.code, kOk) << record.err;
  fs::rename(folder_ / "new.oni", folder);
  const ToolRun run = process.wait();
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(lastLine(run.out), HasSubstr("segmenting 100.0 %"));
}

TEST_F(LiveTool, RecordsWhatItSees) {
  const std::string file = folder_ / "run.oni";
  const ToolRun run = runLive({"--device", sequence(), "--headless", "--record", file});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("recorded to " + file));
  const ToolRun played = runLive({"--device", file, "--headless", "--results", folder_ / "played"});
  EXPECT_EQ(played.code, kOk) << played.err;
  expectWholeResults(folder_ / "played", 10);
}

TEST_F(LiveTool, OverwritesNoInputs) {
  const std::string copy = folder_ / "copy", file = folder_ / "run.oni";
  fs::copy(sequence(), copy, fs::copy_options::recursive);
  const auto names = namesIn(copy + "/depth");
  const ToolRun shots = runLive({"--device", copy, "--headless", "--screenshots", copy + "/depth"});
  EXPECT_EQ(shots.code, kUsage);
  EXPECT_THAT(shots.err, HasSubstr("among the images"));
  EXPECT_EQ(namesIn(copy + "/depth"), names);

  ASSERT_EQ(runLive({"--device", sequence(), "--headless", "--record", file, "--max-frames", "3"}).code, kOk);
  const std::string recorded = contentOf(file);
  for (const std::string& device : {file, sequence()}) {
    const ToolRun again = runLive({"--device", device, "--headless", "--record", file});
    EXPECT_EQ(again.code, kFailed);
    EXPECT_THAT(again.err, HasSubstr(file + ": exists already"));
    EXPECT_TRUE(contentOf(file) == recorded);
  }
}

TEST_F(LiveTool, PlaysAFolderOfClouds) {
  const std::string clouds = writeClouds(10), results = folder_ / "results";
  const ToolRun run = runLive({"--device", clouds, "--map", map(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 5);
  EXPECT_EQ(readHypotheses(results).front().frame, DepthSequence::open(sequence()).frames()[0].name);
}

TEST_F(LiveTool, LeavesOutCloudsThatCannotBeRead) {
  const std::string clouds = writeClouds(10), results = folder_ / "results";
  const auto names = namesIn(clouds);
  for (const int bad : {0, 4}) test::writeContent(clouds + "/" + names[bad], "no PCD at all");
  const ToolRun run = runLive({"--device", clouds, "--map", map(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("frames are missing: "));
  const Trajectory truth = readTumTrajectory(sequence() + "/groundtruth.txt");
  const auto poses = readTumTrajectory(results + "/poses_tum.txt").poses();
  EXPECT_GE(poses.size(), 3u);
  for (const StampedPose& pose : poses) {
    const auto true_pose = truth.nearest(pose.stamp, 1e-6);
    ASSERT_TRUE(true_pose) << pose.stamp;
    EXPECT_LT((pose.T_w_c.translation() - true_pose->translation()).norm(), 0.05) << pose.stamp;
  }
}

TEST_F(LiveTool, PlaysAFolderOfPclzf) {
  const std::string folder = writePclzf(10);
  const std::string results = folder_ / "results";
  const ToolRun run = runLive({"--device", folder, "--map", map(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 5);
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  const ToolRun record = runLive({"--device", folder, "--headless", "--record", folder_ / "x.oni"});
  EXPECT_EQ(record.code, kFailed);
  EXPECT_THAT(record.err, HasSubstr("only devices of OpenNI2 can be recorded"));
}

TEST_F(LiveTool, SaysThatPclzfFilesCannotBeRead) {
  const std::string folder = writePclzf(10), image = folder + "/frame_20200101T000000.300000_depth.pclzf",
                    camera = folder + "/frame_20200101T000000.500000.xml";
  fs::resize_file(image, fs::file_size(image) / 2);
  const ToolRun run = runLive({"--device", folder, "--headless"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("frames are missing: 1 of the images cannot be read"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("9 frames received"));

  for (const char* content : {"", "<depth><focal_length_x>", "no XML"}) {
    test::writeContent(camera, content);
    const ToolRun torn = runLive({"--device", folder, "--headless"});
    EXPECT_EQ(torn.code, kFailed);
    EXPECT_THAT(torn.err, HasSubstr(camera + ": no camera parameters"));
  }
  fs::remove(camera);
  const ToolRun missing = runLive({"--device", folder, "--headless"});
  EXPECT_EQ(missing.code, kFailed);
  EXPECT_THAT(missing.err, HasSubstr("10 depth images, but only 9 .xml"));
}

TEST_F(LiveTool, SaysThatImagesCannotBeRead) {
  const std::string copy = folder_ / "copy", results = folder_ / "results";
  fs::copy(sequence(), copy, fs::copy_options::recursive);
  const auto names = namesIn(copy + "/depth");
  test::writeContent(copy + "/depth/" + names[7], "no PNG at all");
  const std::vector<std::string> arguments = {"--device", copy, "--headless", "--results", results};
  const ToolRun run = runLive(arguments);
  EXPECT_EQ(run.code, kOk);
  EXPECT_THAT(run.err, HasSubstr("frames are missing: "));
  EXPECT_THAT(run.err, HasSubstr(names[7]));
  EXPECT_THAT(lastLine(run.out), HasSubstr("39 frames received"));
  const ToolRun stopped = runLive({"--device", copy, "--headless", "--max-frames", "30"});
  EXPECT_EQ(stopped.code, kOk);
  EXPECT_THAT(stopped.err, HasSubstr(names[7]));

  for (const std::string& name : names) test::writeContent(copy + "/depth/" + name, "no PNG at all");
  const ToolRun none = runLive(arguments);
  EXPECT_EQ(none.code, kFailed);
  EXPECT_THAT(none.err, HasSubstr("ended without a frame: "));
}

TEST_F(LiveTool, SaysWhatIsWrongWithFiles) {
  const ToolRun map_run = runLive({"--device", sequence(), "--map", folder_ / "no.flmap", "--headless"});
  EXPECT_EQ(map_run.code, kFailed);
  EXPECT_THAT(map_run.err, HasSubstr("no.flmap"));
  const ToolRun camera = runLive({"--device", sequence(), "--camera", folder_ / "no.ini", "--headless"});
  EXPECT_EQ(camera.code, kFailed);
  EXPECT_THAT(camera.err, HasSubstr("no.ini"));
  fs::create_directories(folder_ / "empty");
  const ToolRun empty = runLive({"--device", folder_ / "empty", "--headless"});
  EXPECT_EQ(empty.code, kFailed);
  EXPECT_THAT(empty.err, HasSubstr("empty"));
}

TEST(LiveApp, RefusesWhatMakesNoSense) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--every", "0"}, {"--max-frames", "-1"}, {"--duration", "-1"}, {"--speed", "-2"}, {"--foo"}}) {
    EXPECT_EQ(runTool<LiveApp>(arguments).code, kUsage) << arguments.front();
  }
}

TEST(LiveApp, HelpTellsTheKeys) {
  const ToolRun run = runTool<LiveApp>({"--help"});
  EXPECT_EQ(run.code, kOk);
  for (const char* key : {"screenshot", "record", "pause", "relocalize", "quit"})
    EXPECT_THAT(run.out, HasSubstr(key));
}

/** Of real sensors; they lie beside the checkout, or where the environment says. */
TEST(LiveApp, PlaysRealRecordings) {
  const char* data = std::getenv("FACETLOC_DATA");
  const fs::path folder = fs::path(data ? data : FACETLOC_DATA_DIR) / "oni";
  if (!fs::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  TemporaryFolder results;
  int recordings = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".oni") continue;
    ++recordings;
    const std::string out = results / entry.path().stem().string();
    const ToolRun run = runLive({"--device", entry.path().string(), "--headless", "--results", out});
    EXPECT_EQ(run.code, kOk) << entry.path() << run.err;
    expectWholeResults(out, 5);
  }
  EXPECT_EQ(recordings, 3);
}

}  // namespace
}  // namespace facetloc

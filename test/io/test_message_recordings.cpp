// SPDX-License-Identifier: BSD-3-Clause
// Recordings of ROS 2 and databases of RTAB-Map, as Python writes them after the specifications.
#include "changed_database.h"
#include "recorded_sequence.h"

namespace facetloc::test {
namespace {

std::vector<StampedPose> path() { return turningPath(6); }

/** The camera on the robot of write_recording.py. */
Eigen::Isometry3d opticalOnRobot() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T.translation() << 0.2, 0, 0.7;
  return T;
}

class MessageRecordings : public RecordedSequence {
protected:
  void SetUp() override {
    if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
    writeSequence();
  }
  /** \param words the container first */
  fs::path recording(const std::string& words, const Trajectory& odometry = {}) const {
    const std::string ending = words.rfind("db3", 0) == 0 ? ".db3" : ".mcap";
    const bool is_folder = words.find("split") != std::string::npos;
    return recordAs("walk", is_folder ? "" : ending, words, odometry);
  }
};

TEST_F(MessageRecordings, KeepImageTimesInEveryStorageFormat) {
  for (const char* words : {"db3", "db3 zstd", "db3 split", "db3 32FC1 big", "db3 png", "db3 rvl", "mcap",
                            "mcap zstd", "mcap lz4", "mcap unchunked", "mcap big", "mcap split lz4",
                            "mcap 32FC1 unchunked", "mcap png zstd", "mcap rvl lz4", "mcap transport"}) {
    const DepthSequence read = DepthSequence::open(recording(words));
    EXPECT_THAT(read.remark(),
                HasAll("/camera/depth/image_raw", Not(HasSubstr("finished")), Not(HasSubstr("damaged"))))
        << words;
    expectImages(read, 0, words);
  }
}

TEST_F(MessageRecordings, OneStrayMessageTakesTheTimesOfNoOther) {
  for (const char* words : {"mcap again", "mcap late", "db3 again late"}) {
    const DepthSequence read = DepthSequence::open(recording(words));
    expectImages(read, 0, words);
    const bool is_again = std::string(words).find("again") != std::string::npos;
    EXPECT_THAT(read.remark(),
                HasSubstr(is_again ? "1 more with the time of another left out" : "1 written late"));
  }
}

TEST_F(MessageRecordings, QuantizedDepthIsReadByItsParameters) {
  for (const char* words : {"db3 quantized", "mcap quantized rvl"}) {
    const DepthSequence read = DepthSequence::open(recording(words));
    constexpr float kStep = 1.5f * 1.5f / 10.1f;  // z^2 / a, of the farthest pixel
    expectImages(read, kStep, words);
    EXPECT_NE(read.load(0).depth, example_.image(0).depth) << "it has been quantized";
  }
}

TEST_F(MessageRecordings, AreReadByManyThreads) {
  for (const char* words : {"db3", "mcap lz4"})
    expectToBeReadByManyThreads(DepthSequence::open(recording(words)), 0);
}

TEST_F(MessageRecordings, OdometryIsOfMessagesOrTf) {
  for (const char* words : {"db3", "mcap zstd", "mcap tf"}) {
    const fs::path file = recording(words, Trajectory(path()));
    expectPoses(DepthSequence::open(file).readOdometry(file), path(), 1e-6, words);
  }
  const fs::path still = recording("mcap");
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(still).readOdometry(still); }), HasSubstr("no odometry"));
}

TEST_F(MessageRecordings, CorruptMessagesOfOdometryAreLeftOut) {
  for (const auto& [words, remarks] :
       {std::pair<const char*, std::vector<std::string>>{
            "mcap tf torn", {"2 of 8 messages of /tf left out", "not a rotation"}},
        {"db3 torn",
         {"1 of 7 messages of /odom left out", "ends before its last field",
          "2 of 2 messages of /tf left out"}}}) {
    const fs::path file = recording(words, Trajectory(path()));
    std::string remark;
    const Trajectory read = DepthSequence::open(file).readOdometry(file, &remark);
    for (const std::string& text : remarks) EXPECT_THAT(remark, HasSubstr(text));
    expectPoses(read, path(), 1e-6, words);
  }
}

TEST_F(MessageRecordings, OdometryIsTheCamerasWhereTfHasItOnTheRobot) {
  for (const char* words : {"db3 camera_tf", "mcap tf camera_tf"}) {
    const fs::path file = recording(words, Trajectory(path()));
    std::string remark;
    const Trajectory read = DepthSequence::open(file).readOdometry(file, &remark);
    EXPECT_THAT(remark, HasSubstr("camera_depth_optical_frame"));
    for (const StampedPose& pose : path())
      EXPECT_TRUE(read.at(pose.stamp, 1e-5)->isApprox(pose.T_w_c * opticalOnRobot(), 1e-6)) << words;
    CameraFile mounted;
    mounted.camera.intrinsics = example_.camera;
    mounted.camera.mounting = CameraMounting{0.7, 0, 0, 0, 0.2, 0};
    writeCameraFile(folder_ / "mounted.ini", mounted);
    RecordingHints hints;
    hints.camera = folder_ / "mounted.ini";
    const Trajectory of_robot = DepthSequence::open(file, hints).readOdometry(file);
    EXPECT_TRUE(of_robot.at(1000, 1e-5)->isApprox(path()[0].T_w_c, 1e-6))
        << "whose mounting is known turns poses itself";
  }
}

TEST_F(MessageRecordings, GravityIsByAnImuWhoseAxesAreKnown) {
  const Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  for (const char* words : {"db3 imu=camera_depth_optical_frame", "mcap imu=camera_imu_optical_frame",
                            "mcap imu=imu_link imu_tf"}) {
    const DepthSequence read = DepthSequence::open(recording(words));
    std::string remark;
    const GravityRecord gravity = read.gravity(0.01, &remark);
    EXPECT_THAT(remark, HasSubstr("/imu")) << words;
    ASSERT_EQ(gravity.samples().size(), 6u) << words;
    for (const StampedGravity& sample : gravity.samples()) {
      EXPECT_LT((sample.gravity.down - down).norm(), 1e-6) << words;
      EXPECT_NEAR(sample.gravity.std, 0.01, 1e-9) << words;
    }
  }
  std::string remark;
  EXPECT_TRUE(DepthSequence::open(recording("mcap imu=imu_link")).gravity(0.01, &remark).empty());
  EXPECT_THAT(remark, HasSubstr("nothing says how it is turned"));
  EXPECT_TRUE(DepthSequence::open(recording("mcap")).gravity(0.01, &remark).empty());
  EXPECT_EQ(remark, "");
}

TEST_F(MessageRecordings, ATopicCanBeNamedAndOthersAreListed) {
  const fs::path file = recording("mcap two_topics");
  const DepthSequence usual = DepthSequence::open(file);
  EXPECT_EQ(usual.frames().size(), 6u);
  EXPECT_THAT(usual.remark(), HasAll("--topic", "/other/depth/image (3)"));
  RecordingHints hints;
  hints.topic = "/other/depth/image";
  hints.camera = folder_ / "sequence" / "camera.ini";
  EXPECT_EQ(DepthSequence::open(file, hints).frames().size(), 3u);
  hints.topic = "/camera/color/image_raw";
  EXPECT_THAT(
      ioErrorOf([&] { DepthSequence::open(file, hints); }),
      HasAll("/camera/color/image_raw is of mono8", "/camera/depth/image_raw (6)", "16UC1, mono16 or 32FC1"));
}

TEST_F(MessageRecordings, TheirCameraIsNextToTheImagesOrOfTheirFrame) {
  const fs::path without = recording("db3 no_info");
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(without); }), HasSubstr("camera.ini"));
  for (const char* words : {"db3 other_info", "mcap other_info rvl"}) {
    const DepthSequence other = DepthSequence::open(recording(words));
    EXPECT_EQ(other.load(0).camera, example_.camera) << words;
    EXPECT_THAT(other.remark(), HasSubstr("/info")) << words;
  }
}

TEST_F(MessageRecordings, TheirCameraIsThatPartOfTheSensorThatTheImagesShow) {
  for (const char* words : {"db3 binned", "mcap binned png", "db3 binned other_info"}) {
    const DepthSequence read = DepthSequence::open(recording(words));
    EXPECT_EQ(read.load(0).camera, example_.camera) << words;
    EXPECT_THAT(read.remark(), HasSubstr("binning")) << words;
  }
}

TEST_F(MessageRecordings, AFolderOfThemHasTheFilesOfItsMetadata) {
  const fs::path folder = recording("db3 split");
  const fs::path second = folder / (folder.filename().string() + "_1.db3");
  EXPECT_EQ(DepthSequence::open(folder).frames().back().path, second);
  fs::rename(second, folder / "aside");
  const DepthSequence half = DepthSequence::open(folder);
  EXPECT_LT(half.frames().size(), 6u);
  EXPECT_THAT(half.remark(), HasAll("_1.db3", "not there", "ros2 bag reindex"));
  fs::rename(folder / (folder.filename().string() + "_0.db3"), folder / "renamed.db3");
  EXPECT_EQ(DepthSequence::open(folder).frames().front().path, folder / "renamed.db3");
  putBytes(folder / "metadata.yaml",
           "rosbag2_bagfile_information:\n  relative_file_paths:\n    - a.db3.zstd\n");
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder); }), HasSubstr("zstd -d"));
  fs::remove(folder / "metadata.yaml");
  EXPECT_LT(DepthSequence::open(folder).frames().size(), 6u) << "without a list, all that is there";
  EXPECT_THAT(DepthSequence::open(folder).remark(), HasSubstr("has no metadata.yaml"));
  fs::copy_file(recording("db3"), folder_ / "sequence" / "walk.db3");
  EXPECT_EQ(DepthSequence::open(folder_ / "sequence").frames()[0].path.extension(), ".png")
      << "images of a folder go before other files in it";
}

TEST_F(MessageRecordings, AnMcapThatWasNeverFinishedIsReadAsFarAsItGoes) {
  for (const char* words : {"mcap", "mcap zstd", "mcap lz4", "mcap unchunked"}) {
    const std::string bytes = bytesOf(recording(words));
    std::size_t least = 6;
    for (const double share : {0.95, 0.7, 0.5}) {
      const fs::path torn =
          putBytes(folder_ / "torn.mcap", bytes.substr(0, static_cast<std::size_t>(share * bytes.size())));
      const DepthSequence read = DepthSequence::open(torn);
      EXPECT_THAT(read.remark(), HasSubstr("never finished")) << words;
      EXPECT_LE(read.frames().size(), least) << words;
      least = read.frames().size();
      for (std::size_t i = 0; i < least; ++i) EXPECT_EQ(read.load(i).depth, example_.image(i).depth);
    }
    EXPECT_GE(least, 2u) << words;
  }
}

TEST_F(MessageRecordings, ADamagedChunkIsLeftOut) {
  std::string bytes = bytesOf(recording("mcap"));
  const std::size_t late = bytes.size() - bytes.size() / 8;  // channels are declared in the first chunk
  bytes[late] = static_cast<char>(bytes[late] ^ 0x40);
  const DepthSequence read = DepthSequence::open(putBytes(folder_ / "damaged.mcap", bytes));
  EXPECT_THAT(read.remark(), HasSubstr("damaged and left out"));
  EXPECT_LT(read.frames().size(), 6u);
  EXPECT_GT(read.frames().size(), 0u);
  bytes = bytesOf(recording("mcap unchunked"));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x40);
  EXPECT_THAT(DepthSequence::open(putBytes(folder_ / "damaged.mcap", bytes)).remark(), HasSubstr("checksum"));
}

TEST_F(MessageRecordings, UnreadableFilesAreAnErrorWithTheCause) {
  for (const char* container : {"db3", "mcap"}) {
    const std::string bytes = bytesOf(recording(container)), ending = std::string(".") + container;
    for (const std::string& broken :
         {std::string(), std::string("nothing"), bytes.substr(0, 13), bytes.substr(0, 600),
          std::string(5000, '\xff'), std::string(5000, '\0')}) {
      const fs::path file = putBytes(folder_ / ("broken" + ending), broken);
      EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(file); }), HasSubstr("broken" + ending));
    }
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / ("none" + ending)); }),
                HasSubstr("does not exist"));
  }
}

/** A record of an MCAP that claims a size. */
std::string record(char opcode, std::uint64_t size, const std::string& content) {
  return std::string(1, opcode) + std::string(reinterpret_cast<const char*>(&size), sizeof size) + content;
}

TEST_F(MessageRecordings, ClaimsOfGigabytesAreNotBelieved) {
  const std::string magic("\x89MCAP0\r\n");
  const auto number = [](std::uint64_t n) {
    return std::string(reinterpret_cast<const char*>(&n), sizeof n);
  };
  const std::string times = number(0) + number(0), none(8, '\0');
  for (const std::string& body : {record(6, ~0ull, times + number(~0ull) + none + number(~0ull)),
                                  record(6, 40, times + number(1ull << 40) + none + number(8)),
                                  record(6, 40, times + number(100) + none + number(~0ull)),
                                  record(4, 1ull << 40, "x"), record(5, ~0ull, "y"),
                                  record(3, 12,
                                         std::string("\1\0\xff\xff\xff\xff"
                                                     "abcdef",
                                                     12))}) {
    const fs::path file = putBytes(folder_ / "huge.mcap", magic + body);
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(file); }), HasSubstr("huge.mcap"));
  }
}

TEST_F(MessageRecordings, CellsOfADatabaseMayBeAnything) {
  const auto changed = [this](const char* sql) {
    const fs::path file = recording("db3");
    return errorWhenChanged(file, sql);
  };
  EXPECT_EQ(changed("SELECT 1"), "");
  EXPECT_THAT(changed("UPDATE messages SET data = 'text'"), HasSubstr("no sound recording"));
  EXPECT_THAT(changed("UPDATE messages SET topic_id = 99 WHERE id = 2"), HasSubstr("not listed"));
  EXPECT_THAT(changed("UPDATE messages SET timestamp = 'noon'"), HasSubstr("no sound recording"));
  EXPECT_THAT(changed("UPDATE messages SET data = substr(data, 1, 60)"),
              HasSubstr("ends before its last field"));
  EXPECT_THAT(changed("UPDATE messages SET data = CAST(x'00030000' || substr(data, 5) AS BLOB)"),
              HasSubstr("not encoded as plain CDR"));
  EXPECT_THAT(changed("UPDATE topics SET serialization_format = 'protobuf'"), HasSubstr("no depth images"));
  EXPECT_THAT(changed("DROP TABLE topics"), HasSubstr("no recording of rosbag2"));
}

class RtabmapDatabases : public RecordedSequence {
protected:
  void SetUp() override {
    if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
    writeSequence();
  }
  fs::path database(const std::string& words) const {
    return recordAs("home", ".db", "rtabmap " + words, Trajectory(poses()));
  }
  /** Poses of the camera, for all images but the last. */
  std::vector<StampedPose> poses() const {
    std::vector<StampedPose> poses;
    for (int i = 0; i < 5; ++i) {
      StampedPose pose;
      pose.stamp = example_.stamp(i);
      pose.T_w_c.translation() << i, 2, 0.5 * i;
      pose.T_w_c.linear() =
          Eigen::AngleAxisd(0.2 * i, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
      poses.push_back(pose);
    }
    return poses;
  }
  std::string errorWhenChanged(const char* sql) const { return test::errorWhenChanged(database(""), sql); }
};

TEST_F(RtabmapDatabases, HaveTheirImagesAndThePosesOfTheGraph) {
  for (const char* words : {"png", "32FC1", "rvl"}) {
    const DepthSequence read = DepthSequence::open(database(words));
    EXPECT_THAT(read.remark(), HasSubstr("5 of its 6 images have poses, of its optimised graph"));
    expectPoses(read.groundTruth(), poses(), 1e-5, words);
    expectImages(read, 0, words);
  }
}

TEST_F(RtabmapDatabases, WithoutAGraphThePosesAreItsOdometry) {
  const fs::path file = database("no_graph");
  const DepthSequence read = DepthSequence::open(file);
  EXPECT_THAT(read.remark(), HasSubstr("odometry, since no graph was saved"));
  const Eigen::Vector3d drift(0.03, 0, 0);  // as it is written, of the third
  EXPECT_TRUE(read.groundTruth()
                  .at(example_.stamp(2), 1e-5)
                  ->translation()
                  .isApprox(poses()[2].T_w_c.translation() + drift, 1e-5));
  EXPECT_EQ(DepthSequence::readTruth(file).poses().size(), 5u);
  EXPECT_EQ(sequence_->readPoses(file).poses().size(), 5u) << "as poses of another recording";
}

TEST_F(RtabmapDatabases, OfColourWithMorePixelsHaveTheCameraOfTheirDepth) {
  const fs::path file = database("");
  // Twice the size, in the header.
  sql(file, "UPDATE Data SET calibration = CAST(substr(calibration, 1, 16) || x'8000000060000000' || "
            "substr(calibration, 25) AS BLOB) WHERE calibration IS NOT NULL");
  const Intrinsics camera = DepthSequence::open(file).load(0).camera;
  EXPECT_EQ(camera.width, example_.camera.width);
  EXPECT_DOUBLE_EQ(camera.fx, example_.camera.fx / 2);
  EXPECT_DOUBLE_EQ(camera.cy, example_.camera.cy / 2);
}

TEST_F(RtabmapDatabases, UnreadableFilesAreAnErrorWithTheCause) {
  EXPECT_EQ(errorWhenChanged("SELECT 1"), "");
  EXPECT_THAT(errorWhenChanged("DROP TABLE Node"), HasSubstr("is no database of RTAB-Map"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET depth = NULL"), HasSubstr("no depth images"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET depth = x'ffd8ffe0' WHERE depth IS NOT NULL"),
              HasAll("node 1", "PNG"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET depth = 'text' WHERE depth IS NOT NULL"),
              HasSubstr("not a blob"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = NULL"), HasSubstr("its calibration"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = calibration || calibration"),
              HasSubstr("not a blob"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = CAST(calibration || calibration AS BLOB)"),
              HasSubstr("several cameras"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = CAST(substr(calibration, 1, 12) || x'01' || "
                               "substr(calibration, 14) AS BLOB)"),
              HasSubstr("stereo"));
  EXPECT_THAT(
      errorWhenChanged("UPDATE Data SET calibration = CAST(substr(calibration, 1, 28) || x'ffffff7f' || "
                       "substr(calibration, 33) AS BLOB)"),
      HasSubstr("its calibration"));
  EXPECT_THAT(errorWhenChanged("UPDATE Admin SET opt_poses = x'0102030405060708090a0b0c0d0e0f'"),
              HasSubstr("corrupt graph"));
  EXPECT_THAT(errorWhenChanged("UPDATE Node SET stamp = 1e300"), HasSubstr("impossible time"));
  for (const std::string& broken : {std::string(), std::string("nothing"), std::string(5000, '\xff')}) {
    const fs::path file = putBytes(folder_ / "broken.db", broken);
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(file); }), HasSubstr("broken.db"));
  }
}

}  // namespace
}  // namespace facetloc::test

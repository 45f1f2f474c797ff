// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>

#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace facetloc::test {
namespace {

const Intrinsics kCamera{32, 24, 26.25, 26.25, 15.5, 11.5};

CameraFile cameraFile() {
  CameraFile file;
  file.camera.intrinsics = kCamera;
  file.depth_scale = 5000;
  return file;
}

/** A slanted wall with a hole. */
DepthImage image() {
  DepthImage out{kCamera, {}};
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u)
      out.depth.push_back(u < 4 && v < 4 ? 0.f : 1.f + 0.02f * u + 0.01f * v);
  return out;
}

template <typename PointT>
pcl::PointCloud<PointT> cloud() {
  pcl::PointCloud<PointT> out(kCamera.width, kCamera.height);
  const DepthImage depth = image();
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const float z = depth.at(u, v) > 0 ? depth.at(u, v) : std::numeric_limits<float>::quiet_NaN();
      out(u, v).getVector3fMap() = (kCamera.ray(u, v) * z).cast<float>();
    }
  }
  out.is_dense = false;
  return out;
}

void expectNear(const DepthImage& read, const DepthImage& expected, float tolerance) {
  ASSERT_EQ(read.depth.size(), expected.depth.size());
  for (std::size_t i = 0; i < read.depth.size(); ++i)
    ASSERT_NEAR(read.depth[i], expected.depth[i], tolerance) << i;
}

std::vector<std::string> namesOf(const DepthSequence& sequence) {
  std::vector<std::string> names;
  for (const FrameFile& frame : sequence.frames()) names.push_back(frame.name);
  return names;
}

std::vector<double> stampsOf(const DepthSequence& sequence) {
  std::vector<double> stamps;
  for (const FrameFile& frame : sequence.frames()) stamps.push_back(frame.stamp);
  return stamps;
}

class Sequence : public InAFolder {
protected:
  fs::path putPng(const std::string& name) const {
    fs::create_directories((folder_ / name).parent_path());
    writeDepthPng(folder_ / name, image(), 5000);
    return folder_ / name;
  }
  template <typename PointT = pcl::PointXYZ>
  fs::path putPcd(const std::string& name) const {
    fs::create_directories((folder_ / name).parent_path());
    pcl::io::savePCDFileBinary((folder_ / name).string(), cloud<PointT>());
    return folder_ / name;
  }
  void putCamera(const std::string& name = "camera.ini") const {
    writeCameraFile(folder_ / name, cameraFile());
  }
  std::string openError(const std::string& name = "") const {
    return ioErrorOf([&] { DepthSequence::open(name.empty() ? folder_.path() : folder_ / name); });
  }
};

TEST_F(Sequence, ATumFolderIsOrderedByItsStamps) {
  for (const char* stamp : {"10.5", "9.25", "100"}) putPng("depth/" + std::string(stamp) + ".png");
  putBytes(folder_ / "depth/readme.md", "not an image");
  putBytes(folder_ / "depth/.hidden.png", "not an image");
  putBytes(folder_ / "groundtruth.txt", "9.25 1 2 3 0 0 0 1\n");
  putCamera();
  const auto sequence = DepthSequence::open(folder_.path());
  EXPECT_THAT(namesOf(sequence), ElementsAre("9.25", "10.5", "100"));
  EXPECT_THAT(stampsOf(sequence), ElementsAre(9.25, 10.5, 100));
  EXPECT_TRUE(sequence.stamped());
  EXPECT_EQ(sequence.frames()[0].path, folder_ / "depth/9.25.png");
  ASSERT_TRUE(sequence.camera());
  EXPECT_EQ(sequence.camera()->depth_scale, 5000);
  EXPECT_EQ(sequence.groundTruth().poses().size(), 1u);
  const DepthImage read = sequence.load(1);
  EXPECT_EQ(read.camera, kCamera);
  expectNear(read, image(), 1e-4f + 1e-6f);
  EXPECT_EQ(read.at(0, 0), 0.f);
}

TEST_F(Sequence, NamesWithoutNumbersAreOrderedLexicographically) {
  for (const char* name : {"hall", "stairs", "attic"}) putPng(std::string(name) + ".PNG");
  putCamera();
  const auto sequence = DepthSequence::open(folder_.path());
  EXPECT_THAT(namesOf(sequence), ElementsAre("attic", "hall", "stairs"));
  EXPECT_THAT(stampsOf(sequence), ElementsAre(0, 1, 2));
  EXPECT_FALSE(sequence.stamped());
}

TEST_F(Sequence, CameraAndTruthAreAlsoFoundInTheParent) {
  putPng("depth/1.png");
  putPng("single/2.png");
  putCamera();
  putBytes(folder_ / "groundtruth.txt", "1 1 2 3 0 0 0 1\n");
  for (const char* path : {"depth", "depth/", "depth/1.png", "single", "single/2.png"}) {
    const auto sequence = DepthSequence::open(folder_ / path);
    EXPECT_EQ(sequence.frames().size(), 1u) << path;
    EXPECT_TRUE(sequence.camera()) << path;
    EXPECT_FALSE(sequence.groundTruth().empty()) << path;
    EXPECT_FALSE(sequence.load(0).empty()) << path;
  }
}

TEST_F(Sequence, CameraAndTruthAreFoundNextToALink) {
  putPng("elsewhere/1.0.png");
  fs::create_directories(folder_ / "walk");
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "walk/depth");
  putCamera("walk/camera.ini");
  putBytes(folder_ / "walk/groundtruth.txt", "1 1 2 3 0 0 0 1\n");
  const DepthSequence sequence = DepthSequence::open(folder_ / "walk");
  EXPECT_EQ(sequence.camera()->camera.intrinsics, kCamera);
  EXPECT_FALSE(sequence.groundTruth().empty());
  EXPECT_EQ(DepthSequence::open(folder_ / "walk/depth").camera()->camera.intrinsics, kCamera);
  // And where the link leads to.
  fs::rename(folder_ / "walk/camera.ini", folder_ / "camera.ini");
  EXPECT_EQ(DepthSequence::open(folder_ / "walk").camera()->camera.intrinsics, kCamera);
}

TEST_F(Sequence, ALinkThatLeadsNowhereFailsWhenItIsRead) {
  putPng("1.0.png");
  putCamera();
  fs::create_symlink(folder_ / "gone.png", folder_ / "2.0.png");
  const DepthSequence sequence = DepthSequence::open(folder_ / "");
  EXPECT_THAT(namesOf(sequence), ElementsAre("1.0", "2.0"));
  EXPECT_THROW(sequence.load(1), IoError);
}

TEST_F(Sequence, ATrajectoryThatCannotBeReadIsAnErrorForWhoAsksForIt) {
  putPng("1.0.png");
  putCamera();
  putBytes(folder_ / "groundtruth.txt", "1 1 2 3 0 0 0 2\n");
  const DepthSequence sequence = DepthSequence::open(folder_ / "");
  EXPECT_FALSE(sequence.load(0).empty());
  for (int i = 0; i < 2; ++i)
    EXPECT_THAT(ioErrorOf([&] { sequence.groundTruth(); }), HasSubstr("groundtruth.txt: line 1"));
}

TEST_F(Sequence, ListsAreRelativeToThemselvesAndKeepTheirOrder) {
  putPng("a/z.png");
  putPcd("b/y.pcd");
  putCamera();
  putBytes(folder_ / "list.txt", "# two images\na/z.png\r\n\n" + (folder_ / "b/y.pcd").string() + "\n");
  const auto sequence = DepthSequence::open(folder_ / "list.txt");
  EXPECT_THAT(namesOf(sequence), ElementsAre("z", "y"));
  EXPECT_THAT(stampsOf(sequence), ElementsAre(0, 1));
  expectNear(sequence.load(1), image(), 1e-6f);
}

TEST_F(Sequence, AMissingImageOfAListStopsNoOther) {
  putPng("1.png");
  putCamera();
  putBytes(folder_ / "list.lst", "1.png\n2.png\n");
  const auto sequence = DepthSequence::open(folder_ / "list.lst");
  EXPECT_NO_THROW(sequence.load(0));
  EXPECT_THAT(ioErrorOf([&] { sequence.load(1); }), HasSubstr("2.png"));
}

TEST_F(Sequence, OneNameThatIsNoStampAmongStampsIsAnError) {
  putPng("1.png");
  putPng("readme.png");
  putCamera();
  EXPECT_THAT(openError("."), HasSubstr("readme.png"));
}

TEST_F(Sequence, ListsWithFaultsNameTheLine) {
  putPng("1.png");
  putCamera();
  putBytes(folder_ / "list.lst", "1.png\ncamera.ini\n");
  EXPECT_THAT(openError("list.lst"), HasAll("line 2", "is not a depth image"));
  putBytes(folder_ / "list.lst", "");
  EXPECT_THAT(openError("list.lst"), HasSubstr("no depth images"));
}

TEST_F(Sequence, NamesMustBeUnique) {
  putPng("1.png");
  putPcd("1.pcd");
  putCamera();
  EXPECT_THAT(openError(), HasSubstr("two frames have the name '1'"));
}

TEST_F(Sequence, ThereMustBeSomethingToRead) {
  EXPECT_THAT(openError(), HasSubstr("no depth images"));
  EXPECT_THAT(openError("none"), HasSubstr("does not exist"));
  putBytes(folder_ / "a.jpg", "x");
  EXPECT_THAT(openError("a.jpg"), HasSubstr("is no recording"));
  putPng("1.png");
  EXPECT_THAT(openError(), HasSubstr("camera.ini"));
  putBytes(folder_ / "camera.ini", "nonsense");
  EXPECT_THAT(openError(), HasAll("camera.ini", "line 1"));
}

TEST_F(Sequence, ImagesAreSubsampledToTheWorkingWidth) {
  putPng("1.png");
  putCamera();
  const auto sequence = DepthSequence::open(folder_.path());
  const DepthImage half = sequence.load(0, 16);
  EXPECT_EQ(half.camera, kCamera.subsampled(2));
  EXPECT_NEAR(half.at(5, 6), image().at(10, 12), 1e-4f);
  EXPECT_EQ(sequence.load(0, 17).camera, kCamera);
  EXPECT_THROW(sequence.load(1), std::out_of_range);
}

TEST_F(Sequence, ImagesOfTheWrongSizeAreRefused) {
  putPng("1.png");
  putPcd("2.pcd");
  CameraFile camera = cameraFile();
  camera.camera.intrinsics.width = 640;
  writeCameraFile(folder_ / "camera.ini", camera);
  const auto sequence = DepthSequence::open(folder_.path());
  for (const int i : {0, 1}) EXPECT_THAT(ioErrorOf([&] { sequence.load(i); }), HasAll("32x24", "640x24"));
}

TEST_F(Sequence, BrokenImagesAreErrorsAndOthersStillRead) {
  putPng("1.png");
  putBytes(folder_ / "2.png", "");
  putBytes(folder_ / "3.png", bytesOf(folder_ / "1.png").substr(0, 200));
  writePng(folder_ / "4.png",
           Raster<std::uint8_t>{kCamera.width, kCamera.height, 1,
                                std::vector<std::uint8_t>(kCamera.width * kCamera.height, 100)});
  putCamera();
  const auto sequence = DepthSequence::open(folder_.path());
  EXPECT_FALSE(sequence.load(0).empty());
  EXPECT_THAT(ioErrorOf([&] { sequence.load(1); }), HasSubstr("empty"));
  EXPECT_THAT(ioErrorOf([&] { sequence.load(2); }), HasSubstr("truncated"));
  EXPECT_THAT(ioErrorOf([&] { sequence.load(3); }), HasSubstr("8 bits"));
}

TEST(DepthPng, TheLargestNumberIsNotMeasured) {
  const TemporaryFolder folder;
  CameraFile file;
  file.camera.intrinsics = {3, 1, 1, 1, 0, 0};
  writePng(folder / "a.png", Raster<std::uint16_t>{3, 1, 1, {65535, 65534, 0}});
  EXPECT_THAT(readDepthPng(folder / "a.png", file).depth, ElementsAre(0, 65.534f, 0));
}

TEST(DepthPng, ValuesBeyondSixteenBitsBecomeZero) {
  const TemporaryFolder folder;
  const Intrinsics camera{5, 1, 1, 1, 0, 0};
  const float inf = std::numeric_limits<float>::infinity();
  writeDepthPng(folder / "a.png", {camera, {13.1068f, 13.107f, -1.f, inf, NAN}}, 5000);
  EXPECT_THAT(readGreyPng(folder / "a.png").data, ElementsAre(65534, 0, 0, 0, 0));
}

TEST_F(Sequence, PcdsNeedNoCameraFile) {
  putPcd<pcl::PointXYZ>("1.pcd");
  putPcd<pcl::PointXYZRGBA>("2.pcd");
  putPcd<pcl::PointNormal>("3.pcd");
  pcl::io::savePCDFileASCII((folder_ / "4.pcd").string(), cloud<pcl::PointXYZI>());
  pcl::io::savePCDFileBinaryCompressed((folder_ / "5.pcd").string(), cloud<pcl::PointXYZRGB>());
  const auto sequence = DepthSequence::open(folder_.path());
  EXPECT_FALSE(sequence.camera());
  ASSERT_EQ(sequence.frames().size(), 5u);
  for (int i = 0; i < 5; ++i) {
    const DepthImage read = sequence.load(i);
    expectNear(read, image(), 1e-6f);
    EXPECT_EQ(read.camera.width, kCamera.width);
    EXPECT_NEAR(read.camera.fx, kCamera.fx, 0.01);
    EXPECT_NEAR(read.camera.cx, kCamera.cx, 0.01);
    EXPECT_NEAR(read.camera.cy, kCamera.cy, 0.01);
  }
}

TEST_F(Sequence, ACameraFileNextToPcdsCounts) {
  putPcd("1.pcd");
  putCamera();
  EXPECT_EQ(DepthSequence::open(folder_.path()).load(0).camera, kCamera);
}

TEST_F(Sequence, ACameraFileThatIsNotOfThePcdsIsRefused) {
  pcl::PointCloud<pcl::PointXYZ> moved = cloud<pcl::PointXYZ>();
  for (auto& p : moved) p.x += 0.5f;
  pcl::io::savePCDFileBinary((folder_ / "1.pcd").string(), moved);
  putCamera();
  const DepthSequence sequence = DepthSequence::open(folder_.path());
  EXPECT_THAT(ioErrorOf([&] { sequence.load(0); }),
              HasSubstr("not where the camera of the camera.ini sees them"));
}

// ---- PCD files that lie
// --------------------------------------------------------------------------------------------

/** An ASCII PCD of doubles: 3 x 2 points (u, v, 2). */
std::string asciiPcd(const std::string& x_type = "F") {
  return "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE " + x_type +
         " F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\nDATA ascii\n"
         "0 0 2\n1 0 2\n2 0 2\n0 1 2\n1 1 nan\n2.5 1.25 2.5\n";
}

std::string replaced(std::string s, const std::string& what, const std::string& by) {
  return s.replace(s.find(what), what.size(), by);
}

class Pcd : public Sequence {
protected:
  std::string errorOf(const std::string& bytes) const {
    putBytes(folder_ / "a.pcd", bytes);
    return ioErrorOf([this] { readDepthPcd(folder_ / "a.pcd", Intrinsics{3, 2, 2, 2, 0, 0}); });
  }
};

TEST_F(Pcd, DoublesAreRead) {
  putBytes(folder_ / "a.pcd", asciiPcd());
  const DepthImage read = readDepthPcd(folder_ / "a.pcd", Intrinsics{3, 2, 2, 2, 0, 0});
  EXPECT_THAT(read.depth, ElementsAre(2, 2, 2, 2, 0, 2.5f));
}

TEST_F(Pcd, FaultsNameTheFile) {
  EXPECT_EQ(errorOf(asciiPcd()), "");
  EXPECT_THAT(errorOf(""), HasAll("a.pcd", "empty"));
  EXPECT_THAT(errorOf("a text\n"), HasSubstr("not a PCD"));
  EXPECT_THAT(errorOf(asciiPcd().substr(0, 60)), HasSubstr("not a PCD"));
  EXPECT_THAT(errorOf(asciiPcd().substr(0, asciiPcd().size() - 13)), HasSubstr("truncated"));
  EXPECT_THAT(errorOf(asciiPcd("I")), HasSubstr("'2.5' is no x of point 5"));
  EXPECT_THAT(errorOf(replaced(asciiPcd(), "x y z", "a b c")), HasSubstr("no field x"));
  EXPECT_THAT(errorOf(replaced(asciiPcd(), "WIDTH 3\nHEIGHT 2", "WIDTH 6\nHEIGHT 1")),
              HasSubstr("not an organized"));
  std::string large = replaced(replaced(asciiPcd(), "WIDTH 3\nHEIGHT 2", "WIDTH 70000\nHEIGHT 1"), "POINTS 6",
                               "POINTS 70000");
  for (int i = 6; i < 70000; ++i) large += "0 0 2\n";
  EXPECT_THAT(errorOf(large), HasSubstr("not an organized cloud (70000x1)"));
  EXPECT_THAT(ioErrorOf([this] { readDepthPcd(folder_ / "none.pcd"); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([this] { readDepthPcd(folder_.path()); }), HasSubstr("folder"));
}

TEST_F(Pcd, LyingHeadersAreRefused) {
  for (const auto& [what, by] : {std::pair<const char*, const char*>{"POINTS 6", "POINTS 4000000000"},
                                 {"POINTS 6", "POINTS -6"},
                                 {"POINTS 6", "POINTS"},
                                 {"POINTS 6\n", ""},
                                 {"WIDTH 3", "WIDTH 4294967299"},
                                 {"WIDTH 3", "WIDTH 0"},
                                 {"HEIGHT 2", "HEIGHT 65536"},
                                 {"COUNT 1 1 1", "COUNT 1 1 4000000"},
                                 {"COUNT 1 1 1", "COUNT 1 -1 1"},
                                 {"COUNT 1 1 1", "COUNT 1 1"},
                                 {"SIZE 8 8 8", "SIZE 8 8"},
                                 {"SIZE 8 8 8", "SIZE 8 8 3"},
                                 {"SIZE 8 8 8", "SIZE 8 8 8\nSIZE 1 1 1"},
                                 {"TYPE F F F", "TYPE F"},
                                 {"FIELDS x y z", "FIELDS"},
                                 {"DATA ascii", "DATA brotli"},
                                 {"DATA ascii", "DATA"},
                                 {"DATA ascii", "DATA binary"},
                                 {"DATA ascii", "DATA binary_compressed"},
                                 {"VERSION", "POINTS 6\nVERSION"}})
    EXPECT_THAT(errorOf(replaced(asciiPcd(), what, by)), HasSubstr("a.pcd")) << what << " -> " << by;
  const std::string large = "WIDTH 60000\nHEIGHT 60000\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3600000000\n";
  EXPECT_THAT(errorOf(replaced(asciiPcd(), "WIDTH 3\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\n", large)),
              HasSubstr("too many points"));
}

TEST_F(Pcd, TruncatedFilesAreRefused) {
  pcl::io::savePCDFileBinary((folder_ / "binary.pcd").string(), cloud<pcl::PointXYZ>());
  pcl::io::savePCDFileBinaryCompressed((folder_ / "compressed.pcd").string(), cloud<pcl::PointXYZ>());
  for (const char* name : {"binary.pcd", "compressed.pcd"}) {
    const std::string bytes = bytesOf(folder_ / name);
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50) {
      putBytes(folder_ / "a.pcd", bytes.substr(0, size));
      EXPECT_NE(ioErrorOf([this] { readDepthPcd(folder_ / "a.pcd", kCamera); }), "") << name << " " << size;
    }
  }
}

TEST_F(Pcd, FlippedBytesAreErrorsOrImages) {
  pcl::io::savePCDFileBinary((folder_ / "binary.pcd").string(), cloud<pcl::PointXYZ>());
  pcl::io::savePCDFileBinaryCompressed((folder_ / "compressed.pcd").string(), cloud<pcl::PointXYZ>());
  putBytes(folder_ / "ascii.pcd", asciiPcd());
  std::mt19937 engine(11);
  for (const char* name : {"ascii.pcd", "binary.pcd", "compressed.pcd"}) {
    const std::string bytes = bytesOf(folder_ / name);
    for (int i = 0; i < 400; ++i) {
      std::string corrupt = bytes;
      const std::size_t range = i % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 250);
      corrupt[engine() % range] = static_cast<char>(i % 4 ? '0' + engine() % 10 : engine());
      putBytes(folder_ / "a.pcd", corrupt);
      ioErrorOf([this] { readDepthPcd(folder_ / "a.pcd"); });
    }
  }
}

TEST_F(Pcd, ACompressedSizeThatLiesIsRefused) {
  pcl::io::savePCDFileBinaryCompressed((folder_ / "b.pcd").string(), cloud<pcl::PointXYZ>());
  const std::string bytes = bytesOf(folder_ / "b.pcd");
  const std::size_t data = bytes.find("DATA binary_compressed\n") + 23;
  for (const std::size_t at : {data + 3, data + 4, data + 7}) {
    std::string lie = bytes;
    lie[at] ^= 0x7F;
    putBytes(folder_ / "a.pcd", lie);
    EXPECT_NE(ioErrorOf([this] { readDepthPcd(folder_ / "a.pcd", kCamera); }), "") << at - data;
  }
}

TEST_F(Pcd, LinesOfBlanksInTheHeaderMeanNothing) {
  for (const char* line : {"\n", " \n", "\r\n", "\t \v\n"})
    EXPECT_EQ(errorOf(replaced(asciiPcd(), "FIELDS", std::string(line) + "FIELDS")), errorOf(asciiPcd()));
}

TEST_F(Pcd, WordsAmongThePointsAreRefused) {
  for (const char* more : {"WIDTH 4000000000\n", "COLUMNS x\n"})
    EXPECT_THAT(errorOf(replaced(asciiPcd(), "DATA ascii\n", std::string("DATA ascii\n") + more)),
                HasSubstr("is corrupt: '"))
        << more;
}

TEST_F(Pcd, CloudsWithoutPoints) {
  auto empty = cloud<pcl::PointXYZ>();
  for (auto& point : empty) point.x = point.y = point.z = NAN;
  pcl::io::savePCDFileBinary((folder_ / "a.pcd").string(), empty);
  EXPECT_THAT(ioErrorOf([this] { readDepthPcd(folder_ / "a.pcd"); }), HasSubstr("intrinsics"));
  const DepthImage read = readDepthPcd(folder_ / "a.pcd", kCamera);
  for (const float z : read.depth) EXPECT_EQ(z, 0.f);
}

}  // namespace
}  // namespace facetloc::test

// SPDX-License-Identifier: BSD-3-Clause
// Sound input of the binary formats for the fuzzers to begin with, made by the code that writes these
// formats: make_seeds FOLDER writes FOLDER/<target>/<name>.
#include "../io/oni_writer.h"
#include "batch/bytes.h"
#include "small_map.h"

#include <facetloc/features/depth_distortion.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>
#include <facetloc/io/results.h>

#include <pcl/io/lzf_image_io.h>
#include <pcl/io/pcd_io.h>

#include <array>
#include <fstream>
#include <iostream>
#include <random>

namespace facetloc::fuzz {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <typename T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/** A plane that leans, with a hole. */
DepthImage leaningPlane() {
  DepthImage image{{8, 6, 7, 7, 3.5, 2.5}, {}};
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      image.depth.push_back(u == 3 && v == 2 ? 0.f : 1 + 0.1f * static_cast<float>(u + 2 * v));
  return image;
}

std::vector<std::uint16_t> millimetres(const DepthImage& image) {
  std::vector<std::uint16_t> values;
  for (const float z : image.depth) values.push_back(static_cast<std::uint16_t>(1000 * z));
  return values;
}

/** An uncompressed TIFF of 8x6 floating-point values. */
std::string tiffOf(const std::string& pixels) {
  constexpr std::uint16_t kShort = 3, kLong = 4;
  const auto size = static_cast<std::uint32_t>(pixels.size());
  std::string file = "II" + bytesOf<std::uint16_t>({42}) + bytesOf<std::uint32_t>({8 + size}) + pixels;
  const std::vector<std::array<std::uint32_t, 3>> entries = {
      {256, kLong, 8}, {257, kLong, 6},  {258, kShort, 32}, {259, kShort, 1},   {262, kShort, 1},
      {273, kLong, 8}, {277, kShort, 1}, {278, kLong, 6},   {279, kLong, size}, {339, kShort, 3}};
  file += bytesOf<std::uint16_t>({static_cast<std::uint16_t>(entries.size())});
  for (const auto& [tag, type, value] : entries)
    file += bytesOf<std::uint16_t>({static_cast<std::uint16_t>(tag), static_cast<std::uint16_t>(type)}) +
            bytesOf<std::uint32_t>({1, value});
  return file + bytesOf<std::uint32_t>({0});
}

class Seeds {
public:
  explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}

  fs::path operator()(const char* target, const char* name) const {
    createFolders(folder_ / target);
    return folder_ / target / name;
  }
  void put(const char* target, const char* name, const std::string& bytes) const {
    writeTextAtomically((*this)(target, name), [&](std::ostream& out) { out << bytes; });
  }

private:
  fs::path folder_;
};

void makeMaps(const Seeds& seeds) {
  seeds.put("map_bytes", "small.flmap", smallMapFile());
  seeds.put("place_index", "small", indexOf(smallMap()));
  // Values of cells are drawn from any bytes.
  std::mt19937 random(1);
  for (const char* name : {"a", "b", "c", "d"}) {
    std::vector<std::uint32_t> bytes(64);
    for (std::uint32_t& value : bytes) value = random();
    seeds.put("map_cells", name, bytesOf(bytes));
  }
}

void makeRecordings(const Seeds& seeds) {
  const auto put = [&seeds](const char* name, bool old, const char* codec, const std::string& frame) {
    test::OniWriter writer(old);
    writer.node(7, 3, "JPEG").mode(7, 8, 8).node(5, 2, codec).mode(5, 4, 2).view(5, 1.0, 0.5);
    seeds.put("oni", name, writer.property(5, "xnMirror", 1).frame(5, 1, frame).frame(5, 2, frame).end());
  };
  const std::string raw = bytesOf<std::uint16_t>({0, 1000, 1001, 1002, 2000, 2001, 2002, 65535});
  put("raw", false, "NONE", raw);
  put("old", true, "NONE", raw);
  // 0, 1000, 1001, 1002, the same twice, 1001, 1029.
  put("differences", false, "16zP", {0, 0, '\xFF', 3, '\xE8', '\x55', '\xE1', '\x7D', '\xFF', '\xA4'});
  put("table", false, "16zT", bytesOf<std::uint16_t>({2, 0, 1000, 0}) + "\x5D\xE3");
}

/** A text behind its size. */
std::string text(const std::string& words) {
  return bytesOf<std::uint32_t>({static_cast<std::uint32_t>(words.size())}) + words;
}

/** A message of ROS 1: an image of 4x2 pixels, by its encoding. */
std::string imageMessage() {
  const std::string header = bytesOf<std::uint32_t>({1, 2, 3}) + text("camera");
  return header + bytesOf<std::uint32_t>({2, 4}) + text("16UC1") + std::string(1, 0) +
         bytesOf<std::uint32_t>({8}) + text(bytesOf<std::uint16_t>({1, 2, 3, 4, 5, 6, 7, 8}));
}

/** A record of a bag: its fields, and its data. */
std::string bagRecord(const std::vector<std::string>& fields, const std::string& data) {
  std::string header;
  for (const std::string& field : fields) header += text(field);
  return text(header) + text(data);
}

/** A bag of ROS 1 with one image in a chunk. */
std::string bag() {
  const auto number = [](const char* name, std::uint32_t value) {
    return name + bytesOf<std::uint32_t>({value});
  };
  const auto place = [](const char* name, std::uint64_t value) {
    return name + bytesOf<std::uint64_t>({value});
  };
  const auto op = [](char code) { return std::string("op=") + code; };
  const std::string begin = "#ROSBAG V2.0\n", time = bytesOf<std::uint32_t>({5, 6});
  const std::string connection =
      bagRecord({op(7), number("conn=", 0), "topic=/depth"},
                text("topic=/depth") + text("type=sensor_msgs/Image") +
                    text("md5sum=060021388200f6f0f447d0fcd9c64743") + text("message_definition="));
  const std::string messages =
      connection + bagRecord({op(2), number("conn=", 0), "time=" + time}, imageMessage());
  const auto size = static_cast<std::uint32_t>(messages.size()),
             first = static_cast<std::uint32_t>(connection.size());
  const std::string chunk = bagRecord({op(5), "compression=none", number("size=", size)}, messages) +
                            bagRecord({op(4), number("ver=", 1), number("conn=", 0), number("count=", 1)},
                                      time + bytesOf<std::uint32_t>({first}));
  constexpr std::size_t kHeader = 4096;  // bytes of the first record
  const auto header = [&](std::size_t padding) {
    return bagRecord({op(3), place("index_pos=", begin.size() + kHeader + chunk.size()),
                      number("conn_count=", 1), number("chunk_count=", 1)},
                     std::string(padding, ' '));
  };
  const std::string info = bagRecord({op(6), number("ver=", 1), place("chunk_pos=", begin.size() + kHeader),
                                      "start_time=" + time, "end_time=" + time, number("count=", 1)},
                                     bytesOf<std::uint32_t>({0, 1}));
  return begin + header(kHeader - header(0).size()) + chunk + connection + info;
}

void makeMessages(const Seeds& seeds) {
  seeds.put("cdr", "image", "I" + imageMessage());
  const std::string header = bytesOf<std::uint32_t>({1, 2, 3}) + text("camera");
  const std::string rvl = bytesOf<std::uint32_t>({5, 1, 0x23C21400});
  seeds.put("cdr", "compressed",
            "C" + header + text("32FC1; compressedDepth rvl") + text(bytesOf<float>({0, 10, 1}) + rvl));
  seeds.put("cdr", "odometry", "O" + header + text("base") + std::string(700, 0));
  seeds.put("cdr", "info",
            "K" + header + bytesOf<std::uint32_t>({2, 4}) + text("plumb_bob") + std::string(260, 0));
  seeds.put("cdr", "tf", "T" + bytesOf<std::uint32_t>({1}) + header + text("base") + std::string(56, 0));
  seeds.put("bags", "ros1", "b" + bag());
  seeds.put("rvl", "five", rvl);
  seeds.put("rtabmap", "rvl", "dDEPTHRVL" + rvl);
  seeds.put("rtabmap", "pose", "p" + bytesOf<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
  seeds.put("rtabmap", "camera",
            "c" + bytesOf<std::uint32_t>({0, 21, 1, 0, 4, 2, 9, 0, 0, 0, 0}) +
                bytesOf<double>({5, 0, 2, 0, 5, 1, 0, 0, 1}));
}

void makeImages(const Seeds& seeds) {
  const DepthImage image = leaningPlane();
  writeDepthPng(seeds("png", "depth.png"), image, 1000);
  writePng(seeds("png", "grey.png"), Raster<std::uint8_t>{3, 2, 1, {0, 1, 2, 3, 4, 5}});
  writePng(seeds("png", "colour.png"), Raster<std::uint8_t>{2, 1, 3, {0, 1, 2, 3, 4, 5}});

  pcl::PointCloud<pcl::PointXYZ> cloud(8, 6);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud[i].getVector3fMap() = image.depth[i] * image.camera.ray(int(i) % 8, int(i) / 8).cast<float>();
  pcl::io::savePCDFileASCII(seeds("pcd", "ascii.pcd"), cloud);
  pcl::io::savePCDFileBinary(seeds("pcd", "binary.pcd"), cloud);
  pcl::io::savePCDFileBinaryCompressed(seeds("pcd", "compressed.pcd"), cloud);

  const std::string numbers = bytesOf(millimetres(image)), floats = bytesOf(image.depth);
  const auto npy = [](const char* type) {
    std::string header = std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (6, 8), }";
    header.resize(118, ' ');
    return std::string("n\x93NUMPY\x01\0", 9) + std::string("\x76\0", 2) + header;
  };
  seeds.put("depth_formats", "whole.npy", npy("<u2") + numbers);
  seeds.put("depth_formats", "floats.npy", npy("<f4") + floats);
  seeds.put("depth_formats", "a.pgm", "gP5\n8 6\n65535\n" + numbers);
  seeds.put("depth_formats", "a.pfm", "fPf\n8 6\n-1.0\n" + floats);
  seeds.put("depth_formats", "a.tif", "t" + tiffOf(floats));

  const Folder folder;
  const std::string camera = folder.path() / "camera.xml", lzf = folder.path() / "image.pclzf";
  pcl::io::LZFDepth16ImageWriter writer;
  writer.write(reinterpret_cast<const char*>(millimetres(image).data()), 8, 6, lzf);
  writer.writeParameters({7, 7, 3.5, 2.5}, camera);
  seeds.put("pclzf", "image", contentOf(camera) + '\0' + contentOf(lzf));
}

void makeMessagesAndResults(const Seeds& seeds) {
  const auto put = [&seeds](char type, const char* name, const auto& value) {
    seeds.put("messages", name, type + toBytes(value));
  };
  put('n', "number", std::size_t(3));
  put('N', "numbers", std::vector<std::size_t>{3, 4, 5});
  put('t', "texts", std::vector<std::string>{"a", "", "a longer one"});
  put('d', "no_distortion", ModelsOrder{{3, 4}, {}});
  put('d', "distortion",
      ModelsOrder{{3, 4}, DepthDistortion(DepthDistortion::extentOf(kinectIntrinsics()), {})});
  put('m', "model", packed(smallMap().models[0], *smallMap().view(0)));
  FrameResult result;
  result.timing = {"frame", 1, 2, 3, 4};
  result.rows.resize(2);
  result.rows[1].T_w_c = Eigen::Isometry3d::Identity();
  put('r', "result", LocalizedImage{result, {1, 2, 3}});

  const Folder folder;
  for (std::size_t i = 0; i < result.rows.size(); ++i)
    result.rows[i].frame = "frame", result.rows[i].rank = static_cast<int>(i) + 1;
  writeResults(folder.path(), {result}, "");
  seeds.put("resume", "tables",
            contentOf(folder.path() / "hypotheses.csv") + '\0' +
                contentOf(folder.path() / "covariances.csv") + '\0' +
                contentOf(folder.path() / "timing.csv"));
}

}  // namespace
}  // namespace facetloc::fuzz

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "Usage: make_seeds FOLDER\n";
    return 2;
  }
  using namespace facetloc::fuzz;
  const Seeds seeds(argv[1]);
  makeMaps(seeds);
  makeRecordings(seeds);
  makeMessages(seeds);
  makeImages(seeds);
  makeMessagesAndResults(seeds);
}

// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/io/png.h>

#include <random>

namespace facetloc::test {
namespace {

class OccupancyGridFiles : public InAFolder {
protected:
  void put(const std::string& name, const std::string& bytes) const { putBytes(folder_ / name, bytes); }
  OccupancyGrid read(const std::string& yaml) const {
    put("map.yaml", yaml);
    return readOccupancyGrid(folder_ / "map.yaml");
  }
  std::string errorOf(const std::string& yaml) const {
    return ioErrorOf([&] { read(yaml); });
  }
};

// Two rows, the upper one first in the image: black, white, grey; nearly white, dark, white.
constexpr const char* kTwoRows = "P2\n# two rows\n3 2\n255\n0 254 205\n250 30 254\n";
constexpr const char* kUsual = "image: two.pgm\nresolution: 0.050000\norigin: [-1.5, 2.0, 0.25]\nnegate: 0\n"
                               "occupied_thresh: 0.65\nfree_thresh: 0.196\n";

TEST_F(OccupancyGridFiles, AnImageNamedByThePathOfAnotherMachineIsFoundInTheFolder) {
  put("two.pgm", kTwoRows);
  for (const std::string elsewhere : {"/elsewhere/maps/", "C:\\maps\\", "../maps/"}) {
    std::string yaml = kUsual;
    yaml.replace(yaml.find("two.pgm"), 0, elsewhere);
    put("map.yaml", yaml);
    Findings findings;
    EXPECT_EQ(readOccupancyGrid(folder_ / "map.yaml", &findings).width, 3) << elsewhere;
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].id, "plan.image");
    EXPECT_THAT(findings[0].words, HasSubstr("two.pgm beside map.yaml"));
  }
  EXPECT_THAT(errorOf("image: /maps/three.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"),
              HasSubstr("three.pgm"));
}

TEST_F(OccupancyGridFiles, AreReadAsMapServerReadsThem) {
  put("two.pgm", kTwoRows);
  const OccupancyGrid grid = read(kUsual);
  EXPECT_EQ(grid.width, 3);
  EXPECT_EQ(grid.height, 2);
  EXPECT_EQ(grid.resolution, 0.05);
  EXPECT_EQ(grid.origin, Eigen::Vector2d(-1.5, 2));
  EXPECT_EQ(grid.yaw, 0.25);
  EXPECT_THAT(grid.cells, ElementsAre(0, 100, 0, 100, 0, -1)) << "the lower row first";
  // The middle of the third cell of the second row, turned about the origin.
  const double c = std::cos(0.25), s = std::sin(0.25);
  EXPECT_NEAR(
      (grid.centre(2, 1) - Eigen::Vector2d(-1.5 + c * 0.125 - s * 0.075, 2 + s * 0.125 + c * 0.075)).norm(),
      0, 1e-12);
  EXPECT_NEAR((grid.cellOf(grid.centre(2, 1)) - Eigen::Vector2d(2.5, 1.5)).norm(), 0, 1e-9);
}

TEST_F(OccupancyGridFiles, HaveThreeModesAndTwoSigns) {
  put("two.pgm", kTwoRows);
  const std::string usual = kUsual;
  EXPECT_THAT(read(usual + "mode: raw\n").cells, ElementsAre(-1, 30, -1, 0, -1, -1));
  // 0.19608 of occupation, just above the threshold: 1 + 98 * (0.19608 - 0.196) / 0.454.
  EXPECT_THAT(read(usual + "mode: scale\n").cells, ElementsAre(0, 100, 0, 100, 0, 1));
  std::string negated = usual;
  negated.replace(negated.find("negate: 0"), 9, "negate: 1");
  EXPECT_THAT(read(negated).cells, ElementsAre(100, 0, 100, 0, 100, 100));
  EXPECT_THAT(errorOf(usual + "mode: fancy\n"), HasSubstr("fancy"));
}

TEST_F(OccupancyGridFiles, TheGreyOfUnknownCellsIsUnknownWhateverTheThresholds) {
  const auto readWith = [&](const std::string& free, Findings& findings) {
    std::string yaml = kUsual;
    yaml.replace(yaml.find("0.196"), 5, free);
    put("map.yaml", yaml);
    return readOccupancyGrid(folder_ / "map.yaml", &findings).cells;
  };
  put("two.pgm", kTwoRows);
  Findings findings;
  EXPECT_THAT(readWith("0.196", findings), ElementsAre(0, 100, 0, 100, 0, -1));
  EXPECT_TRUE(findings.empty());
  EXPECT_THAT(readWith("0.25", findings), ElementsAre(0, 100, 0, 100, 0, -1));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].id, "plan.unknown");
  EXPECT_THAT(findings[0].text(), HasSubstr("1 of 6 cells"));
  put("two.pgm", "P2 3 2 255\n0 205 205\n100 30 0\n");
  EXPECT_THAT(readWith("0.25", findings), ElementsAre(-1, 100, 100, 100, 0, 0)) << "no other cell is free";
  EXPECT_EQ(findings.size(), 1u);
}

TEST_F(OccupancyGridFiles, MayBeBinaryWideAndPng) {
  put("two.pgm", std::string("P5 3 2 255\n") + std::string("\x00\xFE\xCD\xFA\x1E\xFE", 6));
  const auto usual = read(kUsual).cells;
  put("two.pgm", kTwoRows);
  EXPECT_EQ(read(kUsual).cells, usual);
  put("two.pgm",
      std::string("P5 3 2 65535\n") + std::string("\x00\x00\xFE\xFE\xCD\xCD\xFA\xFA\x1E\x1E\xFE\xFE", 12));
  EXPECT_EQ(read(kUsual).cells, usual);
  Raster<std::uint8_t> image;
  image.width = 3, image.height = 2, image.data = {0, 254, 205, 250, 30, 254};
  writePng(folder_ / "my plan.png", image);
  std::string png = kUsual;
  png.replace(png.find("two.pgm"), 7, "\"my plan.png\"  # drawn");
  EXPECT_EQ(read(png).cells, usual);
}

TEST_F(OccupancyGridFiles, ReadBackAsTheyWereWritten) {
  OccupancyGrid grid = OccupancyGrid::filled(7, 5, 0.1, {-3.25, 1e-3}, OccupancyGrid::kUnknown);
  grid.yaw = -2.5;
  std::mt19937 random(3);
  for (std::int8_t& cell : grid.cells) cell = std::array<std::int8_t, 3>{-1, 0, 100}[random() % 3];
  writeOccupancyGrid(folder_ / "plan.yaml", grid);
  const OccupancyGrid again = readOccupancyGrid(folder_ / "plan.yaml");
  EXPECT_EQ(again.cells, grid.cells);
  EXPECT_EQ(again.origin, grid.origin);
  EXPECT_EQ(again.yaw, grid.yaw);
  EXPECT_EQ(again.resolution, grid.resolution);
}

TEST_F(OccupancyGridFiles, NameTheirFaults) {
  put("two.pgm", kTwoRows);
  const auto without = [](const std::string& key) {
    std::string yaml = kUsual;
    const auto at = yaml.find(key + ":");
    return yaml.erase(at, yaml.find('\n', at) - at);
  };
  const auto with = [](const std::string& from, const std::string& to) {
    std::string yaml = kUsual;
    return yaml.replace(yaml.find(from), from.size(), to);
  };
  for (const char* key : {"image", "resolution", "origin"})
    EXPECT_THAT(errorOf(without(key)), HasSubstr(key));
  for (const char* key : {"negate", "occupied_thresh", "free_thresh"}) EXPECT_EQ(errorOf(without(key)), "");
  for (const char* value : {"0", "-0.05", "nan", ".inf", "wide", "[1, 2]", "1e999"})
    EXPECT_THAT(errorOf(with("0.050000", value)), HasSubstr("resolution")) << value;
  for (const char* value : {"[0, 0]", "[nan, 0, 0]", "[0, inf, 0]", "[]", "0"})
    EXPECT_THAT(errorOf(with("[-1.5, 2.0, 0.25]", value)), HasSubstr("origin")) << value;
  EXPECT_THAT(errorOf(with("0.196", "0.7")), HasSubstr("free_thresh"));
  EXPECT_THAT(errorOf(with("0.65", "1.5")), HasSubstr("occupied_thresh"));
  EXPECT_THAT(errorOf(with("negate: 0", "negate: 7")), HasSubstr("negate"));
  EXPECT_THAT(errorOf(with("two.pgm", "three.pgm")), HasSubstr("three.pgm"));
  EXPECT_THAT(errorOf(""), HasSubstr("map.yaml"));
}

TEST_F(OccupancyGridFiles, DistrustTheirImages) {
  const auto errorOfImage = [&](const std::string& bytes) {
    put("two.pgm", bytes);
    return errorOf(kUsual);
  };
  for (const char* bytes : {"P5 3000 3000 255\n", "P2 3000 3000 255\n1 2 3", "P5 3 2 255\nabc",
                            "P2 3 2 255\n1 2 3", "P5", "P2 3 2 255 1 2 3 4 5       ", ""})
    EXPECT_THAT(errorOfImage(bytes), HasSubstr("truncated")) << bytes;
  for (const char* bytes : {"P5 0 2 255\n", "P5 4000000000 4000000000 255\n"})
    EXPECT_THAT(errorOfImage(bytes), HasSubstr("claims")) << bytes;
  for (const char* bytes : {"P5 -3 2 255\n", "P5 99999999999 2 255\n", "P2 3 2 255 1 2 3 4 5 x    "})
    EXPECT_THAT(errorOfImage(bytes), HasSubstr("corrupt")) << bytes;
  for (const char* bytes : {"P5 3 2 0\n", "P5 3 2 70000\n"})
    EXPECT_THAT(errorOfImage(bytes), HasSubstr("largest value")) << bytes;
  EXPECT_THAT(errorOfImage("P2 3 2 255 1 2 3 4 5 256 "), HasSubstr("256"));
  EXPECT_THAT(errorOfImage("GIF89a"), HasSubstr("PGM"));
}

TEST_F(OccupancyGridFiles, GoByOneName) {
  EXPECT_EQ(occupancyGridPath("a/floor"), "a/floor.yaml");
  EXPECT_EQ(occupancyGridPath("a/floor.2"), "a/floor.2.yaml");
  EXPECT_EQ(occupancyGridPath("a/floor.yaml"), "a/floor.yaml");
  EXPECT_EQ(occupancyGridPath("a/"), "a/map.yaml");
  EXPECT_EQ(occupancyGridPath(folder_.path()), folder_ / "map.yaml");
}

}  // namespace
}  // namespace facetloc::test

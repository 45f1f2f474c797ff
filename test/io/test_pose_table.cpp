// SPDX-License-Identifier: BSD-3-Clause
// One trajectory in all the forms that people have.
#include "base/text.h"
#include "recordings/pose_table.h"
#include "temporary_folder.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/trajectory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

namespace facetloc::internal {
namespace {

using test::ioErrorOf;
using test::putBytes;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kPoses = 5;

double stampOf(int i) { return 1700000000.25 + 0.1 * i; }

Eigen::Isometry3d poseOf(int i) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3(Eigen::Vector3d(0.1 * i, -0.7, 0.3));
  T.translation() << 0.5 * i, -1, 2;
  return T;
}

std::string joined(const std::vector<double>& values, const std::string& separator = " ") {
  std::string line;
  for (const double value : values) line += (line.empty() ? "" : separator) + text::decimals(value, 9);
  return line;
}

/** tx ty tz, then the quaternion from x or from w on. */
std::vector<double> columnsOf(int i, bool w_first = false) {
  const Eigen::Isometry3d T = poseOf(i);
  const Eigen::Quaterniond q(T.linear());
  std::vector<double> c = {T.translation().x(), T.translation().y(), T.translation().z()};
  if (w_first) c.push_back(q.w());
  c.insert(c.end(), {q.x(), q.y(), q.z()});
  if (!w_first) c.push_back(q.w());
  return c;
}

std::vector<double> matrixOf(int i, int rows) {
  std::vector<double> m;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < 4; ++c) m.push_back(poseOf(i).matrix()(r, c));
  return m;
}

std::string table(const std::function<std::string(int)>& line, const std::string& header = "") {
  std::string text = header;
  for (int i = 0; i < kPoses; ++i) text += line(i) + "\n";
  return text;
}

void expectPoses(const std::string& text, bool stamped, const std::string& form) {
  const PoseTable found = parsePoseTable(text, "poses.txt");
  EXPECT_EQ(found.stamped, stamped) << form;
  ASSERT_EQ(found.rows.size(), static_cast<std::size_t>(kPoses)) << form;
  for (int i = 0; i < kPoses; ++i) {
    const PoseRow& row = found.rows[static_cast<std::size_t>(i)];
    if (stamped) {
      EXPECT_NEAR(row.stamp * found.unit.seconds, stampOf(i), 1e-6) << form;
    }
    ASSERT_TRUE(row.T_w_c) << form;
    EXPECT_TRUE(row.T_w_c->isApprox(poseOf(i), 1e-6)) << form << "\n" << row.T_w_c->matrix();
  }
}

std::string errorOf(const std::string& text) {
  return ioErrorOf([&] { parsePoseTable(text, "poses.txt"); });
}

TEST(PoseTable, RowsWithStamps) {
  const auto tum = [](const std::string& separator) {
    return [separator](int i) {
      return text::decimals(stampOf(i), 6) + separator + joined(columnsOf(i), separator);
    };
  };
  expectPoses(table(tum(" ")), true, "TUM");
  expectPoses(table(tum("  \t")), true, "blanks");
  expectPoses(table(tum(","), "timestamp,tx,ty,tz,qx,qy,qz,qw\n"), true, "commas and a header");
  expectPoses(table(tum(", ")), true, "commas and blanks");
  expectPoses(table(tum(";")), true, "semicolons");
  expectPoses(table(tum(" "), "timestamp tx ty tz qx qy qz qw\n"), true, "a header");
  expectPoses(table(tum(" "), "#timestamp [s] p_x p_y p_z q_x q_y q_z q_w\r\n"), true,
              "a header as a comment");
  expectPoses(table([&](int i) { return tum(" ")(i) + " " + std::to_string(i + 1); },
                    "#timestamp x y z qx qy qz qw id\n"),
              true, "RTAB-Map");
  expectPoses(table([&](int i) { return tum(" ")(i) + " " + std::to_string(i + 1); }), true,
              "a number behind");
  expectPoses(table([&](int i) { return std::to_string(i + 1) + " " + tum(" ")(i); }), true,
              "a number in front");
  expectPoses(table([](int i) { return text::decimals(stampOf(i), 6) + " " + joined(matrixOf(i, 3)); }), true,
              "3x4");
  expectPoses(table([](int i) { return text::decimals(stampOf(i), 6) + " " + joined(matrixOf(i, 4)); }), true,
              "4x4");
  std::string commas = table(tum(" "));
  std::replace(commas.begin(), commas.end(), '.', ',');
  expectPoses(commas, true, "decimal commas");
  std::string semicolons = table(tum(";"));
  std::replace(semicolons.begin(), semicolons.end(), '.', ',');
  expectPoses(semicolons, true, "decimal commas between semicolons");
}

TEST(PoseTable, TheHeaderSaysWhichColumnIsWhat) {
  const auto scaled = [](double unit, int digits) {
    return [=](int i) { return text::decimals(stampOf(i) / unit, digits); };
  };
  const auto ns = scaled(1e-9, 0);
  expectPoses(
      table(
          [&](int i) { return ns(i) + "," + joined(columnsOf(i, true), ","); },
          "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n"),
      true, "EuRoC");
  expectPoses(table([&](int i) { return joined(columnsOf(i, true), ",") + "," + ns(i); },
                    "x,y,z,qw,qx,qy,qz,time_ns\n"),
              true, "another order");
  expectPoses(table(
                  [&](int i) {
                    return text::decimals(stampOf(i), 6) + ", " + std::to_string(i) + ", " +
                           joined(columnsOf(i), ", ");
                  },
                  "timestamp, frame, x, y, z, qx, qy, qz, qw\n"),
              true, "a phone's odometry.csv");
  expectPoses(table(
                  [&](int i) {
                    return "1700000000," + text::decimals((stampOf(i) - 1700000000) * 1e9, 0) + "," +
                           joined(columnsOf(i), ",");
                  },
                  "secs,nsecs,position.x,position.y,position.z,orientation.x,orientation.y,orientation.z,"
                  "orientation.w\n"),
              true, "ROS");
}

TEST(PoseTable, StampsInOtherUnitsAreKnownByTheirSize) {
  for (const double unit : {1e-3, 1e-6, 1e-9})
    expectPoses(
        table([unit](int i) { return text::decimals(stampOf(i) / unit, 0) + " " + joined(columnsOf(i)); }),
        true, std::to_string(unit));
  // Stamps of a clock that begins with the recording have their unit from their steps.
  const PoseTable ns = parsePoseTable(
      table([](int i) { return std::to_string(100000000 * i) + " " + joined(columnsOf(i)); }), "poses.txt");
  EXPECT_EQ(ns.unit.seconds, 1e-9);
}

TEST(PoseTable, EurocsRowsOfSeventeenAreNoMatrices) {
  expectPoses(table([](int i) {
                return text::decimals(stampOf(i) * 1e9, 0) + "," + joined(columnsOf(i, true), ",") +
                       ",0.1,0.2,0.3,0,0,0,0,0,0";
              }),
              true, "EuRoC without a header");
}

TEST(PoseTable, RowsWithoutStamps) {
  expectPoses(table([](int i) { return joined(matrixOf(i, 3)); }), false, "KITTI");
  expectPoses(table([](int i) { return joined(matrixOf(i, 4)); }), false, "Replica");
  expectPoses(table([](int i) { return joined(columnsOf(i)); }), false, "seven numbers");
  const auto stacked = [](int i) {
    const std::vector<double> m = matrixOf(i, 4);
    std::string lines;
    for (int r = 0; r < 4; ++r) lines += joined({m.begin() + 4 * r, m.begin() + 4 * r + 4}) + "\n";
    return lines;
  };
  expectPoses(table(stacked), false, "4x4 on lines of their own");
  expectPoses(table([&](int i) { return std::to_string(i) + " " + std::to_string(i) + " 5\n" + stacked(i); }),
              false, "Redwood");
}

TEST(PoseTable, LostPosesAreRowsWithoutAPose) {
  const std::string good = "1 " + joined(columnsOf(1)) + "\n";
  for (const char* lost : {"2 nan nan nan nan nan nan nan", "2 0 0 0 0 0 0 0", "2 NaN NaN NaN 0 0 0 1",
                           "2 1 2 3 -nan -nan -nan -nan", "2 inf 0 0 0 0 0 1"}) {
    const PoseTable found = parsePoseTable(good + lost + "\n3 " + joined(columnsOf(2)) + "\n", "poses.txt");
    ASSERT_EQ(found.rows.size(), 3u) << lost;
    EXPECT_EQ(found.lost(), 1u) << lost;
    EXPECT_FALSE(found.rows[1].T_w_c) << lost;
  }
  EXPECT_EQ(parsePoseTable("0 0 0 0 0 0 0 0 0 0 0 0\n" + joined(matrixOf(1, 3)) + "\n", "p").lost(), 1u);
}

TEST(PoseTable, NamesTheLineOfAFault) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_THAT(errorOf(good + "2 0 0 0 0 0 0\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("7 columns instead of 8")));
  EXPECT_THAT(errorOf("1 2 3 4 5 6\n"),
              AllOf(HasSubstr("line 1"), HasSubstr("6 columns"), HasSubstr("matrix")));
  EXPECT_THAT(errorOf(good + "2 0 0 zero 0 0 0 1\n"), HasSubstr("'zero'"));
  EXPECT_THAT(errorOf(good + "2 0 0 0 1 0 0 1\n"), AllOf(HasSubstr("line 2"), HasSubstr("rotation")));
  EXPECT_THAT(errorOf(good + "2 0 0 2e6 0 0 0 1\n"), HasSubstr("more than 1000 km away"));
  EXPECT_THAT(errorOf(good + "nan 0 0 0 0 0 0 1\n"), HasSubstr("stamp"));
  EXPECT_THAT(errorOf("1e30 0 0 0 0 0 0 1\n"), HasSubstr("impossible"));
  EXPECT_THAT(errorOf(joined(matrixOf(1, 3)) + "\n1 1 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("not a pose"));
  EXPECT_THAT(errorOf("1 0 0 0\n0 1 0 0\n0 0 1 0\n"), HasSubstr("four rows"));
  EXPECT_THAT(errorOf(std::string("\0\x89PNG\xFF", 6)), HasSubstr("line 1"));
  EXPECT_THAT(errorOf("nonsense\n"), HasSubstr("line 1"));
  EXPECT_THAT(errorOf("stamp 2 of 3\n" + good), HasSubstr("line 1"));
  EXPECT_EQ(errorOf(""), "");
  EXPECT_EQ(errorOf("# nothing yet\n"), "");
}

TEST(PoseTable, Utf16IsReadWithAndWithoutItsMark) {
  const TemporaryFolder folder;
  const std::string text =
      table([](int i) { return text::decimals(stampOf(i), 6) + " " + joined(columnsOf(i)); });
  for (const int kind : {0, 1, 2, 3}) {
    const bool big_endian = kind % 2 == 1;
    std::string bytes = kind > 1 ? "" : big_endian ? "\xFE\xFF" : "\xFF\xFE";
    for (const char c : text) bytes += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
    putBytes(folder / "poses.txt", bytes);
    const Trajectory read = readTrajectory(folder / "poses.txt");
    ASSERT_EQ(read.poses().size(), static_cast<std::size_t>(kPoses));
    EXPECT_TRUE(read.poses()[2].T_w_c.isApprox(poseOf(2), 1e-6));
  }
}

TEST(PoseTable, ATrajectoryHasStampsAndARemarkOnConversions) {
  const TemporaryFolder folder;
  putBytes(folder / "rows.txt", table([](int i) { return joined(matrixOf(i, 3)); }));
  EXPECT_THAT(ioErrorOf([&] { readTrajectory(folder / "rows.txt"); }), HasSubstr("without time stamps"));
  std::string remark;
  putBytes(folder / "ns.txt", "1700000000000000000 0 0 0 0 0 0 1\n1700000000100000000 0 0 0 0 0 0 0\n");
  EXPECT_EQ(readTrajectory(folder / "ns.txt", &remark).poses().size(), 1u);
  EXPECT_THAT(remark, AllOf(HasSubstr("nanoseconds"), HasSubstr("1 of its 2 poses is lost")));
}

// ---- Whose they are

ImageTimes counted(int n) {
  ImageTimes images;
  images.unit = {1 / kFrameRate, true};
  for (int i = 0; i < n; ++i) images.numbers.push_back(i), images.stamps.push_back(i / kFrameRate);
  return images;
}

TEST(MatchedPoses, RowsWithoutStampsAreThoseOfTheImagesInTheirOrder) {
  const PoseTable rows = parsePoseTable(table([](int i) { return joined(matrixOf(i, 3)); }), "p");
  ImageTimes images;
  for (int i = 0; i < kPoses; ++i) images.stamps.push_back(stampOf(i));
  const ReadPoses read = matched(rows, images, "p");
  EXPECT_THAT(read.remark, HasSubstr("in their order"));
  for (int i = 0; i < kPoses; ++i) EXPECT_TRUE(read.poses.at(stampOf(i))->isApprox(poseOf(i), 1e-6));
  images.stamps.pop_back();
  EXPECT_THAT(ioErrorOf([&] { matched(rows, images, "p"); }),
              AllOf(HasSubstr("5 poses without time stamps"), HasSubstr("4 images")));
}

TEST(MatchedPoses, TheNumberOfAnImageIsTheIndexOfItsRow) {
  const PoseTable rows = parsePoseTable(table([](int i) { return joined(matrixOf(i, 3)); }), "p");
  ImageTimes images = counted(3);
  images.numbers = {0, 2, 4};
  const ReadPoses read = matched(rows, images, "p");
  EXPECT_TRUE(read.poses.at(images.stamps[1])->isApprox(poseOf(2), 1e-6));
  images.numbers = {0, 2, 5};
  EXPECT_THAT(ioErrorOf([&] { matched(rows, images, "p"); }),
              HasSubstr("they cannot be assigned to each other"));
}

TEST(MatchedPoses, CountedImagesTakeStampsThatAreTheirNumbers) {
  const PoseTable rows =
      parsePoseTable(table([](int i) { return std::to_string(i) + " " + joined(columnsOf(i)); }), "p");
  const ReadPoses read = matched(rows, counted(4), "p");
  EXPECT_TRUE(read.poses.at(3 / kFrameRate)->isApprox(poseOf(3), 1e-6));
}

TEST(MatchedPoses, CountedImagesWithTimesAreRefusedUnlessTheyAreAsMany) {
  const PoseTable rows = parsePoseTable(
      table([](int i) { return text::decimals(0.1 * i, 3) + " " + joined(columnsOf(i)); }), "p");
  EXPECT_THAT(ioErrorOf([&] { matched(rows, counted(4), "p"); }), HasSubstr("numbers and no times"));
  EXPECT_TRUE(matched(rows, counted(5), "p").poses.at(4 / kFrameRate)->isApprox(poseOf(4), 1e-6));
}

TEST(MatchedPoses, RowNumbersForStampsAreNoTimes) {
  const PoseTable rows =
      parsePoseTable(table([](int i) { return std::to_string(i) + " " + joined(columnsOf(i)); }), "p");
  ImageTimes images;
  for (int i = 0; i < kPoses; ++i) images.stamps.push_back(stampOf(i)), images.numbers.push_back(stampOf(i));
  EXPECT_TRUE(matched(rows, images, "p").poses.at(stampOf(2))->isApprox(poseOf(2), 1e-6));
  images.stamps.pop_back(), images.numbers.pop_back();
  EXPECT_THAT(ioErrorOf([&] { matched(rows, images, "p"); }), HasSubstr("numbered"));
}

// ---- How they are written

TEST(PoseReading, KnowsItsWords) {
  EXPECT_TRUE(PoseReading::of("auto").isUsual());
  const PoseReading both = PoseReading::of("wxyz, inverse");
  EXPECT_TRUE(both.w_first && both.inverse);
  EXPECT_EQ(PoseReading::of("opengl").axes, PoseReading::Axes::opengl);
  EXPECT_THROW(PoseReading::of("left"), std::invalid_argument);
}

TEST(PoseReading, GivesThePoseOfTheOpticalFrame) {
  const Eigen::Isometry3d T = poseOf(3);
  const auto read = [](const char* words, const Eigen::Isometry3d& written,
                       const std::optional<Eigen::Isometry3d>& T_b_c = {}) {
    return readAs(PoseReading::of(words), Trajectory({{1, written}}), T_b_c).poses()[0].T_w_c;
  };
  EXPECT_TRUE(read("inverse", T.inverse()).isApprox(T, 1e-9));
  Eigen::Isometry3d opengl = T;
  opengl.linear() = T.linear() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  EXPECT_TRUE(read("opengl", opengl).isApprox(T, 1e-9));
  const Eigen::Quaterniond q(T.linear());
  Eigen::Isometry3d shuffled = T;
  shuffled.linear() =
      Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();  // w x y z as x y z w
  EXPECT_TRUE(read("wxyz", shuffled).isApprox(T, 1e-9));
  CameraMounting mounting{0.9, 10};
  mounting.x = 0.2;
  EXPECT_TRUE(read("base", T * mounting.T_b_c().inverse(), mounting.T_b_c()).isApprox(T, 1e-9));
  Eigen::Isometry3d body = Eigen::Isometry3d::Identity();
  EXPECT_TRUE(read("base", body).linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-9)) << "forward is x";
}

}  // namespace
}  // namespace facetloc::internal

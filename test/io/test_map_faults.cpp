// SPDX-License-Identifier: BSD-3-Clause
// Map files of other formats, and files of others.
// Map files that are damaged.
#include "map_file.h"

#include <sqlite3.h>

#include <algorithm>
#include <memory>
#include <random>
#include <utility>

namespace facetloc::test {
namespace {

TEST_F(MapFile, OtherFilesAreRefused) {
  putBytes(path_, "");
  EXPECT_THAT(readError(), HasSubstr("not a map"));
  putBytes(path_, "a text that is no database at all, however long it may go on");
  EXPECT_THAT(readError(), HasAll("not a map", "no SQLite"));
  EXPECT_NE(ioErrorOf([&] { checkMap(path_); }), "");
  EXPECT_NE(ioErrorOf([&] { MapDatabase::open(path_); }), "");
  std::filesystem::remove(path_);
  sql(path_, "CREATE TABLE model(id INTEGER)");
  EXPECT_THAT(readError(), HasAll("not a map", "another application"));
}

TEST_F(MapFile, ANewerMajorFormatIsRefused) {
  writeExample();
  sql(path_, "PRAGMA user_version = " + std::to_string(2 << 16));
  const std::string expected = "map format 2.0 is newer than this program understands (1.x)";
  EXPECT_THAT(readError(), HasAll("room.flmap", expected));
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::open(path_); }), HasSubstr(expected));
  EXPECT_THAT(ioErrorOf([&] { checkMap(path_); }), HasSubstr(expected));
}

TEST_F(MapFile, OfAnUnreleasedVersionIsRefused) {
  for (const char* version : {"7", "1000", "1007", "-1"}) {
    writeExample();
    sql(path_, std::string("PRAGMA user_version = ") + version);
    const std::string expected = "written by an unreleased version of facetloc: build the map again";
    EXPECT_THAT(readError(), HasAll("room.flmap", expected));
    EXPECT_THAT(ioErrorOf([&] { openMap(path_); }), HasSubstr(expected));
    EXPECT_THAT(ioErrorOf([&] { MapDatabase::open(path_); }), HasSubstr(expected));
    EXPECT_THAT(ioErrorOf([&] { checkMap(path_); }), HasSubstr(expected));
  }
}

TEST_F(MapFile, ANewerMinorFormatWithMoreColumnsAndTablesIsRead) {
  writeExample();
  sql(path_, "PRAGMA user_version = " + std::to_string((1 << 16) + 9) +
                 "; ALTER TABLE segment ADD COLUMN colour TEXT;"
                 "ALTER TABLE model ADD COLUMN place TEXT DEFAULT 'home'; CREATE TABLE photo(id INTEGER, "
                 "data BLOB);");
  const Map read = readMap(path_);
  expectEqualModels(ExampleMap().map(3), read);
  EXPECT_THAT(checkMap(path_), IsEmpty());
  EXPECT_EQ(MapDatabase::open(path_).add(ExampleMap(9).model("more"), ExampleMap(9).view()), 3);
}

TEST_F(MapFile, ReadingChangesNoByte) {
  writeExample();
  const std::string before = bytesOf(path_);
  const auto time = std::filesystem::last_write_time(path_);
  readMap(path_);
  checkMap(path_);
  EXPECT_EQ(bytesOf(path_), before);
  EXPECT_EQ(std::filesystem::last_write_time(path_), time);
  EXPECT_EQ(folder_.count(), 1);
}

TEST_F(MapFile, AReadOnlyFileCanBeRead) {
  writeExample();
  std::filesystem::permissions(path_, std::filesystem::perms::owner_read);
  EXPECT_EQ(readMap(path_).models.size(), 3u);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, TheTablesThemselvesRefuseNonsense) {
  writeExample();
  for (const char* statement :
       {"UPDATE segment SET var_sx = 0", "UPDATE segment SET qw = 2", "UPDATE segment SET tx = 'far'",
        "UPDATE segment SET lambda1 = 0", "UPDATE segment SET hull = x'00'", "UPDATE model SET tx = NULL",
        "UPDATE model SET name = 'same'", "UPDATE link SET to_id = from_id",
        "UPDATE link SET from_id = 0, to_id = 1", "UPDATE camera SET mount_x = NULL",
        "UPDATE camera SET fx = 3", "UPDATE camera SET distortion_top = 1",
        "UPDATE depth_picture SET inverse_depth_std = 0"}) {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
    EXPECT_NE(sqlite3_exec(db, statement, nullptr, nullptr, nullptr), SQLITE_OK) << statement;
    sqlite3_close(db);
  }
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, FaultsAreDescribedInWords) {
  const std::pair<const char*, const char*> cases[] = {
      {"UPDATE segment SET var_sx = -1 WHERE model_id = 1 AND idx = 2", "segment 2 of model 1: its Sigma_q"},
      {"UPDATE segment SET cov_sx_sy = 5 WHERE model_id = 1 AND idx = 2",
       "segment 2 of model 1: its Sigma_q"},
      {"UPDATE segment SET tx = 9e999 WHERE model_id = 0 AND idx = 0", "segment 0 of model 0: its pose"},
      {"UPDATE segment SET qw = 3 WHERE model_id = 0 AND idx = 0", "segment 0 of model 0: its pose"},
      {"UPDATE segment SET lambda2 = -1 WHERE model_id = 0 AND idx = 1", "segment 1 of model 0: its lambda"},
      {"UPDATE segment SET hull = x'0000' WHERE model_id = 0 AND idx = 1", "segment 1 of model 0: its hull"},
      {"UPDATE segment SET hull = zeroblob(8000) WHERE model_id = 0", "segment 1 of model 0: its hull"},
      {"UPDATE segment SET hull = x'0000C07F0000C07F' WHERE model_id = 0",
       "segment 1 of model 0: its hull is not finite"},
      {"UPDATE segment SET num_points = -4 WHERE model_id = 0", "number of points"},
      {"DELETE FROM segment WHERE model_id = 2 AND idx = 1",
       "segment 2 of model 2: the segment numbers have a gap"},
      {"DELETE FROM segment WHERE model_id = 2 AND idx = 4", "num_segments says 5, but there are 4"},
      {"UPDATE segment SET model_id = 77 WHERE model_id = 2",
       "segment 0 of model 77: there is no such model"},
      {"UPDATE model SET id = 9 WHERE id = 2", "model 2: the model numbers have a gap"},
      {"UPDATE model SET qx = 5 WHERE id = 1", "model 1: its pose"},
      {"UPDATE model SET ty = NULL WHERE id = 1", "model 1: column ty is not a number"},
      {"UPDATE model SET fx = -5 WHERE id = 1", "model 1: its camera intrinsics"},
      {"UPDATE model SET width = 123456789012 WHERE id = 1", "model 1: column width is out of range"},
      {"UPDATE depth_picture SET data = x'1234' WHERE model_id = 1",
       "the depth picture of model 1: its depth picture is corrupt"},
      {"UPDATE depth_picture SET width = 41 WHERE model_id = 1",
       "the depth picture of model 1: its depth picture is corrupt"},
      {"UPDATE depth_picture SET width = 2000000 WHERE model_id = 1", "larger than its image"},
      {"UPDATE depth_picture SET encoding = 'jpeg' WHERE model_id = 1", "unknown encoding"},
      {"UPDATE link SET to_id = 12 WHERE id = 0", "there is no such model"},
      {"UPDATE link SET qw = 7 WHERE id = 0", "link 0: its pose"},
      {"UPDATE link SET c_rx_rx = -1 WHERE id = 0", "link 0: its covariance"},
      {"UPDATE link SET c_rx_rx = 0, c_rx_ry = 0, c_rx_rz = 0, c_rx_tx = 0, c_rx_ty = 0, c_rx_tz = 0",
       "link 0: its covariance is not positive definite"},
      {"UPDATE segment SET var_r = 1e-19, cov_sx_r = 0, cov_sy_r = 0 WHERE model_id = 1 AND idx = 2",
       "segment 2 of model 1: its Sigma_q is not positive definite, or smaller than any camera's"},
      {"UPDATE model SET tx = 2e6 WHERE id = 1", "model 1: its pose is more than 1000 km away"},
      {"UPDATE model SET stamp = 1e12 WHERE id = 1", "model 1: its stamp is impossible"},
      {"INSERT INTO ambiguity VALUES(0, 1e9, 5)", "the ambiguity: its score of wrong places is impossible"},
      {"INSERT INTO ambiguity VALUES(0, 1, -5)", "the ambiguity: its number of views is impossible"},
      {"UPDATE model SET lookalike_score = 1e9 WHERE id = 1",
       "model 1: its score of wrong places is impossible"},
      {"UPDATE camera SET mount_height = 5000", "the camera: its mounting is no place on a robot"},
      {"UPDATE camera SET mount_tilt_deg = 270", "the camera: its mounting is no place on a robot"},
      {"UPDATE camera SET mount_x = NULL", "the camera: column mount_x is not a number"},
      {"ALTER TABLE link RENAME TO l; CREATE TABLE link AS SELECT * FROM l; DROP TABLE l; "
       "UPDATE link SET from_id = 0, to_id = 1",
       "link 1: another one joins the same models"},
  };
  for (const auto& [statement, fault] : cases) {
    writeExample();
    vandalize(path_, statement);
    EXPECT_THAT(checkMap(path_), Contains(HasSubstr(fault))) << statement;
    EXPECT_NE(readError(), "") << statement;
  }
}

TEST_F(MapFile, ViewsInPlaceOfTablesAreRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"ALTER TABLE meta RENAME TO m; CREATE VIEW meta AS SELECT key, value FROM m", "it holds a view, meta"},
      {"CREATE TRIGGER more AFTER INSERT ON model BEGIN DELETE FROM link; END", "it holds a trigger, more"},
      {"CREATE VIRTUAL TABLE page USING dbstat", "its table page is virtual"},
      {"ALTER TABLE model ADD COLUMN large BLOB AS (zeroblob(1000000000))",
       "column large of its table model"},
      {"DROP TABLE link", "it has no table link"},
  };
  for (const auto& [statement, fault] : cases) {
    writeExample();
    vandalize(path_, statement);
    const auto says = HasAll("room.flmap", fault);
    EXPECT_THAT(readError(), says);
    EXPECT_THAT(ioErrorOf([this] { checkMap(path_); }), says);
    EXPECT_THAT(ioErrorOf([this] { openMap(path_); }), says);
    EXPECT_THAT(ioErrorOf([this] { MapDatabase::open(path_); }), says);
  }
}

TEST_F(MapFile, PicturesThatTakeMoreMemoryThanTheFileExplainsAreRefused) {
  Map map;
  View view = ExampleMap().view();
  view.intrinsics = {4096, 3072, 3000, 3000, 2047.5, 1535.5};
  view.depth = DepthPicture::fromStored(view.intrinsics, std::vector<std::uint16_t>(4096 * 3072));
  view.depth.noise.inverse_depth_std = 0.003;
  const auto shared = std::make_shared<const View>(std::move(view));
  for (int i = 0; i < 8; ++i) {
    map.models.emplace_back(std::to_string(i), 0);
    map.models.back().setView(shared);
  }
  writeMap(path_, map);
  EXPECT_THAT(readError(), HasSubstr("its depth pictures would take 603 MB of memory"));
  EXPECT_THAT(checkMap(path_), Contains(HasSubstr("MB of memory")));
  EXPECT_TRUE(openMap(path_).store()) << "views of more pixels stay in the file";
}

TEST_F(MapFile, CheckListsEveryFault) {
  writeExample();
  vandalize(path_, "UPDATE segment SET var_sx = -1 WHERE idx = 0; UPDATE link SET qw = 7 WHERE id = 0");
  const auto faults = checkMap(path_);
  for (const char* fault : {"segment 0 of model 0", "segment 0 of model 1", "segment 0 of model 2", "link 0"})
    EXPECT_THAT(faults, Contains(HasSubstr(fault)));
  EXPECT_THAT(readError(), HasAll("segment 0 of model 0", "more faults"));
}

TEST_F(MapFile,
       EmptyModelsAndSeveredGraphsAreSound) {  // images of nothing, merged maps, a build that was killed
  Map map = ExampleMap().map(4);
  changeView(map, 3, [](View& view) { view.segments.clear(); });
  map.links.erase(map.links.begin() + 1);
  writeMap(path_, map);
  EXPECT_EQ(readError(), "");
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, EveryTruncationIsAnError) {
  writeExample();
  const std::string bytes = bytesOf(path_);
  for (std::size_t size = 0; size < bytes.size(); size += 997) {
    putBytes(path_, bytes.substr(0, size));
    EXPECT_NE(readError(), "") << size;
  }
}

TEST_F(MapFile, FlippedBytesAreErrorsOrMaps) {
  writeExample();
  const std::string bytes = bytesOf(path_);
  std::mt19937 engine(42);
  int refused = 0;
  for (int i = 0; i < 1000; ++i) {
    std::string corrupt = bytes;
    // Every second flip hits the first pages, where the tables are described.
    const std::size_t range = i % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 8192);
    corrupt[engine() % range] ^= static_cast<char>(1 + engine() % 255);
    putBytes(path_, corrupt);
    refused += !readError().empty();
    ioErrorOf([this] { checkMap(path_); });
    ioErrorOf([this] { MapDatabase::open(path_).add(ExampleMap().model("one more"), ExampleMap().view()); });
  }
  EXPECT_GT(refused, 50);
  EXPECT_LT(refused, 1000);
}

}  // namespace
}  // namespace facetloc::test

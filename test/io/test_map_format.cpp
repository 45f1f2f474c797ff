// SPDX-License-Identifier: BSD-3-Clause
// Map files of other formats, and files of others.
#include "map_file.h"

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

}  // namespace
}  // namespace facetloc::test

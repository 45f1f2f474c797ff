// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/features/so3.h>
#include <facetloc/io/map_database.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>
#include <random>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace facetloc {
namespace {

using test::bytesOf;
using test::ExampleMap;
using test::ioErrorOf;
using test::putBytes;
using test::TemporaryFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/** Does to a map file what another program might. */
void sql(const std::filesystem::path& path, const std::string& statement) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  char* message = nullptr;
  sqlite3_exec(db, statement.c_str(), nullptr, nullptr, &message);
  EXPECT_STREQ(message, nullptr);
  sqlite3_free(message);
  sqlite3_close(db);
}

/** The same against the CHECKs of the tables. */
void vandalize(const std::filesystem::path& path, const std::string& statement) {
  sql(path, "PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF; " + statement);
}

void expectEqual(const Segment& a, const Segment& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_LT((a.R - b.R).cwiseAbs().maxCoeff(), 2e-15);
  EXPECT_LT((b.R.transpose() * b.R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 2e-15);
  EXPECT_EQ(a.Sigma_q, b.Sigma_q);
  EXPECT_EQ(a.lambda, b.lambda);
  EXPECT_EQ(a.num_points, b.num_points);
  ASSERT_EQ(a.hull.size, b.hull.size);
  for (int i = 0; i < a.hull.size; ++i) EXPECT_EQ(a.hull.vertex[i], b.hull.vertex[i]);
}

void expectEqual(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  EXPECT_EQ(a.translation(), b.translation());
  EXPECT_LT((a.linear() - b.linear()).cwiseAbs().maxCoeff(), 2e-15);
}

void expectEqual(const LocalModel& a, const LocalModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.stamp, b.stamp);
  ASSERT_EQ(a.T_w_m.has_value(), b.T_w_m.has_value());
  if (a.T_w_m) expectEqual(*a.T_w_m, *b.T_w_m);
  EXPECT_EQ(a.view.camera, b.view.camera);
  ASSERT_EQ(a.view.segments.size(), b.view.segments.size());
  for (std::size_t i = 0; i < a.view.segments.size(); ++i)
    expectEqual(a.view.segments[i], b.view.segments[i]);
  EXPECT_EQ(a.view.depth.camera, b.view.depth.camera);
  EXPECT_EQ(a.view.depth.inverse_depth, b.view.depth.inverse_depth);
  EXPECT_EQ(a.view.depth.lowest, b.view.depth.lowest);
}

class MapFile : public testing::Test {
protected:
  std::string readError() const {
    return ioErrorOf([this] { readMap(path_); });
  }
  void writeExample(int models = 3) const { writeMap(path_, ExampleMap().map(models)); }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "room.flmap";
};

TEST_F(MapFile, RoundTripsExactly) {
  Map map = ExampleMap().map(3);
  map.models[1].T_w_m.reset();
  map.models[2].view.depth = {};
  map.models[2].view.segments[0].hull.size = 0;
  map.models.push_back(ExampleMap(5).model("nothing seen; 'quotes' and Umlaute \xC3\xA4", 0));
  ASSERT_GE(map.links.size(), 2u);
  const Vector6d only = Vector6d::LinSpaced(0.1, 0.3);  // a covariance may be singular, even zero
  map.links.front().T_from_to.P = only * only.transpose();
  map.links.back().T_from_to.P.setZero();
  writeMap(path_, map);
  EXPECT_EQ(folder_.count(), 1);

  const Map read = readMap(path_);
  ASSERT_TRUE(read.mounting);
  EXPECT_EQ(read.mounting->height, 0.98);
  EXPECT_EQ(read.mounting->tilt_deg, 10.1);
  for (const auto& [key, value] : map.meta) EXPECT_EQ(read.meta.at(key), value);
  EXPECT_EQ(read.meta.at("format"), "facetloc map 1.2");
  EXPECT_THAT(read.meta.at("conventions"), HasSubstr("T_a_b"));
  ASSERT_EQ(read.models.size(), map.models.size());
  for (std::size_t i = 0; i < map.models.size(); ++i) expectEqual(map.models[i], read.models[i]);
  ASSERT_EQ(read.links.size(), map.links.size());
  for (std::size_t i = 0; i < map.links.size(); ++i) {
    EXPECT_EQ(read.links[i].from, map.links[i].from);
    EXPECT_EQ(read.links[i].to, map.links[i].to);
    expectEqual(map.links[i].T_from_to.T, read.links[i].T_from_to.T);
    EXPECT_EQ(read.links[i].T_from_to.P, map.links[i].T_from_to.P);
  }
}

DepthDistortion exampleDistortion() {
  DepthDistortion::Values values;
  for (int i = 0; i < DepthDistortion::kNodes; ++i) values[i] = 1e-3 * std::sin(i);
  return DepthDistortion(DepthDistortion::extentOf(kinectIntrinsics()), values);
}

TEST_F(MapFile, TheDistortionRoundTripsExactly) {
  Map map = ExampleMap().map(2);
  map.distortion = exampleDistortion();
  writeMap(path_, map);
  for (const Map& read : {readMap(path_), openMap(path_, 0)}) {
    ASSERT_TRUE(read.distortion);
    EXPECT_EQ(read.distortion->extent().min(), map.distortion->extent().min());
    EXPECT_EQ(read.distortion->extent().max(), map.distortion->extent().max());
    EXPECT_EQ(read.distortion->values(), map.distortion->values());
  }
  EXPECT_THAT(checkMap(path_), IsEmpty());
  MapDatabase::create(path_, true).setDistortion(exampleDistortion());
  EXPECT_EQ(readMap(path_).distortion->values(), map.distortion->values());
  writeExample();
  EXPECT_FALSE(readMap(path_).distortion);
}

TEST_F(MapFile, ATornDistortionIsAFault) {
  for (const char* damage :
       {"DELETE FROM distortion WHERE node = 62", "DELETE FROM distortion WHERE node = 7",
        "INSERT INTO distortion VALUES(63, 0, 0, 0)", "UPDATE distortion SET ray_x = -9 WHERE node = 62",
        "UPDATE distortion SET inverse_depth = 9e999 WHERE node = 3"}) {
    Map map = ExampleMap().map(1);
    map.distortion = exampleDistortion();
    writeMap(path_, map);
    sql(path_, damage);
    EXPECT_THAT(readError(), HasSubstr("the distortion")) << damage;
    EXPECT_THAT(checkMap(path_), Not(IsEmpty())) << damage;
  }
}

TEST_F(MapFile, AnEmptyMapIsLegal) {
  writeMap(path_, Map());
  EXPECT_THAT(readMap(path_).models, IsEmpty());
  EXPECT_FALSE(readMap(path_).mounting);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, SameMapSameBytes) {
  writeExample();
  writeMap(folder_ / "b.flmap", ExampleMap().map(3));
  EXPECT_EQ(bytesOf(path_), bytesOf(folder_ / "b.flmap"));
}

TEST_F(MapFile, IsTheSameWhetherBuiltStepByStepOrAtOnce) {
  const Map map = ExampleMap().map(3);
  {
    MapDatabase db = MapDatabase::create(path_);
    for (const auto& [key, value] : map.meta) db.setMeta(key, value);
    db.setMounting(*map.mounting);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(db.add(map.models[i]), i);
    for (const Link& link : map.links) db.add(link);
  }
  EXPECT_EQ(folder_.count(), 1) << "no journal is left";
  const Map read = readMap(path_);
  ASSERT_EQ(read.models.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) expectEqual(map.models[i], read.models[i]);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, IsTheSameWhoeverPacksItsModels) {
  LocalModel flat = ExampleMap().model("flat");
  flat.view.depth = {};
  const auto other = folder_ / "b.flmap";
  {
    MapDatabase mine = MapDatabase::create(path_), theirs = MapDatabase::create(other);
    for (const LocalModel& model : {ExampleMap().model("a"), flat}) {
      mine.add(model);
      theirs.add(packed(model));
    }
  }
  EXPECT_EQ(bytesOf(path_), bytesOf(other));
}

TEST_F(MapFile, ABuildCanBeResumed) {
  ExampleMap example;
  MapDatabase::create(path_).add(example.model("a"));
  MapDatabase db = MapDatabase::open(path_);
  EXPECT_THAT(db.modelNames(), ElementsAre("a"));
  EXPECT_EQ(db.add(example.model("b")), 1);
  db.add(example.link(1, 0));
  EXPECT_THAT(db.modelNames(), ElementsAre("a", "b"));
}

TEST_F(MapFile, AFailedAddLeavesTheMapAsItWas) {
  ExampleMap example;
  MapDatabase db = MapDatabase::create(path_);
  db.add(example.model("a"));
  EXPECT_THAT(ioErrorOf([&] { db.add(example.model("a")); }), HasSubstr("UNIQUE"));
  LocalModel bad = example.model("b");
  bad.view.segments[2].Sigma_q(0, 0) = -1;
  EXPECT_THAT(ioErrorOf([&] { db.add(bad); }),
              AllOf(HasSubstr("room.flmap"), HasSubstr("segment 2 of model 1 ('b')"),
                    HasSubstr("positive definite")));
  EXPECT_NE(ioErrorOf([&] { db.add(example.link(0, 5)); }), "");
  EXPECT_NE(ioErrorOf([&] { db.add(example.link(0, 0)); }), "");
  EXPECT_THAT(db.modelNames(), ElementsAre("a"));
  EXPECT_EQ(db.add(example.model("b")), 1);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, NonsenseIsNotWritten) {
  const auto errorWith = [this](const std::function<void(LocalModel&)>& spoil) {
    Map map = ExampleMap().map(1);
    spoil(map.models[0]);
    return ioErrorOf([&] { writeMap(path_, map); });
  };
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.segments[0].t.x() = NAN; }), HasSubstr("centroid"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.segments[0].R *= 2; }), HasSubstr("rotation"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.segments[0].R *= -1; }), HasSubstr("rotation"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.segments[0].lambda << 1, 2; }), HasSubstr("lambda"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.segments[0].hull.size = 25; }), HasSubstr("hull"));
  EXPECT_THAT(errorWith([](LocalModel& m) {
                ConvexHull& hull = m.view.segments[0].hull;
                std::reverse(hull.vertex.data(), hull.vertex.data() + hull.size);
              }),
              HasSubstr("its hull is not counter-clockwise"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.camera.fx = 0; }), HasSubstr("intrinsics"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.stamp = INFINITY; }), HasSubstr("stamp"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.T_w_m->translation().z() = NAN; }), HasSubstr("pose"));
  EXPECT_THAT(errorWith([](LocalModel& m) { m.view.depth.inverse_depth.pop_back(); }),
              HasSubstr("depth picture"));
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(MapFile, PicturesThatCouldNotBeReadAreNotWritten) {
  PackedModel model = packed(ExampleMap().model("a"));
  ASSERT_FALSE(model.depth.empty());
  model.model.view.depth.camera.width = 5000;
  MapDatabase db = MapDatabase::create(path_);
  EXPECT_THAT(ioErrorOf([&] { db.add(model); }), HasSubstr("its depth picture is too large"));
  EXPECT_THAT(db.modelNames(), IsEmpty());
}

TEST_F(MapFile, ExistingFilesAreNotOverwrittenByAccident) {
  writeExample();
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::create(path_); }), HasSubstr("exists"));
  EXPECT_EQ(readMap(path_).models.size(), 3u);
  MapDatabase::create(path_, true).add(ExampleMap().model("new"));
  EXPECT_EQ(readMap(path_).models.size(), 1u);
}

TEST_F(MapFile, AStaleJournalDoesNotHarmANewMap) {
  writeExample();
  putBytes(path_.string() + "-journal", "not a journal");
  putBytes(path_.string() + ".tmp-journal", "nor this");
  writeExample(2);
  EXPECT_EQ(readMap(path_).models.size(), 2u);
  EXPECT_EQ(folder_.count(), 1);
}

TEST_F(MapFile, MissingFoldersAndFilesAreErrors) {
  EXPECT_THAT(ioErrorOf([&] { writeMap(folder_ / "none/a.flmap", Map()); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::create(folder_ / "none/a.flmap"); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::open(path_); }), HasSubstr("does not exist"));
  EXPECT_THAT(readError(), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { checkMap(path_); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { readMap(folder_.path()); }), HasSubstr("folder"));
  EXPECT_NE(ioErrorOf([&] { MapDatabase::create(folder_.path(), true); }), "");
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(MapFile, OtherFilesAreRefused) {
  putBytes(path_, "");
  EXPECT_THAT(readError(), HasSubstr("not a map"));
  putBytes(path_, "a text that is no database at all, however long it may go on");
  EXPECT_THAT(readError(), AllOf(HasSubstr("not a map"), HasSubstr("no SQLite")));
  EXPECT_NE(ioErrorOf([&] { checkMap(path_); }), "");
  EXPECT_NE(ioErrorOf([&] { MapDatabase::open(path_); }), "");
  std::filesystem::remove(path_);
  sql(path_, "CREATE TABLE model(id INTEGER)");
  EXPECT_THAT(readError(), AllOf(HasSubstr("not a map"), HasSubstr("another application")));
}

TEST_F(MapFile, ANewerMajorFormatIsRefused) {
  writeExample();
  sql(path_, "PRAGMA user_version = 2000");
  const std::string expected = "map format 2.0 is newer than this program understands (1.x)";
  EXPECT_THAT(readError(), AllOf(HasSubstr("room.flmap"), HasSubstr(expected)));
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::open(path_); }), HasSubstr(expected));
  EXPECT_THAT(ioErrorOf([&] { checkMap(path_); }), HasSubstr(expected));
  sql(path_, "PRAGMA user_version = 7");
  EXPECT_THAT(readError(), HasSubstr("unknown"));
}

TEST_F(MapFile, AnOlderMinorFormatIsReadAndUpgradedWhenItIsWrittenTo) {
  writeExample();
  sql(path_, "DROP TABLE place_index; DROP TABLE distortion; PRAGMA user_version = 1000;"
             "UPDATE meta SET value = 'facetloc map 1.0' WHERE key = 'format'");
  EXPECT_EQ(readMap(path_).meta.at("format"), "facetloc map 1.0");
  EXPECT_THAT(checkMap(path_), IsEmpty());
  EXPECT_EQ(openMap(path_, 0).store->placeIndex(), nullptr);
  EXPECT_EQ(MapDatabase::open(path_).add(ExampleMap(9).model("more")), 3);
  EXPECT_EQ(readMap(path_).meta.at("format"), "facetloc map 1.2");
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, ANewerMinorFormatWithMoreColumnsAndTablesIsRead) {
  writeExample();
  sql(path_,
      "PRAGMA user_version = 1003; ALTER TABLE segment ADD COLUMN colour TEXT;"
      "ALTER TABLE model ADD COLUMN place TEXT DEFAULT 'home'; CREATE TABLE photo(id INTEGER, data BLOB);");
  const Map read = readMap(path_);
  ASSERT_EQ(read.models.size(), 3u);
  const Map map = ExampleMap().map(3);
  for (std::size_t i = 0; i < 3; ++i) expectEqual(map.models[i], read.models[i]);
  EXPECT_THAT(checkMap(path_), IsEmpty());
  EXPECT_EQ(MapDatabase::open(path_).add(ExampleMap(9).model("more")), 3);
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

TEST_F(MapFile, ReservedMetaBelongsToTheFormat) {
  MapDatabase db = MapDatabase::create(path_);
  EXPECT_THROW(db.setMeta("format", "mine"), std::invalid_argument);
  db.setMeta("a", "1");
  db.setMeta("a", "2");
  EXPECT_EQ(readMap(path_).meta.at("a"), "2");
}

TEST_F(MapFile, TheTablesThemselvesRefuseNonsense) {
  writeExample();
  for (const char* statement :
       {"UPDATE segment SET var_sx = 0", "UPDATE segment SET qw = 2", "UPDATE segment SET tx = 'far'",
        "UPDATE segment SET lambda1 = 0", "UPDATE segment SET hull = x'00'", "UPDATE model SET tx = NULL",
        "UPDATE model SET name = 'same'", "UPDATE link SET to_id = from_id"}) {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
    EXPECT_NE(sqlite3_exec(db, statement, nullptr, nullptr, nullptr), SQLITE_OK) << statement;
    sqlite3_close(db);
  }
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, FaultsAreToldInWords) {
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
      {"UPDATE depth_picture SET width = 2000000 WHERE model_id = 1", "too large"},
      {"UPDATE depth_picture SET encoding = 'jpeg' WHERE model_id = 1", "unknown encoding"},
      {"UPDATE link SET to_id = 12 WHERE id = 0", "there is no such model"},
      {"UPDATE link SET qw = 7 WHERE id = 0", "link 0: its pose"},
      {"UPDATE link SET c_rx_rx = -1 WHERE id = 0", "link 0: its covariance"},
      {"DROP TABLE link", "no such table: link"},
  };
  for (const auto& [statement, fault] : cases) {
    writeExample();
    vandalize(path_, statement);
    EXPECT_THAT(checkMap(path_), Contains(HasSubstr(fault))) << statement;
    EXPECT_NE(readError(), "") << statement;
  }
}

TEST_F(MapFile, CheckTellsEveryFault) {
  writeExample();
  vandalize(path_, "UPDATE segment SET var_sx = -1 WHERE idx = 0; UPDATE link SET qw = 7 WHERE id = 0");
  const auto faults = checkMap(path_);
  for (const char* fault : {"segment 0 of model 0", "segment 0 of model 1", "segment 0 of model 2", "link 0"})
    EXPECT_THAT(faults, Contains(HasSubstr(fault)));
  EXPECT_THAT(readError(), AllOf(HasSubstr("segment 0 of model 0"), HasSubstr("more faults")));
}

TEST_F(MapFile,
       EmptyModelsAndSeveredGraphsAreSound) {  // images of nothing, merged maps, a build that was killed
  Map map = ExampleMap().map(4);
  map.models[3].view.segments.clear();
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
  for (int i = 0; i < 400; ++i) {
    std::string corrupt = bytes;
    // Every second flip hits the first pages, where the tables are described.
    const std::size_t range = i % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 8192);
    corrupt[engine() % range] ^= static_cast<char>(1 + engine() % 255);
    putBytes(path_, corrupt);
    refused += !readError().empty();
    ioErrorOf([this] { checkMap(path_); });
    ioErrorOf([this] { MapDatabase::open(path_).add(ExampleMap().model("one more")); });
  }
  EXPECT_GT(refused, 20);
  EXPECT_LT(refused, 400);
}

TEST_F(MapFile, AFullDiskLeavesTheOldMap) {
  writeExample();
  const std::string before = bytesOf(path_);
  // A limit of file sizes stands in for a full disk.
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const struct rlimit limit = {32768, 32768};
    setrlimit(RLIMIT_FSIZE, &limit);
    const bool failed = !ioErrorOf([this] { writeMap(path_, ExampleMap().map(60)); }).empty();
    _exit(failed ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(bytesOf(path_), before);
  EXPECT_EQ(folder_.count(), 1);
}

/** A child process that adds models for ever and tells each one by a byte in a pipe. */
class Builder {
public:
  explicit Builder(const std::filesystem::path& path) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ == 0) {
      close(ends[0]);
      try {
        ExampleMap example;
        MapDatabase db = MapDatabase::open(path);
        for (;;) {
          db.add(example.model("model " + std::to_string(db.modelNames().size()), 25));
          if (write(ends[1], "+", 1) != 1) _exit(2);
        }
      } catch (...) {
        _exit(3);
      }
    }
    close(ends[1]);
    told_ = ends[0];
  }
  /** \brief Kills the child and returns how many models it has told; -1 if it ended by itself. */
  int kill() {
    ::kill(child_, SIGKILL);
    int status = 0;
    waitpid(child_, &status, 0);
    while (waitForModel()) {
    }
    close(told_);
    return WIFSIGNALED(status) ? count_ : -1;
  }
  /** \brief False once the child has ended and all that it told is counted. */
  bool waitForModel() {
    char byte;
    const bool told = read(told_, &byte, 1) == 1;
    count_ += told;
    return told;
  }

private:
  pid_t child_ = -1;
  int told_ = -1;
  int count_ = 0;
};

TEST_F(MapFile, SurvivesBeingKilled) {
  constexpr int kRounds = 15;
  MapDatabase::create(path_);
  std::mt19937 engine(3);
  int promised = 0;
  for (int round = 0; round < kRounds; ++round) {
    Builder builder(path_);
    if (round == 0) builder.waitForModel();  // however slow the disk, there is something to lose
    std::this_thread::sleep_for(std::chrono::microseconds(2000 + engine() % 30000));
    const int told = builder.kill();
    ASSERT_GE(told, 0) << "the builder failed";
    promised += told;
    const Map map = readMap(path_);
    EXPECT_GE(static_cast<int>(map.models.size()), promised);
    EXPECT_LE(static_cast<int>(map.models.size()), promised + 1) << "at most one was not told any more";
    EXPECT_THAT(checkMap(path_), IsEmpty());
    promised = static_cast<int>(map.models.size());
  }
  EXPECT_GT(promised, 0);
}

TEST_F(MapFile, AnUnfinishedTransactionIsRolledBack) {
  writeExample();
  const auto killed = folder_ / "killed.flmap";
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
  // A cache of one page makes SQLite write to the file before it commits.
  const char* half =
      "PRAGMA cache_size = 1; BEGIN; UPDATE segment SET num_points = 1; UPDATE model SET stamp = 0;"
      "DELETE FROM depth_picture;";
  ASSERT_EQ(sqlite3_exec(db, half, nullptr, nullptr, nullptr), SQLITE_OK);
  std::filesystem::copy_file(path_, killed);
  std::filesystem::copy_file(path_.string() + "-journal", killed.string() + "-journal");
  sqlite3_close(db);
  ASSERT_NE(bytesOf(killed), bytesOf(path_)) << "the copy is half written";

  EXPECT_THAT(checkMap(killed), IsEmpty());
  EXPECT_EQ(bytesOf(killed), bytesOf(path_));
  EXPECT_EQ(readMap(killed).models.size(), 3u);
}

TEST_F(MapFile, AReaderSeesTheMapOfOneTimeWhoeverWrites) {
  writeExample(3);
  std::atomic<bool> done = false;
  std::thread writer([&] {
    MapDatabase map = MapDatabase::open(path_);
    for (int i = 0; i < 150; ++i) {
      LocalModel model = ExampleMap(9).model("more" + std::to_string(i));
      map.add(model);
    }
    done = true;
  });
  std::size_t models = 0;
  while (!done) {
    const Map map = readMap(path_);  // throws if segments of a model are there that itself is not
    EXPECT_GE(map.models.size(), models);
    models = map.models.size();
    EXPECT_GE(openMap(path_, 1).models.size(), models);
  }
  writer.join();
}

TEST_F(MapFile, AMapThatCannotBeCreatedLeavesNoFile) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit none = {4096, 4096};  // less than a map takes
    std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &none);
    try {
      MapDatabase::create(path_);
    } catch (const IoError&) {
      _exit(std::filesystem::exists(path_) ? 2 : 0);
    }
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(MapFile, ManyReadersAtOnce) {
  writeExample();
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([this] {
      for (int k = 0; k < 20; ++k) EXPECT_EQ(readMap(path_).models.size(), 3u);
    });
  for (auto& thread : threads) thread.join();
}

// ---- views that stay in the file

TEST_F(MapFile, ASmallMapIsOpenedAsAWhole) {
  writeExample(3);
  EXPECT_EQ(openMap(path_, 3).store, nullptr);
  EXPECT_FALSE(openMap(path_, 3).models[2].view.segments.empty());
  EXPECT_NE(openMap(path_, 2).store, nullptr);
}

TEST_F(MapFile, AMapWhoseViewsStayInTheFileIsTheSameMap) {
  Map map = ExampleMap().map(4);
  map.models[2].view.depth = {};
  map.models[3].view.segments.clear();
  writeMap(path_, map);
  const Map whole = readMap(path_), opened = openMap(path_, 2);
  ASSERT_EQ(opened.models.size(), whole.models.size());
  EXPECT_EQ(opened.links.size(), whole.links.size());
  EXPECT_EQ(opened.meta, whole.meta);
  EXPECT_TRUE(opened.mounting);
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < 4; ++i) {
      LocalModel model = opened.models[i];
      EXPECT_TRUE(model.view.segments.empty());
      EXPECT_TRUE(model.view.depth.empty());
      EXPECT_EQ(model.hasPicture(), i != 2);
      model.view = *opened.view(i);
      expectEqual(whole.models[i], model);
      expectEqual(whole.models[i], {model.name, model.stamp, model.T_w_m, *whole.view(i)});
    }
}

TEST_F(MapFile, ViewsThatWereAskedForLastStayInMemory) {
  writeExample(4);
  const Map opened = openMap(path_, 2);
  const auto first = opened.view(0);
  opened.view(1);
  EXPECT_EQ(opened.view(0), first);
  opened.view(2);  // in place of 1
  EXPECT_EQ(opened.view(0), first);
  opened.view(1), opened.view(2);
  EXPECT_NE(opened.view(0), first);
  EXPECT_EQ(opened.view(0)->segments.size(), first->segments.size());  // and the old one is still there
}

TEST_F(MapFile, ViewsCanBeAskedForByManyThreads) {
  writeExample(8);
  const Map whole = readMap(path_), opened = openMap(path_, 3);
  std::vector<std::thread> threads;
  std::array<int, 4> different{};
  for (std::size_t t = 0; t < different.size(); ++t)
    threads.emplace_back([&, t] {
      for (int n = 0; n < 300; ++n) {
        const int i = static_cast<int>((n * (2 * t + 1)) % 8);
        different[t] += opened.view(i)->depth.inverse_depth != whole.models[i].view.depth.inverse_depth;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(different, testing::Each(0));
}

TEST_F(MapFile, AViewThatIsNotSoundIsToldWhenItIsAskedFor) {
  writeExample(3);
  vandalize(path_, "UPDATE depth_picture SET data = x'00' WHERE model_id = 1");
  vandalize(path_, "DELETE FROM segment WHERE model_id = 2 AND idx = 1");
  const Map opened = openMap(path_, 0);
  EXPECT_EQ(opened.view(0)->segments.size(), 3u);
  EXPECT_THAT(ioErrorOf([&] { opened.view(1); }),
              AllOf(HasSubstr("room.flmap"), HasSubstr("model 1: its depth picture is corrupt")));
  EXPECT_THAT(ioErrorOf([&] { opened.view(2); }), HasSubstr("model 2: its segment numbers have a gap"));
  EXPECT_THAT(ioErrorOf([&] { opened.view(3); }), HasSubstr("no such model"));
  EXPECT_EQ(opened.view(0)->segments.size(), 3u) << "that of others can still be had";
  EXPECT_NE(ioErrorOf([&] { openMap(path_); }), "") << "a small map is checked at once";
}

TEST_F(MapFile, AnOpenMapCanBeWrittenTo) {
  writeExample(3);
  const Map opened = openMap(path_, 1);
  opened.view(0);
  EXPECT_EQ(MapDatabase::open(path_).add(ExampleMap(9).model("more")), 3);
  EXPECT_EQ(opened.view(2)->segments.size(), 5u);
}

// ---- the place index

class PlaceIndexInAMapFile : public MapFile {
protected:
  void SetUp() override {
    writeExample(3);
    std::mt19937 engine(3);
    for (int i = 0; i < 2500000; ++i)
      bytes_.push_back(static_cast<char>(engine()));  // of more than two parts
    write();
  }
  void write() {
    MapDatabase::open(path_).setPlaceIndex([this](std::ostream& out) {
      out.put(bytes_[0]);
      out.write(bytes_.data() + 1, static_cast<std::streamsize>(bytes_.size()) - 1);
    });
  }
  std::string read() const {
    const Map map = openMap(path_, 0);
    const auto in = map.store->placeIndex();
    if (!in) return "";
    std::string found(bytes_.size(), '\0');
    in->read(found.data(), static_cast<std::streamsize>(found.size()));
    EXPECT_EQ(in->peek(), std::istream::traits_type::eof());
    return found;
  }
  std::string bytes_;
};

TEST_F(PlaceIndexInAMapFile, IsReadAsItWasWritten) {
  EXPECT_TRUE(read() == bytes_);
  EXPECT_THAT(checkMap(path_), IsEmpty());
  bytes_ = "another one";
  write();
  EXPECT_EQ(read(), bytes_);
}

TEST_F(PlaceIndexInAMapFile, IsGoneWhenAModelIsAdded) {
  MapDatabase::open(path_).add(ExampleMap(9).model("more"));
  EXPECT_EQ(read(), "");
}

TEST_F(PlaceIndexInAMapFile, IsNotReplacedByOneThatCannotBeWritten) {
  EXPECT_THROW(MapDatabase::open(path_).setPlaceIndex([](std::ostream& out) {
    out << "half of it";
    throw std::runtime_error("stop");
  }),
               std::runtime_error);
  EXPECT_TRUE(read() == bytes_);
}

TEST_F(PlaceIndexInAMapFile, ACorruptOneIsToldInWords) {
  sql(path_, "UPDATE place_index SET data = zeroblob(100) WHERE part = 1");
  EXPECT_THAT(checkMap(path_), Contains(HasSubstr("the place index: part 1 is corrupt")));
  EXPECT_THAT(ioErrorOf([this] { read(); }), HasSubstr("its place index: part 1 is corrupt"));
  sql(path_, "DELETE FROM place_index WHERE part = 1");
  EXPECT_THAT(checkMap(path_), Contains(HasSubstr("the place index: a part is missing")));
  EXPECT_THAT(ioErrorOf([this] { read(); }), HasSubstr("its place index: part 1 is missing"));
}

}  // namespace
}  // namespace facetloc

// SPDX-License-Identifier: BSD-3-Clause
// Views that stay in the map file.
// The place index in a map file.
#include "map_file.h"

#include <algorithm>
#include <array>
#include <istream>
#include <ostream>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

namespace facetloc::test {
namespace {

TEST_F(MapFile, ASmallMapIsOpenedAsAWhole) {
  writeExample(3);
  EXPECT_EQ(openMap(path_, 3).store(), nullptr);
  EXPECT_FALSE(openMap(path_, 3).view(2)->segments.empty());
  EXPECT_NE(openMap(path_, 2).store(), nullptr);
}

TEST_F(MapFile, AMapWhoseViewsStayInTheFileIsTheSameMap) {
  Map map = ExampleMap().map(4);
  changeView(map, 2, [](View& view) { view.depth = {}; });
  changeView(map, 3, [](View& view) { view.segments.clear(); });
  writeMap(path_, map);
  const Map whole = readMap(path_), opened = openMap(path_, 2);
  EXPECT_EQ(opened.links.size(), whole.links.size());
  EXPECT_EQ(opened.meta, whole.meta);
  EXPECT_TRUE(opened.camera.mounting);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(opened.models[i].hasPicture(), i != 2);
  for (int pass = 0; pass < 2; ++pass) expectEqualModels(whole, opened);
}

TEST_F(MapFile, LocalModelsOfAnOpenMapKeepTheirViewsInOtherMaps) {
  writeExample(4);
  const Map whole = readMap(path_);
  Map opened = openMap(path_, 0);
  std::reverse(opened.models.begin(), opened.models.end());
  Map some;
  some.models = {opened.models[2], whole.models[2]};
  expectEqual(*opened.view(0), *whole.view(3));
  expectEqual(*some.view(0), *whole.view(1));
  EXPECT_EQ(some.view(1), whole.view(2)) << "copies share a view in memory";
  writeMap(folder_ / "some.flmap", some);
  expectEqualModels(readMap(folder_ / "some.flmap"), some);
}

TEST_F(MapFile, ViewsThatWereAskedForLastStayInMemory) {
  writeExample(4);
  const Map opened = openMap(path_, 2);
  const auto first = opened.view(0);
  opened.view(1);
  EXPECT_EQ(opened.view(0), first);
  opened.view(2);  // replaces 1
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
        different[t] += opened.view(i)->depth.inverse_depth != whole.view(i)->depth.inverse_depth;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(different, Each(0));
}

TEST_F(MapFile, AnInvalidViewIsReportedWhenItIsRequested) {
  writeExample(3);
  vandalize(path_, "UPDATE depth_picture SET data = x'00' WHERE model_id = 1");
  vandalize(path_, "DELETE FROM segment WHERE model_id = 2 AND idx = 1");
  const Map opened = openMap(path_, 0);
  EXPECT_EQ(opened.view(0)->segments.size(), 3u);
  EXPECT_THAT(ioErrorOf([&] { opened.view(1); }),
              HasAll("room.flmap", "model 1: its depth picture is corrupt"));
  EXPECT_THAT(ioErrorOf([&] { opened.view(2); }), HasSubstr("model 2: its segment numbers have a gap"));
  EXPECT_THAT(ioErrorOf([&] { opened.store()->view(3); }), HasSubstr("no such model"));
  EXPECT_EQ(opened.view(0)->segments.size(), 3u) << "views of others can still be had";
  EXPECT_NE(ioErrorOf([&] { openMap(path_); }), "") << "a small map is checked at once";
}

TEST_F(MapFile, AnOpenMapCanBeWrittenTo) {
  writeExample(3);
  const Map opened = openMap(path_, 1);
  opened.view(0);
  EXPECT_EQ(MapDatabase::open(path_).add(ExampleMap(9).model("more"), ExampleMap(9).view()), 3);
  EXPECT_EQ(opened.view(2)->segments.size(), 5u);
}

class PlaceIndexInAMapFile : public MapFile {
protected:
  void SetUp() override {
    writeExample(3);
    std::mt19937 engine(3);
    for (int i = 0; i < 2500000; ++i) bytes_.push_back(static_cast<char>(engine()));  // more than two parts
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
    const auto in = map.store()->placeIndex();
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
  MapDatabase::open(path_).add(ExampleMap(9).model("more"), ExampleMap(9).view());
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

TEST_F(PlaceIndexInAMapFile, ACorruptOneIsDescribedInWords) {
  sql(path_, "UPDATE place_index SET data = zeroblob(100) WHERE part = 1");
  EXPECT_THAT(checkMap(path_), Contains(HasSubstr("the place index: part 1 is corrupt")));
  EXPECT_THAT(ioErrorOf([this] { read(); }), HasSubstr("its place index: part 1 is corrupt"));
  sql(path_, "DELETE FROM place_index WHERE part = 1");
  EXPECT_THAT(checkMap(path_), Contains(HasSubstr("the place index: a part is missing")));
  EXPECT_THAT(ioErrorOf([this] { read(); }), HasSubstr("its place index: part 1 is missing"));
}

}  // namespace
}  // namespace facetloc::test

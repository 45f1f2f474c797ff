// SPDX-License-Identifier: BSD-3-Clause
// A place index that is written and read, and maps whose views are elsewhere.
#include "place_index_rooms.h"
#include "ranking/global_localization.h"
#include "shortlist/place_descriptor.h"
#include "shortlist/shortlist.h"

#include <facetloc/localization/place_index.h>

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::allBatches, test::facing, test::kMounting, test::onFloor, test::PlaceIndexOfRooms;

// Keeps the views of a map, and perhaps its index, somewhere else.
class Store : public MapStore {
public:
  explicit Store(const Map& map, std::string index = "") : map_(map), index_(std::move(index)) {}
  std::shared_ptr<const View> view(int i) const override {
    ++asked;
    return map_.view(i);
  }
  bool hasPicture(int i) const override { return map_.models[i].hasPicture(); }
  std::unique_ptr<std::istream> placeIndex() const override {
    return index_.empty() ? nullptr : std::make_unique<std::istringstream>(index_);
  }
  mutable std::atomic<int> asked{0};

private:
  Map map_;
  std::string index_;
};

Map kept(const Map& map, std::shared_ptr<const Store> store) {
  Map light = map;
  light.setStore(std::move(store));
  return light;
}

std::string written(const PlaceIndex& index) {
  std::ostringstream out;
  index.write(out);
  return out.str();
}

TEST_F(PlaceIndexOfRooms, IsTheSameAfterItWasWrittenAndRead) {
  const PlaceIndex made(*map, few());
  const std::string bytes = written(made);
  EXPECT_EQ(written(PlaceIndex(*map, few())), bytes);
  const auto store = std::make_shared<const Store>(*map, bytes);
  const Map light = kept(*map, store);
  const PlaceIndex read = PlaceIndex::of(light, few());
  EXPECT_EQ(store->asked, 0) << "no view is needed";
  EXPECT_EQ(read.models(), made.models());
  EXPECT_EQ(read.descriptors(), made.descriptors());
  EXPECT_EQ(written(read), bytes);
  for (unsigned i = 0; i < 6; ++i) {
    const View view = query(int(i % kRooms), 0.9 * i, 800 + i);
    EXPECT_EQ(read.shortlist(view, 50), made.shortlist(view, 50));
  }
}

TEST_F(PlaceIndexOfRooms, IsWrittenAndReadWithoutTemporaryFiles) {
  GTEST_FLAG_SET(death_test_style, "fast");  // runs in this process as it is
  const PlaceIndex index(*map);
  const auto writeAndRead = [&] {
    const rlimit nothing{0, 0};
    if (setrlimit(RLIMIT_FSIZE, &nothing) != 0) std::_Exit(2);
    std::istringstream bytes(written(index));
    std::_Exit(PlaceIndex::read(bytes, *map).has_value() ? 0 : 1);
  };
  EXPECT_EXIT(writeAndRead(), testing::ExitedWithCode(0), "");
}

TEST_F(PlaceIndexOfRooms, IsMadeAnewWhereTheWrittenOneIsForSomethingElse) {
  const std::string bytes = written(PlaceIndex(*map, few()));
  const auto reads = [&bytes](const Map& other, const PosePriorParams& prior = {}) {
    std::istringstream in(bytes);
    return PlaceIndex::read(in, other, {}, prior).has_value();
  };
  EXPECT_TRUE(reads(*map));
  Map other = *map;
  other.models.pop_back();
  EXPECT_FALSE(reads(other));
  other = *map;
  other.camera.mounting->tilt_deg += 1;
  EXPECT_FALSE(reads(other));
  other = *map;
  other.camera.mounting->pan_deg += 1;
  EXPECT_FALSE(reads(other));
  PosePriorParams prior;
  prior.robot.floor_std *= 2;
  EXPECT_FALSE(reads(*map, prior));
  other = *map;
  std::swap(other.models[3].name, other.models[4].name);
  EXPECT_FALSE(reads(other));
  prior = {};
  prior.rotation_std_deg *= 2;  // does not matter to it
  EXPECT_TRUE(reads(*map, prior));
  EXPECT_EQ(PlaceIndex::of(kept(other, std::make_shared<const Store>(other, bytes))).models(),
            other.models.size());
  std::istringstream torn(bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(PlaceIndex::read(torn, *map), std::runtime_error);
}

TEST_F(PlaceIndexOfRooms, OfAnotherFormatIsNotRead) {
  std::string bytes = written(PlaceIndex(*map, few()));
  const std::string format = "facetloc place index 1.0";
  const auto at = bytes.find(format);
  ASSERT_NE(at, std::string::npos);
  bytes[at + format.size() - 1] = '1';
  std::istringstream in(bytes);
  EXPECT_FALSE(PlaceIndex::read(in, *map));
}

TEST_F(PlaceIndexOfRooms, BytesThatClaimTooManyWallsAreRefused) {
  std::string bytes = written(PlaceIndex(*map, few()));
  std::array<std::int32_t, 5> facing = placeDescriptor(*map->view(0), kMounting).facing;
  const auto asBytes = [&facing] {
    return std::string(reinterpret_cast<const char*>(facing.data()), sizeof facing);
  };
  const std::size_t at = bytes.find(asBytes());
  ASSERT_NE(at, std::string::npos);
  for (const std::int32_t wrong : {1000, -1}) {
    facing.back() = wrong;
    std::istringstream in(bytes.replace(at, sizeof facing, asBytes()));
    EXPECT_THROW(PlaceIndex::read(in, *map), std::runtime_error) << wrong;
  }
}

TEST_F(PlaceIndexOfRooms, NumbersThatNoPlaceHasAreRefused) {
  const std::string bytes = written(PlaceIndex(*map, few()));
  const PlaceDescriptor place = placeDescriptor(*map->view(0), kMounting);
  ASSERT_FALSE(place.walls.empty());
  const Wall& wall = place.walls.front();
  const std::array<float, 4> numbers{wall.heading, wall.cosine, wall.sine, wall.offset};
  const std::size_t at =
      bytes.find(std::string(reinterpret_cast<const char*>(numbers.data()), sizeof numbers));
  ASSERT_NE(at, std::string::npos);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    for (const float wrong : {NAN, INFINITY, -1e30f}) {
      std::string other = bytes;
      other.replace(at + i * sizeof wrong, sizeof wrong, reinterpret_cast<const char*>(&wrong), sizeof wrong);
      std::istringstream in(other);
      EXPECT_THROW(PlaceIndex::read(in, *map), std::runtime_error) << i << " " << wrong;
    }
}

TEST_F(PlaceIndexOfRooms, BytesOfATornPictureAreRefused) {
  std::string bytes = written(PlaceIndex(*map, few()));
  const Intrinsics camera = placeDescriptor(*map->view(0), kMounting).picture.camera;
  const std::string size(reinterpret_cast<const char*>(&camera), 2 * sizeof camera.width);
  const std::size_t at = bytes.find(size);
  ASSERT_NE(at, std::string::npos);
  const int wider = camera.width + 1;
  bytes.replace(at, sizeof wider, reinterpret_cast<const char*>(&wider), sizeof wider);
  std::istringstream in(bytes);
  EXPECT_THROW(PlaceIndex::read(in, *map), std::runtime_error);
}

TEST_F(PlaceIndexOfRooms, NoModelIsAskedAboutAViewThatNoneCouldPlace) {
  const auto isFloor = [](const Eigen::Vector3d& n) { return n.z() < -0.98; };
  const auto store = std::make_shared<const Store>(*map);
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 1000000;
  const auto light = std::make_shared<const Map>(kept(*map, store));
  const GlobalLocalization localization(light, params);
  const View view = facing(query(0, 0.3, 900), isFloor);
  ASSERT_FALSE(view.segments.empty());
  const std::vector<Batch> batches = allBatches(Shortlist(light, params), onFloor(view), true, 1);
  ASSERT_EQ(batches.size(), 1u);
  EXPECT_TRUE(batches[0].empty());
  const Localization answer = localization.localize(view);
  EXPECT_TRUE(answer.hypotheses.empty());
  EXPECT_NE(answer.reason.find("leave free"), std::string::npos) << answer.reason;
  EXPECT_EQ(store->asked, 0);
}

TEST_F(PlaceIndexOfRooms, AMapWhoseViewsAreElsewhereGivesTheSameAnswers) {
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0;
  const auto store = std::make_shared<const Store>(*map);
  const GlobalLocalization here(map, params), there(std::make_shared<const Map>(kept(*map, store)), params);
  for (unsigned i = 0; i < 4; ++i) {
    const View view = query(int(i % kRooms), 0.7 * i, 900 + i);
    const Localization a = here.localize(view), b = there.localize(view);
    ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
    for (std::size_t k = 0; k < a.hypotheses.size(); ++k) {
      EXPECT_EQ(a.hypotheses[k].model, b.hypotheses[k].model);
      EXPECT_EQ(a.hypotheses[k].T_w_c->matrix(), b.hypotheses[k].T_w_c->matrix());
      EXPECT_EQ(a.hypotheses[k].probability, b.hypotheses[k].probability);
    }
  }
}

}  // namespace
}  // namespace facetloc

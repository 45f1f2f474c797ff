// SPDX-License-Identifier: BSD-3-Clause
// The place index in a map file.
#include "map_file.h"

#include <istream>
#include <ostream>
#include <random>
#include <stdexcept>

namespace facetloc::test {
namespace {

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

// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_model.h>
#include <facetloc/features/params.h>
#include <facetloc/testing/matchers.h>

#include <limits>
#include <string>
#include <vector>

namespace facetloc {
namespace {

using test::HasAll, test::messageOf, testing::ElementsAre, testing::HasSubstr;

struct Inner {
  static constexpr const char* kTitle = "Inner things";
  double width = 2.5;
  bool is_open = true;
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("width", p.width, 0.0, 10.0, "Width [m].", kForUsers);
    visit("is_open", p.is_open, false, true, "Open.");
  }
};

struct Outer {
  static constexpr const char* kTitle = "Outer things";
  Inner inner;
  int count = 3;
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("inner", p.inner);
    visit("count", p.count, 1, 9, "Count.");
  }
};

enum class Colour { red, green };
constexpr const char* kNamesOfColours[] = {"red", "green"};
constexpr const auto& namesOf(Colour) { return kNamesOfColours; }

struct Painted {
  static constexpr const char* kTitle = "Paint";
  Colour colour = Colour::green;
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("colour", p.colour, Colour::red, Colour::green, "Colour.");
  }
};

TEST(Params, AChoiceIsKnownByItsName) {
  EXPECT_EQ(numberText(Colour::red), "red");
  EXPECT_EQ(choiceOf<Colour>("green"), Colour::green);
  EXPECT_EQ(messageOf<std::invalid_argument>([] { choiceOf<Colour>("blue"); }),
            "'blue' is none of: red, green");
  EXPECT_THAT(toIni(Painted{}, "paint"), HasSubstr("[paint]\ncolour = green\n"));
  Painted painted;
  EXPECT_NO_THROW(checkRanges(painted));
  painted.colour = static_cast<Colour>(2);
  EXPECT_THROW(checkRanges(painted), std::invalid_argument);
}

TEST(Params, AFieldIsKnownByItsPathAndTheTitleOfItsGroup) {
  const Outer outer;
  std::vector<std::string> paths, groups;
  const auto note = [&](const ParamInfo& info, const auto&, auto, auto) {
    paths.push_back(info.name);
    groups.emplace_back(info.group);
  };
  forEachParam(outer, note);
  EXPECT_THAT(paths, ElementsAre("inner.width", "inner.is_open", "count"));
  EXPECT_THAT(groups, ElementsAre("Inner things", "Inner things", "Outer things"));
  paths.clear();
  forEachParam(outer, note, "all");
  EXPECT_THAT(paths, ElementsAre("all.inner.width", "all.inner.is_open", "all.count"));
}

TEST(Params, AFieldIsForExpertsUnlessItSaysItIsForUsers) {
  const Outer outer;
  std::vector<std::string> for_users;
  forEachParam(outer, [&](const ParamInfo& info, const auto&, auto, auto) {
    if (info.audience == Audience::users) for_users.push_back(info.name);
  });
  EXPECT_THAT(for_users, ElementsAre("inner.width"));
}

TEST(Params, IniTextHasASectionForEachGroup) {
  EXPECT_EQ(toIni(Outer(), "all"), "[all.inner]\nwidth = 2.5\nis_open = 1\n[all]\ncount = 3\n");
  EXPECT_EQ(toIni(Inner(), "inner"), "[inner]\nwidth = 2.5\nis_open = 1\n");
}

TEST(Params, FieldsCanBeWritten) {
  Outer outer;
  forEachParam(outer, [](const ParamInfo& info, auto& value, auto, auto highest) {
    if (info.name != "inner.is_open") value = highest;
  });
  EXPECT_EQ(outer.inner.width, 10);
  EXPECT_EQ(outer.count, 9);
  EXPECT_TRUE(outer.inner.is_open);
}

TEST(Params, DefaultsAreValid) { EXPECT_NO_THROW(checkRanges(SensorNoise{})); }

TEST(Params, TheFirstFieldOutsideItsRangeIsNamed) {
  SensorNoise p;
  p.distortion_offset = 1.5, p.depth_std_slope = -1;
  EXPECT_THAT(messageOf<std::invalid_argument>([&] { checkRanges(p); }),
              HasAll("distortion_offset = 1.5", "[0, 1]"));
  Outer outer;
  outer.inner.width = 11;
  EXPECT_THAT(messageOf<std::invalid_argument>([&] { checkRanges(outer); }), HasSubstr("inner.width = 11"));
}

TEST(Params, NotANumberIsOutsideEveryRange) {
  SensorNoise p;
  p.depth_std = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(checkRanges(p), std::invalid_argument);
}

TEST(Params, IniTextKeepsEveryDigitInTheOrderOfTheDescription) {
  SensorNoise p;
  p.distortion_offset = 1.0 / 3;
  const std::string text = toIni(p);
  EXPECT_THAT(text, HasSubstr("distortion_offset = 0.3333333333333333\n"));
  EXPECT_THAT(text, HasSubstr("depth_std = 0\n"));
  EXPECT_LT(text.find("distortion_offset"), text.find("\ndepth_std"));
}

}  // namespace
}  // namespace facetloc

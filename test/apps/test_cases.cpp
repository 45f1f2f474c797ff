// SPDX-License-Identifier: BSD-3-Clause
// Inputs after public reports, each with a check of the right outcome, where they lie beside the checkout.
#include <facetloc/testing/matchers.h>
#include <facetloc/testing/places.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace facetloc::test {
namespace {

class Cases : public testing::TestWithParam<const char*> {};

TEST_P(Cases, AreReadRightOrNamed) {
  constexpr int kNeedsInstallation = 77;
  const fs::path check = dataFolder("cases") / GetParam() / "check.sh";
  if (!fs::exists(check)) GTEST_SKIP() << "no cases beside the checkout";
  const std::string tools = fs::path(kMapTool).parent_path().string();
  const int status = std::system(("bash '" + check.string() + "' '" + tools + "' 1>&2").c_str());
  const int code = status >= 0 ? status >> 8 : -1;
  if (code == kNeedsInstallation) GTEST_SKIP() << "needs an installation";
  EXPECT_EQ(code, 0);
}

INSTANTIATE_TEST_SUITE_P(
    , Cases,
    testing::Values("01-rtabmap-export", "03-distance-along-rays", "04-rotated-bits",
                    "05-other-trajectory-files", "05-poses-that-were-lost", "06-turned-cloud",
                    "07-pclzf-folder", "08-tiff-depth", "09-lens-distortion", "10-decimated-then-aligned",
                    "10-sparse-after-alignment", "11-stamps-in-nanoseconds", "12-depth-at-the-end",
                    "13-folder-aligned_depth", "15-utf-16", "16-native-mode-848x480", "17-camera-upside-down",
                    "18-swapped-bytes", "20-lists", "20-lists-and-poses-that-are-read", "22-names-of-folders",
                    "27-pairwise-tutorial", "28-scale-of-800", "30-numbered-images", "32-rtabmap-sample"),
    [](const auto& test) {
      std::string name = test.param;
      for (char& c : name)
        if (c == '-') c = '_';
      return name;
    });

}  // namespace
}  // namespace facetloc::test

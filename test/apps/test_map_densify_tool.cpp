// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/io/map_database.h>
#include <facetloc/mapping/densified_map.h>

#include <algorithm>

namespace facetloc::test {
namespace {

const std::vector<std::string> kFew = {"--densify.rotation_deg", "40"};

std::vector<std::string> densifying(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "densify");
  arguments.insert(arguments.end(), kFew.begin(), kFew.end());
  return arguments;
}

TEST_F(Tools, DensifiedMapIsSoundAndSaysSo) {
  const std::string dense = folder_ / "dense.flmap", again = folder_ / "again.flmap";
  const auto run = runMap(densifying({map(), "-o", dense}));
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("rendered from the depth pictures of"));
  ok(runMap({"check", dense}));
  const Map before = readMap(map()), after = readMap(dense);
  const std::vector<char> rendered = renderedViews(after);
  const auto n = static_cast<std::size_t>(std::count(rendered.begin(), rendered.end(), 1));
  ASSERT_GE(n, 1u);
  EXPECT_EQ(after.models.size(), before.models.size() + n);
  EXPECT_TRUE(after.ambiguity) << "it has been asked again";
  EXPECT_THAT(runMap({"info", dense}).out, HasSubstr("rendered beside the drive  " + std::to_string(n)));
  EXPECT_THAT(runMap({"info", map()}).out, Not(HasSubstr("rendered beside")));

  ok(runMap(densifying({dense, "-o", again})));
  const Map twice = readMap(again);
  ASSERT_EQ(twice.models.size(), after.models.size());
  EXPECT_EQ(twice.links.size(), after.links.size());
  for (std::size_t i = 0; i < twice.models.size(); ++i) {
    EXPECT_EQ(twice.models[i].name, after.models[i].name);
    EXPECT_TRUE(twice.models[i].T_w_m->isApprox(*after.models[i].T_w_m, 1e-9))
        << "not of rendered views again";
  }
}

TEST_F(Tools, DensifyLeavesMapsAloneThatItCannotUse) {
  const std::string copy = folder_ / "copy.flmap", broken = folder_ / "broken.flmap";
  EXPECT_THAT(runMap({"densify", folder_ / "none.flmap"}).err, HasSubstr("is not there"));
  fs::copy_file(map(), copy);
  EXPECT_THAT(runMap({"densify", map(), "-o", copy}).err, HasSubstr("exists already"));
  EXPECT_EQ(contentOf(copy), contentOf(map()));
  fs::copy_file(firstImage(), broken);
  const std::string bytes = contentOf(broken);
  EXPECT_EQ(runMap({"densify", broken}).code, kFailed);
  EXPECT_EQ(contentOf(broken), bytes);
  EXPECT_EQ(runMap({"densify", copy, "--densify.reach", "-1"}).code, kUsage);
  EXPECT_THAT(runMap({"densify", copy, "--overwrite"}).err, HasSubstr("overwrite belongs to --output"));

  Map unposed = readMap(map());
  for (LocalModel& model : unposed.models) {
    View view = *unposed.view(0);
    view.depth = {};
    model.setView(std::move(view));
  }
  writeMap(copy, unposed);
  const std::string before = contentOf(copy);
  const auto refused = runMap({"densify", copy});
  EXPECT_EQ(refused.code, kFailed);
  EXPECT_THAT(refused.err, HasSubstr("no local model with a pose and a depth picture"));
  EXPECT_EQ(contentOf(copy), before);
}

}  // namespace
}  // namespace facetloc::test

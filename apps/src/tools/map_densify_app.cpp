// SPDX-License-Identifier: BSD-3-Clause
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "outputs/map_completion.h"

#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/densified_map.h>

#include <fmt/core.h>

namespace facetloc {
namespace {

std::string toString(const Densification& done, const Map& map) {
  std::string words = fmt::format("{} rendered from the depth pictures of {}", counted(done.rendered, "view"),
                                  counted(done.driven, "local model"));
  if (done.removed > 0) words += fmt::format(", in the place of {} rendered before", done.removed);
  return words +
         fmt::format("; {:.2g} % of their pixels, which other pictures look through, left out; map of {}",
                     100 * done.contradicted_share, counted(map.models.size(), "local model"));
}

/** facetloc_map densify: local models of places where no image of a map was taken. */
class MapDensifyApp : public App {
public:
  MapDensifyApp()
      : App("facetloc_map densify", "MAP.flmap [-o NEW.flmap] [options]",
            "Adds local models where no image of the map was taken, up to 1 m beside the drive and in other "
            "directions. They are rendered from the depth of the map's images, at places that these show to "
            "be free. Surfaces that no image shows are unknown. Views of an earlier run are replaced. Run it "
            "again after 'facetloc_map extend'.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addOption("output,o", output_, "NEW.flmap", "The map to write; MAP.flmap itself unless given.");
    line.addSwitch("overwrite", overwrite_, "Replace an existing NEW.flmap.");
    line.addParams(params_, "densify", CommandLine::Shown::in_help);
    line.addParams(view_);
    line.addExample("office.flmap -o dense.flmap", "views where no image was taken");
    line.addExample("office.flmap --densify.growth 0.5", "fewer of them, in the map itself");
  }

  int execute(const CommandLine&, const Console& console) override {
    const auto [target, lock] = lockSuccessor(map_, output_, overwrite_);
    Map map = noteUnfinished(readMap(map_), map_, console);
    MapWatch watch(console);
    const Densification done = densify(map, params_, view_, threads(), watch.callback());
    if (done.driven == 0)
      throw IoError(map_,
                    "has no local model with a pose and a depth picture, of which views could be rendered");
    replaceWholeMap(target, map, threads(), console);
    console.out << toString(done, map) << " in " << target << "\n";
    return kOk;
  }

  std::string map_, output_;
  bool overwrite_ = false;
  DensifyParams params_;
  ViewParams view_;
};

}  // namespace

std::unique_ptr<App> mapDensifyApp() { return std::make_unique<MapDensifyApp>(); }

}  // namespace facetloc

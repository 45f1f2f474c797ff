// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

#include <facetloc/mapping/map_making.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <mutex>
#include <stdexcept>

namespace facetloc::python {
namespace {

/** Keeps the images of its run in memory, at their working size. */
class MapRun {
public:
  MapRun(CameraPtr camera, int width, int threads)
      : camera_(std::move(camera)), width_(width), making_(camera_->camera) {
    making_.setNumberOfThreads(threads);
  }

  void add(const py::array& depth, double stamp, const std::string& name,
           const std::optional<py::array_t<double>>& T_w_c,
           const std::optional<py::array_t<double>>& gravity) {
    const DepthArray array(depth, camera_);
    MapImage image;
    image.name = name;
    image.stamp = stamp;
    if (T_w_c) image.T_w_c = toPose(*T_w_c, "T_w_c");
    image.gravity = toGravity(gravity);
    const py::gil_scoped_release others_run;
    const auto kept = std::make_shared<const DepthImage>(array.image(width_));
    image.load = [kept] { return *kept; };
    const std::lock_guard lock(mutex_);
    making_.add(std::move(image));
  }

  std::shared_ptr<Map> finish() {
    const py::gil_scoped_release others_run;
    const std::lock_guard lock(mutex_);
    auto map = std::make_shared<Map>(making_.finish());
    if (!making_.findings().problem.empty()) throw std::runtime_error(making_.findings().problem);
    return map;
  }

  py::dict findings() const {
    const MapFindings found = unlocked([this] {
      const std::lock_guard lock(mutex_);
      return making_.findings();
    });
    py::dict out;
    out["unread"] = found.unread.size();
    out["without_segments"] = found.without_segments;
    out["mounting"] = found.mounting ? found.mounting->toString() : std::string();
    out["poses"] = found.poses && found.poses->isKnown() ? found.poses->as_given.toString() : std::string();
    out["findings"] = toList(found.list());
    return out;
  }

private:
  const CameraPtr camera_;
  const int width_;
  mutable std::mutex mutex_;  // threads of Python run beside each other where it computes
  MapMaking making_;
};

/** The views of a robot on its way through a world, and their poses. */
struct Drive {
  Drive(const std::string& place, const std::string& run, std::uint64_t seed, int frames, int width)
      : camera(centredKinect(width), {}, seed) {
    if (run != "map" && run != "query")
      throw std::invalid_argument("the run is neither map nor query: " + run);
    if (frames < 1 || width < 32)
      throw std::invalid_argument("frames must be positive and width at least 32");
    const bool is_map = run == "map";
    SimulatedRun made =
        simulatedRun(place, seed, is_map ? kMappingRun : kLaterRun, static_cast<std::size_t>(frames), params);
    world = std::move(made.world);
    poses = std::move(made.poses);
  }

  DriveParams params;
  SimulatedCamera camera;
  SimulatedWorld world;
  std::vector<Eigen::Isometry3d> poses;
};

py::dict frameOf(const Drive& drive, std::size_t index) {
  const SimulatedFrame frame =
      unlocked([&] { return drive.camera.render(drive.world, drive.poses.at(index), index); });
  py::dict out;
  out["depth"] = toArray(frame.depth);
  out["labels"] = toArray(frame.labels);
  out["T_w_c"] = toArray(drive.poses.at(index));
  return out;
}

CameraPtr cameraOf(const Drive& drive) {
  auto file = std::make_shared<CameraFile>();
  file->camera.intrinsics = drive.camera.camera();
  file->camera.mounting = drive.params.mounting();
  return file;
}

}  // namespace

void addMapping(py::module_& module) {
  py::class_<MapRun>(module, "MapMaking")
      .def(py::init<CameraPtr, int, int>(), py::arg("camera").none(false), py::arg("width"),
           py::arg("threads"))
      .def("add", &MapRun::add, py::arg("depth"), py::arg("stamp"), py::arg("name"), py::arg("T_w_c"),
           py::arg("gravity"))
      .def("finish", &MapRun::finish)
      .def("findings", &MapRun::findings);
  py::class_<Drive>(module, "Drive")
      .def(py::init<const std::string&, const std::string&, std::uint64_t, int, int>(),
           py::call_guard<py::gil_scoped_release>(), py::arg("place"), py::arg("run"), py::arg("seed"),
           py::arg("frames"), py::arg("width"))
      .def("__len__", [](const Drive& drive) { return drive.poses.size(); })
      .def("frame", &frameOf, py::arg("index"))
      .def_property_readonly("camera", &cameraOf);
}

}  // namespace facetloc::python

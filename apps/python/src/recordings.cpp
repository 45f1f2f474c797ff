// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"
#include "inputs/recording_run.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <pybind11/stl/filesystem.h>

namespace facetloc::python {
namespace {

/** The usual size of the preset's images holds unless another is given. */
CameraPtr cameraOf(const std::optional<std::string>& preset, const py::kwargs& given) {
  CameraKeys keys;
  if (preset) keys.emplace_back("camera", *preset);
  for (const auto& [key, value] : given) {
    const auto name = py::cast<std::string>(key);
    if (!isCameraKey(name))
      throw py::type_error("a camera has no '" + name + "': see camera.ini in RECORDINGS.md");
    if (preset && name == "camera") throw py::type_error("preset and camera name the same: give one of them");
    keys.emplace_back(name, py::cast<std::string>(py::str(value)));
  }
  const auto find = [&keys](const char* name) {
    return std::find_if(keys.begin(), keys.end(), [name](const auto& key) { return key.first == name; });
  };
  const auto named = find("camera");
  const CameraPreset* known = named == keys.end() ? nullptr : findCameraPreset(named->second);
  if (known && find("width") == keys.end() && find("height") == keys.end()) {
    keys.emplace_back("width", std::to_string(known->intrinsics().width));
    keys.emplace_back("height", std::to_string(known->intrinsics().height));
  }
  return std::make_shared<CameraFile>(cameraOfKeys(keys, "Camera"));
}

/** Numbers as numbers. */
py::dict dictOf(const CameraFile& camera) {
  py::dict out;
  for (const auto& [key, value] : keysOfCamera(camera)) {
    const bool is_word = key == "camera" || key == "depth_is", is_whole = key == "width" || key == "height";
    out[py::str(key)] = is_word    ? py::object(py::str(value))
                        : is_whole ? py::object(py::int_(py::str(value)))
                                   : py::object(py::float_(py::str(value)));
  }
  return out;
}

std::string describe(const CameraFile& camera) {
  std::string text;
  for (const auto& [key, value] : dictOf(camera))
    text += (text.empty() ? "" : ", ") + py::cast<std::string>(key) + "=" +
            py::cast<std::string>(py::repr(value));
  return "Camera(" + text + ")";
}

/** Depth images of a recording are those of a pinhole camera. */
CameraPtr pinhole(const CameraFile& stored) {
  auto camera = std::make_shared<CameraFile>(stored);
  camera->lens = {};
  camera->depth_is = DepthKind::z;
  return camera;
}

/** Labels and segments. */
py::tuple segmented(const py::array& depth, const CameraPtr& camera, int width) {
  const DepthArray array(depth, camera);
  const auto [view, labels] = unlocked([&] {
    ViewBuilder builder(array.camera());
    View built = builder.build(array.image(width));
    return std::pair(std::move(built), builder.segmentation().labels);
  });
  return py::make_tuple(toArray(labels), toList(view.segments));
}

py::object truth(const DepthSequence& sequence, std::size_t index) {
  return toArray(sequence.groundTruth().at(sequence.frames().at(index).stamp));
}

py::array_t<float> depthOf(const DepthSequence& sequence, std::size_t index, int width) {
  return toArray(unlocked([&] { return sequence.load(index, width); }));
}

/** As facetloc_check lists them. */
py::list findingsOf(const DepthSequence& sequence) {
  return toList(unlocked([&] {
    Findings found = readingFindings(sequence);
    MapMaking making(sequence.camera() ? sequence.camera()->camera : Camera());
    addImages(sequence, sequence.groundTruth(), {}, making);
    checkRun(sequence, found, making);
    append(making.findings().list(), found);
    return found;
  }));
}

}  // namespace

void addRecordings(py::module_& module) {
  py::class_<CameraFile, CameraPtr> type(module, "Camera", R"(A depth camera, by the keys of a camera.ini.

    Camera(width=640, height=480, fx=525, fy=525, cx=319.5, cy=239.5)
    Camera("azure_kinect")           the typical intrinsics and range of a preset, at its usual size
    Camera("kinect", width=320, height=240, mount_height=0.98, mount_tilt_deg=10)
    Camera.open("walk/camera.ini")   also Camera.open("office.flmap")

depth_scale, the value of a pixel per metre, is 1000 unless given. Cameras do not change; equal ones have equal keys.)");
  type.def(py::init(&cameraOf), py::arg("preset") = py::none(),
           "Raises IoError, with the cause, for an impossible or incomplete camera, and TypeError for "
           "unknown keys.")
      .def_static(
          "open",
          [](const std::filesystem::path& path) {
            return std::make_shared<CameraFile>(isMapFile(path) ? cameraOfMap(path) : readCameraFile(path));
          },
          py::arg("path"), "The camera of a camera.ini, or of a map that was made with it.")
      .def_static(
          "presets",
          [] {
            py::list names;
            for (const CameraPreset& preset : cameraPresets()) names.append(preset.name);
            return names;
          },
          "Names of the presets.")
      .def_property_readonly("keys", &dictOf,
                             "Its keys and values: Camera(**camera.keys) is the same camera.")
      .def_readonly("depth_scale", &CameraFile::depth_scale, "Value of a pixel of whole numbers per metre.")
      .def_property_readonly(
          "T_b_c",
          [](const CameraFile& c) {
            return c.camera.mounting ? py::object(toArray(c.camera.mounting->T_b_c())) : py::none();
          },
          "The camera on its robot, (4, 4), or None if it is not mounted.")
      .def("__repr__", &describe)
      .def(
          "__eq__",
          [](const CameraFile& a, const CameraFile& b) { return keysOfCamera(a) == keysOfCamera(b); },
          py::is_operator())
      .def("__hash__", [](const CameraFile& c) { return py::hash(py::str(describe(c))); })
      .def("__copy__", [](const CameraPtr& c) { return c; })
      .def("__deepcopy__", [](const CameraPtr& c, const py::dict&) { return c; })
      .def(py::pickle([](const CameraFile& c) { return dictOf(c); },
                      [](const py::dict& keys) { return cameraOf({}, py::kwargs(keys)); }));
  const auto add = [&type](const char* name, auto Intrinsics::*number, const char* what) {
    type.def_property_readonly(
        name, [number](const CameraFile& c) { return c.camera.intrinsics.*number; }, what);
  };
  add("width", &Intrinsics::width, "Columns of its images [px].");
  add("height", &Intrinsics::height, "Rows of its images [px].");
  add("fx", &Intrinsics::fx, "Focal length along x [px].");
  add("fy", &Intrinsics::fy, "Focal length along y [px].");
  add("cx", &Intrinsics::cx, "Optical centre [px]; pixel centres are at whole coordinates.");
  add("cy", &Intrinsics::cy, "Optical centre [px]; pixel centres are at whole coordinates.");
  type.attr("__module__") = "facetloc";
  module.def("segment", &segmented, py::arg("depth"), py::arg("camera"), py::arg("width"));

  py::class_<DepthSequence>(module, "Recording")
      .def(py::init([](const std::string& path, const std::string& camera, const std::string& topic) {
             RecordingHints hints;
             hints.camera = camera;
             hints.topic = topic;
             const py::gil_scoped_release others_run;
             return DepthSequence::open(path, hints);
           }),
           py::arg("path"), py::arg("camera"), py::arg("topic"))
      .def("__len__", [](const DepthSequence& s) { return s.frames().size(); })
      .def("name", [](const DepthSequence& s, std::size_t i) { return s.frames().at(i).name; })
      .def("stamp", [](const DepthSequence& s, std::size_t i) { return s.frames().at(i).stamp; })
      .def("truth", &truth)
      .def("depth", &depthOf, py::arg("index"), py::arg("width"))
      .def_property_readonly("layout", &DepthSequence::layout)
      .def_property_readonly("remarks", &DepthSequence::remarks)
      .def("findings", &findingsOf)
      .def_property_readonly("camera", [](const DepthSequence& s) {
        return s.camera() ? py::cast(pinhole(*s.camera())) : py::none();
      });
}

}  // namespace facetloc::python

// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"
#include "inputs/recording_run.h"

#include <facetloc/io/camera_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/segmentation/view_builder.h>

#include <filesystem>
#include <pybind11/stl/filesystem.h>

namespace facetloc::python {
namespace {

CameraPtr cameraOf(const py::kwargs& keys) {
  CameraKeys words;
  for (const auto& [key, value] : keys) {
    const auto name = py::cast<std::string>(key);
    if (!isCameraKey(name))
      throw py::type_error("a camera has no '" + name + "': see camera.ini in RECORDINGS.md");
    words.emplace_back(name, py::cast<std::string>(py::str(value)));
  }
  return std::make_shared<CameraFile>(cameraOfKeys(words, "Camera"));
}

/** Depth images of a recording are those of a pinhole camera. */
CameraPtr pinhole(const CameraFile& stored) {
  auto camera = std::make_shared<CameraFile>(stored);
  camera->lens = {};
  camera->depth_is = DepthKind::z;
  return camera;
}

py::array_t<double> hullOf(const Segment& segment) {
  Eigen::MatrixXd corners(segment.hull.size, 3);
  for (int i = 0; i < segment.hull.size; ++i) {
    const Eigen::Vector2d at = segment.hull.vertex[static_cast<std::size_t>(i)].cast<double>();
    corners.row(i) = (segment.t + segment.R * Eigen::Vector3d(at.x(), at.y(), 0)).transpose();
  }
  return toArray(corners);
}

py::dict toDict(const Segment& segment) {
  py::dict out;
  out["R"] = toArray(Eigen::MatrixXd(segment.R));
  out["t"] = toVector(segment.t);
  out["covariance"] = toArray(Eigen::MatrixXd(segment.Sigma_q));
  out["num_points"] = segment.num_points;
  out["area"] = segment.area();
  out["hull"] = hullOf(segment);
  return out;
}

/** Labels and segments. */
py::tuple segmented(const py::array& depth, const CameraPtr& camera, int width) {
  const DepthArray array(depth, camera);
  View view;
  LabelImage labels;
  {
    const py::gil_scoped_release others_run;
    ViewBuilder builder(array.camera());
    view = builder.build(array.image(width));
    labels = builder.segmentation().labels;
  }
  py::list segments;
  for (const Segment& segment : view.segments) segments.append(toDict(segment));
  return py::make_tuple(toArray(labels), segments);
}

py::object truth(const DepthSequence& sequence, std::size_t index) {
  return toArray(sequence.groundTruth().at(sequence.frames().at(index).stamp));
}

py::array_t<float> depthOf(const DepthSequence& sequence, std::size_t index, int width) {
  DepthImage image;
  {
    const py::gil_scoped_release others_run;
    image = sequence.load(index, width);
  }
  return toArray(image);
}

/** As facetloc_check lists them. */
py::list findingsOf(const DepthSequence& sequence) {
  Findings found;
  {
    const py::gil_scoped_release others_run;
    found = readingFindings(sequence);
    MapMaking making(sequence.camera() ? sequence.camera()->camera : Camera());
    addImages(sequence, sequence.groundTruth(), {}, making);
    checkRun(sequence, found, making);
    append(making.findings().list(), found);
  }
  return toList(found);
}

}  // namespace

void addRecordings(py::module_& module) {
  py::class_<CameraFile, CameraPtr>(module, "Camera")
      .def(py::init(&cameraOf))
      .def_static(
          "open",
          [](const std::filesystem::path& path) {
            return std::make_shared<CameraFile>(isMapFile(path) ? cameraOfMap(path) : readCameraFile(path));
          },
          py::arg("path"))
      .def_property_readonly("width", [](const CameraFile& c) { return c.camera.intrinsics.width; })
      .def_property_readonly("height", [](const CameraFile& c) { return c.camera.intrinsics.height; })
      .def_property_readonly("fx", [](const CameraFile& c) { return c.camera.intrinsics.fx; })
      .def_property_readonly("fy", [](const CameraFile& c) { return c.camera.intrinsics.fy; })
      .def_property_readonly("cx", [](const CameraFile& c) { return c.camera.intrinsics.cx; })
      .def_property_readonly("cy", [](const CameraFile& c) { return c.camera.intrinsics.cy; })
      .def_readonly("depth_scale", &CameraFile::depth_scale)
      .def_property_readonly("T_b_c", [](const CameraFile& c) {
        return c.camera.mounting ? py::object(toArray(c.camera.mounting->T_b_c())) : py::none();
      });
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

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/features/gravity.h>
#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/frame_source.h>
#include <facetloc/registration/hypothesis.h>

#include <memory>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

/** \file
 * The C++ half of the Python package. It returns dictionaries of numbers and arrays, from which
 * facetloc/__init__.py makes data classes. The lock of the interpreter is held only while arrays are
 * converted. */

namespace facetloc::python {

namespace py = pybind11;
using CameraPtr = std::shared_ptr<CameraFile>;

/** \brief A depth image from Python: whole numbers by the camera's scale, or metres; (height, width). Throws
 * std::invalid_argument, with a sentence, for another shape or type.
 * \param name of the argument */
class DepthArray {
public:
  DepthArray(py::array depth, CameraPtr camera, const char* name = "depth");
  /** \brief Depth image of a pinhole camera, subsampled to the working width. Needs no lock. */
  DepthImage image(int working_width) const;
  const Camera& camera() const { return camera_->camera; }

private:
  CameraPtr camera_;
  DepthFrame frame_;   // Integer depth values.
  DepthImage metres_;  // else
};

/** \brief The result of a function that runs without the lock of the interpreter. */
template <class Function>
auto unlocked(const Function& function) {
  const py::gil_scoped_release others_run;
  return function();
}

/** \brief (4, 4). */
py::array_t<double> toArray(const Eigen::Isometry3d& T);
py::object toArray(const std::optional<Eigen::Isometry3d>& T);
py::array_t<double> toArray(const Eigen::MatrixXd& matrix);
/** \brief (height, width), metres or labels. */
py::array_t<float> toArray(const DepthImage& image);
py::array_t<std::uint16_t> toArray(const LabelImage& labels);
/** \brief Throws std::invalid_argument unless it is a rigid transform, (4, 4). */
Eigen::Isometry3d toPose(const py::array_t<double>& T, const char* name);
/** \brief A pose with a covariance, (6, 6), or, if that is empty, with these standard deviations. */
PoseWithCovariance toPose(const py::array_t<double>& T, const char* name,
                          const std::optional<py::array_t<double>>& covariance, const char* covariance_name,
                          double std_m, double std_deg);
std::optional<Gravity> toGravity(const std::optional<py::array_t<double>>& down);
/** \brief Segments in the frame of their camera, as dicts. */
py::list toList(const std::vector<Segment>& segments);
/** \brief \param T_w_m of the local model, by its index; may be null */
py::dict toDict(const Hypothesis& hypothesis, const Map* map);

/** \brief A list of dicts. */
py::list toList(const Findings& findings);

void addRecordings(py::module_& module);
void addLocalization(py::module_& module);
void addMapping(py::module_& module);

}  // namespace facetloc::python

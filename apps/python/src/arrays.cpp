// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "bindings.h"

#include <Eigen/LU>

#include <fmt/format.h>
#include <stdexcept>

namespace facetloc::python {
namespace {

template <class Number>
std::vector<Number> copied(const py::array& array) {
  const auto dense = py::array_t<Number, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!dense) throw std::invalid_argument("an array cannot be read");
  return {dense.data(), dense.data() + dense.size()};
}

void requireShape(const py::array& array, py::ssize_t rows, py::ssize_t columns, const char* name) {
  if (array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == columns) return;
  std::string shape;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) shape += (i ? ", " : "") + std::to_string(array.shape(i));
  throw std::invalid_argument(fmt::format("{} has the shape ({}), not ({}, {})", name, shape, rows, columns));
}

/** Unmeasured pixels become 0. Throws std::invalid_argument for millimetres. */
void requireMetres(std::vector<float>& depth, const char* name) {
  constexpr float kFarthest = 100;
  std::vector<float> measured;
  for (float& z : depth) isMeasured(z) ? measured.push_back(z) : void(z = 0);
  if (!measured.empty() && internal::median(std::move(measured)) > kFarthest)
    throw std::invalid_argument(
        fmt::format("half of {} is beyond 100 m: they are millimetres; divide them by 1000", name));
}

py::dict toDict(const Segment& segment) {
  Eigen::MatrixXd hull(segment.hull.size, 3);
  for (int i = 0; i < segment.hull.size; ++i) {
    const Eigen::Vector2d at = segment.hull.vertex[static_cast<std::size_t>(i)].cast<double>();
    hull.row(i) = (segment.t + segment.R * Eigen::Vector3d(at.x(), at.y(), 0)).transpose();
  }
  py::dict out;
  out["R"] = toArray(Eigen::MatrixXd(segment.R));
  out["t"] = py::array_t<double>(3, segment.t.data());
  out["covariance"] = toArray(Eigen::MatrixXd(segment.Sigma_q));
  out["num_points"] = segment.num_points;
  out["area"] = segment.area();
  out["hull"] = toArray(hull);
  return out;
}

}  // namespace

DepthArray::DepthArray(py::array depth, CameraPtr camera, const char* name) : camera_(std::move(camera)) {
  if (!camera_) throw std::invalid_argument("the camera is missing");
  const Intrinsics& k = camera_->camera.intrinsics;
  requireShape(depth, k.height, k.width, name);
  if (py::hasattr(depth, "filled")) depth = depth.attr("filled")(0);  // masked pixels are not measured
  const char kind = depth.dtype().kind();
  if (kind == 'u' && depth.dtype().itemsize() == 2) {
    frame_.camera = camera_;
    frame_.values = copied<std::uint16_t>(depth);
  } else if (kind == 'f') {
    metres_ = {k, copied<float>(depth)};
    requireMetres(metres_.depth, name);
  } else {
    throw std::invalid_argument(
        fmt::format("{} is of the type {}, not uint16 (by the depth_scale of the camera) or float (metres)",
                    name, py::str(depth.dtype()).cast<std::string>()));
  }
}

DepthImage DepthArray::image(int working_width) const {
  if (working_width < 0) throw std::invalid_argument("width is negative");
  FrameConverter converter;
  return workingImage(frame_.camera ? converter(frame_) : converter(metres_, camera_), working_width);
}

py::array_t<double> toArray(const Eigen::MatrixXd& matrix) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = matrix;
  return py::array_t<double>({rows.rows(), rows.cols()}, rows.data());
}

py::array_t<float> toArray(const DepthImage& image) {
  return py::array_t<float>({image.camera.height, image.camera.width}, image.depth.data());
}

py::array_t<std::uint16_t> toArray(const LabelImage& labels) {
  return py::array_t<std::uint16_t>({labels.height, labels.width}, labels.label.data());
}

py::array_t<double> toArray(const Eigen::Isometry3d& T) { return toArray(Eigen::MatrixXd(T.matrix())); }

py::object toArray(const std::optional<Eigen::Isometry3d>& T) {
  return T ? py::object(toArray(*T)) : py::none();
}

Eigen::Isometry3d toPose(const py::array_t<double>& T, const char* name) {
  constexpr double kRounding = 1e-4;
  requireShape(T, 4, 4, name);
  Eigen::Isometry3d pose;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) pose.matrix()(row, column) = T.at(row, column);
  const Eigen::Matrix3d R = pose.linear();
  if (!pose.matrix().allFinite() ||
      !pose.matrix().row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kRounding) ||
      !(R.transpose() * R).isApprox(Eigen::Matrix3d::Identity(), kRounding) || R.determinant() < 0)
    throw std::invalid_argument(fmt::format("{} is no rigid transform", name));
  return pose;
}

PoseWithCovariance toPose(const py::array_t<double>& T, const char* name,
                          const std::optional<py::array_t<double>>& covariance, const char* covariance_name,
                          double std_m, double std_deg) {
  PoseWithCovariance pose{toPose(T, name), Matrix6d::Zero()};
  if (!covariance) {
    const double std_rad = std_deg * kDegree;
    pose.P.diagonal() << Eigen::Vector3d::Constant(std_rad * std_rad),
        Eigen::Vector3d::Constant(std_m * std_m);
    return pose;
  }
  requireShape(*covariance, 6, 6, covariance_name);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) pose.P(row, column) = covariance->at(row, column);
  return pose;
}

std::optional<Gravity> toGravity(const std::optional<py::array_t<double>>& down) {
  if (!down) return {};
  if (down->size() != 3 || down->ndim() != 1) throw std::invalid_argument("gravity has not three numbers");
  return gravityAlong({down->at(0), down->at(1), down->at(2)}, kDegree);
}

py::list toList(const Findings& findings) {
  py::list list;
  for (const Finding& finding : findings) {
    py::dict out, evidence;
    for (const Evidence& number : finding.evidence)
      evidence[py::str(number.quantity)] = py::make_tuple(number.value, number.std);
    out["id"] = finding.id;
    out["severity"] = toString(finding.severity);
    out["words"] = finding.words;
    out["cure"] = finding.cure;
    out["evidence"] = evidence;
    list.append(out);
  }
  return list;
}

py::list toList(const std::vector<Segment>& segments) {
  py::list list;
  for (const Segment& segment : segments) list.append(toDict(segment));
  return list;
}

py::dict toDict(const Hypothesis& h, const Map* map) {
  py::dict out;
  const bool placed = map && map->models[h.model].T_w_m && h.T_w_c;
  out["model"] = map ? map->models[h.model].name : std::string();
  out["part"] = map ? map->partOf(h.model) : std::string();
  out["probability"] = h.probability;
  out["score"] = h.score;
  out["T_m_c"] = toArray(h.T_m_c.T);
  out["covariance_m"] = toArray(Eigen::MatrixXd(h.T_m_c.P));
  out["T_w_c"] = map ? toArray(h.T_w_c) : toArray(std::optional(h.T_m_c.T));
  const Matrix6d P_w = placed ? Matrix6d((*map->models[h.model].T_w_m * h.T_m_c).P) : h.T_m_c.P;
  out["covariance"] = placed || !map ? py::object(toArray(Eigen::MatrixXd(P_w))) : py::none();
  out["pairs"] = h.pairs.size();
  out["depth_assisted"] = h.depth_assisted;
  return out;
}

}  // namespace facetloc::python

// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"
#include "inputs/recording_run.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/rig_file.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/registration/pair_registration.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>

namespace facetloc::python {
namespace {

using MapPtr = std::shared_ptr<Map>;
using OptionalArray = std::optional<py::array_t<double>>;

PoseWithCovariance between(const Camera& first, const Camera& other) {
  if (!first.mounting || !other.mounting)
    throw std::invalid_argument("a camera of several has no mounting on the robot (mount_height, ...)");
  return RigFile().between(*first.mounting, *other.mounting);
}

std::shared_ptr<const Map> mapFor(const MapPtr& map, const std::vector<CameraPtr>& rig) {
  std::vector<Eigen::Isometry3d> sides;
  for (std::size_t k = 1; k < rig.size(); ++k) sides.push_back(between(rig[0]->camera, rig[k]->camera).T);
  return sides.empty() ? std::shared_ptr<const Map>(map) : mapForRig(map, std::move(sides));
}

using DepthArrays = std::vector<DepthArray>;

DepthArrays arraysOf(const std::vector<py::array>& depth, const std::vector<CameraPtr>& cameras) {
  DepthArrays all;
  for (std::size_t k = 0; k < depth.size(); ++k) all.emplace_back(depth[k], cameras.at(k));
  return all;
}

/** A localizer, its working width and its builder of views; one call at a time. */
struct LockedLocalizer {
  LockedLocalizer(MapPtr of_map, int working_width, int threads, const std::optional<double>& min_probability,
                  const std::vector<CameraPtr>& rig)
      : map(std::move(of_map)), width(working_width), localizer(mapFor(map, rig)) {
    localizer.setNumberOfThreads(threads);
    localizer.setMinProbability(min_probability.value_or(minProbabilityOf(*map)));
  }

  /** The view of the first camera, joined with the others. */
  View viewOf(const DepthArrays& depth, const std::optional<Gravity>& gravity) const {
    const Camera& camera = depth[0].camera();
    View first = ViewBuilder(map->calibrated(camera)).build(depth[0].image(width), gravity);
    if (depth.size() == 1) return first;
    std::vector<PosedView> others;
    for (std::size_t k = 1; k < depth.size(); ++k)
      others.push_back(
          {std::make_shared<const View>(ViewBuilder(depth[k].camera()).build(depth[k].image(width))),
           between(camera, depth[k].camera())});
    return joined(first, others);
  }

  MapPtr map;
  int width;
  Localizer localizer;
  std::mutex mutex;
};

py::object toObject(const std::optional<NextLook>& look) {
  if (!look) return py::none();
  py::dict out;
  out["yaw_deg"] = look->yaw / kDegree;
  out["ahead"] = look->ahead;
  out["sure"] = look->sure;
  out["gain"] = look->gain;
  return out;
}

py::dict toDict(const Localization& answer, const Map& map, const Camera& camera) {
  py::dict out;
  out["state"] = toString(answer.state);
  py::list hypotheses;
  for (const Hypothesis& h : answer.hypotheses) hypotheses.append(python::toDict(h, &map));
  out["hypotheses"] = hypotheses;
  out["not_in_map"] = answer.not_in_map;
  if (!map.joined.empty()) out["maps"] = probabilitiesOfMaps(answer, map);
  py::dict shares;
  if (answer.shares)
    for (const auto& [name, share] : ViewShares::kNamed) shares[name] = (*answer.shares).*share;
  out["shares"] = shares;
  out["reason"] = answer.reason;
  out["next_look"] = toObject(answer.next_look);
  out["findings"] = toList(differenceFindings(map.calibrated(camera), map));
  out["tracking"] = stateName(answer.tracking);
  out["T_w_c"] = answer.T_w_c ? py::object(toArray(answer.T_w_c->T)) : py::none();
  out["covariance"] = answer.T_w_c ? py::object(toArray(Eigen::MatrixXd(answer.T_w_c->P))) : py::none();
  return out;
}

/** The answer to images of one moment. \param find localizes their view */
template <class Find>
py::dict answerOf(LockedLocalizer& self, const DepthArrays& arrays, const std::optional<Gravity>& gravity,
                  const Find& find) {
  const Localization answer = unlocked([&] {
    const std::lock_guard lock(self.mutex);
    const View view = self.viewOf(arrays, gravity);
    Localization found = find(view);
    found.next_look = self.localizer.nextLook(view, found);
    return found;
  });
  return toDict(answer, *self.map, arrays[0].camera());
}

py::dict localize(LockedLocalizer& self, const std::vector<py::array>& depth,
                  const std::vector<CameraPtr>& cameras, const OptionalArray& gravity,
                  const OptionalArray& near, double std_m, double std_deg) {
  const DepthArrays arrays = arraysOf(depth, cameras);
  const auto down = toGravity(gravity);
  const auto guess = near ? std::optional(toPose(*near, "near", {}, "", std_m, std_deg)) : std::nullopt;
  return answerOf(self, arrays, down, [&](const View& view) {
    return guess ? self.localizer.localize(view, *guess) : self.localizer.localize(view);
  });
}

py::dict update(LockedLocalizer& self, const std::vector<py::array>& depth,
                const std::vector<CameraPtr>& cameras, double stamp, const OptionalArray& motion,
                const OptionalArray& covariance, const OptionalArray& gravity) {
  const DepthArrays arrays = arraysOf(depth, cameras);
  const auto down = toGravity(gravity);
  if (motion && !covariance)
    throw std::invalid_argument("motion has no covariance: motion_covariance is missing");
  const auto moved =
      motion ? std::optional(toPose(*motion, "motion", covariance, "motion_covariance", 0, 0)) : std::nullopt;
  return answerOf(self, arrays, down,
                  [&](const View& view) { return self.localizer.update(view, stamp, moved); });
}

void setPose(LockedLocalizer& self, const py::array_t<double>& T_w_c, const OptionalArray& covariance,
             double std_m, double std_deg, const std::string& part) {
  const PoseWithCovariance pose = toPose(T_w_c, "T_w_c", covariance, "covariance", std_m, std_deg);
  const std::vector<std::string>& parts = self.map->parts;
  const auto found = std::find(parts.begin(), parts.end(), part);
  if (found == parts.end() && !(parts.empty() && part.empty()))
    throw std::invalid_argument("the map has no part '" + part + "'");
  const py::gil_scoped_release others_run;  // while another call computes
  const std::lock_guard lock(self.mutex);
  self.localizer.setPose(pose, static_cast<int>(found - parts.begin()));
}

py::dict registered(const py::array& source, const py::array& target, const CameraPtr& source_camera,
                    const CameraPtr& target_camera, int width) {
  const DepthArray from(source, source_camera, "source"), to(target, target_camera, "target");
  const Localization answer = unlocked([&] {
    const PairRegistration registration(ViewBuilder(to.camera()).build(to.image(width)));
    return registration.align(ViewBuilder(from.camera()).build(from.image(width)));
  });
  py::dict out;
  py::list hypotheses;
  for (const Hypothesis& h : answer.hypotheses) hypotheses.append(python::toDict(h, nullptr));
  out["state"] = toString(answer.state);
  out["hypotheses"] = hypotheses;
  out["reason"] = answer.reason;
  return out;
}

py::dict modelOf(const Map& map, std::size_t index) {
  const LocalModel& model = map.models.at(index);
  py::dict out;
  out["name"] = model.name;
  out["stamp"] = model.stamp;
  out["T_w_m"] = toArray(model.T_w_m);
  out["part"] = map.partOf(static_cast<int>(index));
  out["segments"] = map.view(static_cast<int>(index))->segments.size();
  return out;
}

py::list segmentsOf(const Map& map, std::size_t index) {
  if (index >= map.models.size()) throw py::index_error("the map has no such local model");
  return toList(map.view(static_cast<int>(index))->segments);
}

py::list linksOf(const Map& map) {
  py::list links;
  for (const Link& link : map.links)
    links.append(py::make_tuple(link.from, link.to, toArray(link.T_from_to.T)));
  return links;
}

}  // namespace

void addLocalization(py::module_& module) {
  py::class_<Map, MapPtr>(module, "Map")
      .def_static(
          "open", [](const std::string& path) { return std::make_shared<Map>(openMap(path)); },
          py::call_guard<py::gil_scoped_release>(), py::arg("path"))
      .def(
          "save",
          [](const Map& map, const std::string& path) {
            writeMap(path, map, map.camera.mounting ? placeIndexOf(map) : nullptr);
          },
          py::call_guard<py::gil_scoped_release>(), py::arg("path"))
      .def_static(
          "joined",
          [](const std::map<std::string, MapPtr>& maps) {
            std::vector<JoinedMap> all;
            for (const auto& [name, map] : maps) all.push_back({name, map});
            return std::make_shared<Map>(joinMaps(std::move(all)));
          },
          py::arg("maps"))
      .def("__len__", [](const Map& map) { return map.models.size(); })
      .def("model", &modelOf, py::arg("index"))
      .def("segments", &segmentsOf, py::arg("index"))
      .def_property_readonly("links", &linksOf)
      .def_property_readonly("parts", [](const Map& map) { return map.parts; });

  py::class_<LockedLocalizer>(module, "Localizer")
      .def(py::init<MapPtr, int, int, const std::optional<double>&, const std::vector<CameraPtr>&>(),
           py::arg("map"), py::arg("width"), py::arg("threads"), py::arg("min_probability"), py::arg("rig"))
      .def("localize", &localize, py::arg("depth"), py::arg("camera"), py::arg("gravity"), py::arg("near"),
           py::arg("std_m"), py::arg("std_deg"))
      .def("update", &update, py::arg("depth"), py::arg("camera"), py::arg("stamp"), py::arg("motion"),
           py::arg("motion_covariance"), py::arg("gravity"))
      .def("set_pose", &setPose, py::arg("T_w_c"), py::arg("covariance"), py::arg("std_m"),
           py::arg("std_deg"), py::arg("part"))
      .def("reset", [](LockedLocalizer& self) {
        const py::gil_scoped_release others_run;
        const std::lock_guard lock(self.mutex);
        self.localizer.reset();
      });
  module.def("register", &registered, py::arg("source"), py::arg("target"), py::arg("source_camera"),
             py::arg("target_camera"), py::arg("width"));
}

}  // namespace facetloc::python

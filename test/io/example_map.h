// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace facetloc::test {

/** \brief Sound but meaningless map contents with awkward doubles. */
class ExampleMap {
public:
  explicit ExampleMap(unsigned seed = 1) : engine_(seed) {}

  Eigen::Isometry3d pose() {
    Eigen::Isometry3d T(Eigen::Quaterniond(value(), value(), value(), value()).normalized());
    T.translation() << 3 * value(), 3 * value(), 3 * value();
    return T;
  }

  Segment segment() {
    Segment s;
    s.R = pose().linear();
    s.t << value(), value(), 2 + value();
    s.Sigma_q = 1e-4 * covariance<3>();
    s.lambda << 1.0 / 3, 1.0 / 7;
    s.num_points = 1234;
    s.hull.size = 5;
    for (int i = 0; i < s.hull.size; ++i) s.hull.vertex[i] = {std::cos(i * 1.2566f), std::sin(i * 1.2566f)};
    return s;
  }

  DepthPicture picture() {
    const Intrinsics camera{40, 30, 33.3, 33.4, 19.5, 14.5};
    std::vector<std::uint16_t> values(40 * 30);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<std::uint16_t>(i % 7 == 0 ? 0 : i % 11 == 0 ? engine_() : 8000 + i % 40);
    DepthPicture picture = DepthPicture::fromStored(camera, std::move(values));
    picture.noise.inverse_depth_std = 0.003 + 0.001 * value();
    picture.noise.depth_std = 0.003 + 0.001 * value();
    picture.noise.depth_std_slope = 0.003 + 0.001 * value();
    return picture;
  }

  LocalModel model(const std::string& name) { return {name, 1305031102.175304 + value(), pose()}; }

  View view(int segments = 4) {
    View v;
    v.intrinsics = {320, 240, 262.5 + value(), 262.5, 159.5, 119.5};
    for (int i = 0; i < segments; ++i) v.segments.push_back(segment());
    v.depth = picture();
    return v;
  }

  /** \brief A local model with its view. */
  LocalModel seen(const std::string& name, int segments = 4) {
    LocalModel m = model(name);
    m.setView(view(segments));
    return m;
  }

  Link link(int from, int to) {
    Link l;
    l.from = from;
    l.to = to;
    l.T_from_to.T = pose();
    l.T_from_to.P = 1e-3 * covariance<6>();
    return l;
  }

  Map map(int models = 3) {
    Map m;
    m.camera.mounting = CameraMounting{0.98, 10.1};
    m.camera.noise = {{1.0 / 300, 1.0 / 1100, 1.0 / 1300}, 1.0 / 700, 1.0 / 900};
    m.camera.max_depth = 5.0 / 3;
    m.meta = {{"software", "test"}, {"min_support", "150"}};
    for (int i = 0; i < models; ++i) m.models.push_back(seen("frame " + std::to_string(i), 3 + i));
    for (int i = 0; i + 1 < models; ++i) m.links.push_back(link(i, i + 1));
    return m;
  }

private:
  double value() { return static_cast<double>(engine_()) / 4294967296.0 * 2 - 1; }

  template <int N>
  Eigen::Matrix<double, N, N> covariance() {
    Eigen::Matrix<double, N, N> a;
    for (int i = 0; i < N * N; ++i) a(i) = value();
    Eigen::Matrix<double, N, N> c = a * a.transpose() + Eigen::Matrix<double, N, N>::Identity();
    return (c + c.transpose()) / 2;
  }

  std::mt19937 engine_;
};

}  // namespace facetloc::test

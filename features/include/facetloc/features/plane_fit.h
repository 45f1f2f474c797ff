// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <algorithm>

namespace facetloc {

/** \brief A plane in pixel space: inverse depth (or any multiple of it, disparity) d = a u + b v + c.
 *
 * A plane m . p = 1 of space is exactly such a plane of the image (METHOD 2.4), where noise is homoscedastic.
 */
struct PixelPlane {
  double a = 0;
  double b = 0;
  double c = 0;

  double at(double u, double v) const { return a * u + b * v + c; }
  /** \brief m of the plane m . p = 1, m = normal / distance [1/m], if d is inverse depth. */
  Eigen::Vector3d toSpace(const Intrinsics& camera) const {
    return {a * camera.fx, b * camera.fy, a * camera.cx + b * camera.cy + c};
  }
  static PixelPlane fromSpace(const Eigen::Vector3d& m, const Intrinsics& camera) {
    const double a = m.x() / camera.fx, b = m.y() / camera.fy;
    return {a, b, m.z() - a * camera.cx - b * camera.cy};
  }
};

/** \brief Moments of pixels (u, v, d). Adding moments of disjoint sets gives the moments of their union,
 * exactly as long as the sums of u and v are integers below 2^53. */
struct PlaneMoments {
  double n = 0, u = 0, v = 0, d = 0, uu = 0, uv = 0, vv = 0, ud = 0, vd = 0, dd = 0;

  void add(double pu, double pv, double pd) {
    n += 1, u += pu, v += pv, d += pd;
    uu += pu * pu, uv += pu * pv, vv += pv * pv;
    ud += pu * pd, vd += pv * pd, dd += pd * pd;
  }
  PlaneMoments& operator+=(const PlaneMoments& o) {
    n += o.n, u += o.u, v += o.v, d += o.d;
    uu += o.uu, uv += o.uv, vv += o.vv;
    ud += o.ud, vd += o.vd, dd += o.dd;
    return *this;
  }
  PlaneMoments& operator-=(const PlaneMoments& o) {
    n -= o.n, u -= o.u, v -= o.v, d -= o.d;
    uu -= o.uu, uv -= o.uv, vv -= o.vv;
    ud -= o.ud, vd -= o.vd, dd -= o.dd;
    return *this;
  }
  friend PlaneMoments operator+(PlaneMoments a, const PlaneMoments& b) { return a += b; }

  /** \brief The moments of the same pixels, du further to the right and dv further down. */
  PlaneMoments shifted(double du, double dv) const {
    PlaneMoments m = *this;
    m.u += n * du, m.v += n * dv;
    m.uu += 2 * du * u + n * du * du, m.vv += 2 * dv * v + n * dv * dv;
    m.uv += du * v + dv * u + n * du * dv;
    m.ud += du * d, m.vd += dv * d;
    return m;
  }

  struct Fit {
    PixelPlane plane;
    double sse = 0;  ///< sum of squared residuals, vertical in d
  };
  /** \brief Least squares of d on (u, v): METHOD 5.1 in pixel coordinates. Fewer than three pixels, or
   * pixels on one line, give the horizontal plane through their mean. */
  Fit fit() const {
    if (n < 1) return {};
    const double mu = u / n, mv = v / n, md = d / n;
    const double cuu = uu - u * mu, cuv = uv - u * mv, cvv = vv - v * mv;
    const double cud = ud - u * md, cvd = vd - v * md, cdd = dd - d * md;
    const double det = cuu * cvv - cuv * cuv;
    Fit f;
    if (n >= 3 && det > 1e-9 * std::max(1.0, cuu * cvv)) {
      f.plane.a = (cud * cvv - cvd * cuv) / det;
      f.plane.b = (cvd * cuu - cud * cuv) / det;
    }
    f.plane.c = md - f.plane.a * mu - f.plane.b * mv;
    f.sse = std::max(0.0, cdd - f.plane.a * cud - f.plane.b * cvd);
    return f;
  }
};

}  // namespace facetloc

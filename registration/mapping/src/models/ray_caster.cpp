// SPDX-License-Identifier: BSD-3-Clause
#include "models/ray_caster.h"

#include <limits>
#include <new>
#include <stdexcept>

namespace facetloc::internal {
namespace {

/** The depth at which a ray, whose direction has the depth 1, meets the scene; 0 if it meets nothing. */
float depthAlong(RTCScene scene, RTCIntersectContext& context, const Eigen::Vector3f& origin,
                 const Eigen::Vector3f& direction, bool fronts_only) {
  RTCRayHit ray;
  ray.ray.org_x = origin.x(), ray.ray.org_y = origin.y(), ray.ray.org_z = origin.z();
  ray.ray.dir_x = direction.x(), ray.ray.dir_y = direction.y(), ray.ray.dir_z = direction.z();
  ray.ray.tnear = kNearestMeasured, ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.time = 0, ray.ray.mask = ~0u, ray.ray.id = 0, ray.ray.flags = 0;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID, ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return 0;
  const Eigen::Vector3f normal(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
  return fronts_only && normal.dot(direction) > 0 ? 0 : ray.ray.tfar;
}

}  // namespace

RayCaster::RayCaster() : device_(rtcNewDevice(nullptr)) {
  if (!device_) throw std::runtime_error("Embree, which casts rays, does not start on this machine");
}

RayCaster::~RayCaster() {
  if (geometry_) rtcReleaseGeometry(geometry_);
  if (scene_) rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void RayCaster::requireNoError() const {
  switch (rtcGetDeviceError(device_)) {
  case RTC_ERROR_NONE:
    return;
  case RTC_ERROR_OUT_OF_MEMORY:
    throw std::bad_alloc();
  default:
    throw std::runtime_error("Embree cannot take the surface");
  }
}

template <class Number>
Number* RayCaster::buffer(RTCBufferType type, RTCFormat format, std::size_t numbers, std::size_t items) {
  void* const memory = rtcSetNewGeometryBuffer(geometry_, type, 0, format, numbers * sizeof(Number), items);
  requireNoError();
  return static_cast<Number*>(memory);
}

void RayCaster::commit() {
  scene_ = rtcNewScene(device_);
  // A ray between two triangles that share an edge must not pass, and large models fit into memory.
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT);
  rtcCommitGeometry(geometry_);
  rtcAttachGeometry(scene_, geometry_);
  rtcCommitScene(scene_);
  requireNoError();
}

void RayCaster::setTriangles(std::size_t vertices, std::size_t triangles,
                             const std::function<void(const Triangles&)>& fill) {
  geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  fill({buffer<float>(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3, vertices),
        buffer<std::uint32_t>(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3, triangles)});
  commit();
}

void RayCaster::setDiscs(std::size_t discs, const std::function<void(const Discs&)>& fill) {
  geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
  fill({buffer<float>(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 4, discs),
        buffer<float>(RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, 3, discs)});
  commit();
}

DepthImage RayCaster::depth(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c,
                            bool fronts_only) const {
  DepthImage image{camera, {}};
  if (!camera.valid()) return image;
  if (!T_w_c.matrix().allFinite()) {  // Embree ends the program for such a ray
    image.depth.assign(static_cast<std::size_t>(camera.width) * camera.height, 0.f);
    return image;
  }
  image.depth.reserve(static_cast<std::size_t>(camera.width) * camera.height);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  const Eigen::Vector3f origin = T_w_c.translation().cast<float>();
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3f direction = (T_w_c.linear() * camera.ray(u, v)).cast<float>();
      image.depth.push_back(depthAlong(scene_, context, origin, direction, fronts_only));
    }
  return image;
}

}  // namespace facetloc::internal

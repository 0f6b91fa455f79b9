#include "common/synthetic/ray_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "absl/strings/str_cat.h"

namespace treeline {
namespace {

constexpr size_t kPacket = 8;
constexpr float kOffset_m = 0.001f;
// One thread builds the tree, so that it is the same each time; the
// instruction set is fixed because each rounds in its own way.
constexpr char kDeviceOptions[] = "threads=1,set_affinity=0,max_isa=avx2";

RTCIntersectContext MakeContext(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

// All surfaces as one geometry; null if there is no memory.
RTCGeometry MakeGeometry(RTCDevice device, const World& world) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  const size_t count = world.surfaces.size();
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                              RTC_FORMAT_FLOAT3, sizeof(Float3), 4 * count));
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                              RTC_FORMAT_UINT4, 4 * sizeof(uint32_t), count));
  if (vertices == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    return nullptr;
  }
  for (const Surface& surface : world.surfaces) {
    for (const Float3& corner : surface.corners) {
      *vertices++ = corner.x;
      *vertices++ = corner.y;
      *vertices++ = corner.z;
    }
  }
  for (uint32_t i = 0; i < 4 * count; ++i) *indices++ = i;
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCScene MakeScene(RTCDevice device, RTCGeometry geometry,
                   RTCSceneFlags flags) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, flags);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  return scene;
}

RayHit CastOne(RTCScene scene, Float3 origin, Float3 direction) {
  RTCRayHit query = {};
  query.ray.org_x = origin.x;
  query.ray.org_y = origin.y;
  query.ray.org_z = origin.z;
  query.ray.dir_x = direction.x;
  query.ray.dir_y = direction.y;
  query.ray.dir_z = direction.z;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = 0xffffffffu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context = MakeContext(false);
  rtcIntersect1(scene, &context, &query);
  return {query.hit.primID, query.hit.u, query.hit.v, query.ray.tfar};
}

}  // namespace

void RayCaster::DeviceDeleter::operator()(RTCDeviceTy* device) const {
  rtcReleaseDevice(device);
}

void RayCaster::SceneDeleter::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}

absl::StatusOr<RayCaster> RayCaster::Create(const World& world) {
  RayCaster caster;
  caster.device_.reset(rtcNewDevice(kDeviceOptions));
  RTCDevice device = caster.device_.get();
  if (device == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("Embree does not start: error ",
                     static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  RTCGeometry geometry = MakeGeometry(device, world);
  if (geometry == nullptr) {
    return absl::ResourceExhaustedError("no memory for a synthetic world");
  }
  caster.fast_scene_.reset(MakeScene(device, geometry, RTC_SCENE_FLAG_NONE));
  caster.robust_scene_.reset(
      MakeScene(device, geometry, RTC_SCENE_FLAG_ROBUST));
  rtcReleaseGeometry(geometry);
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    return absl::UnavailableError(absl::StrCat(
        "Embree cannot build a world: error ", static_cast<int>(error)));
  }
  return caster;
}

RayHit RayCaster::Cast(Float3 origin, Float3 direction) const {
  const RayHit hit = CastOne(fast_scene_.get(), origin, direction);
  return hit.surface != RayHit::kNothing ? hit : CastRobust(origin, direction);
}

RayHit RayCaster::CastRobust(Float3 origin, Float3 direction) const {
  return CastOne(robust_scene_.get(), origin, direction);
}

void RayCaster::CastMany(Float3 origin, std::span<const Float3> directions,
                         std::span<RayHit> hits) const {
  RTCIntersectContext context = MakeContext(true);
  for (size_t first = 0; first < directions.size(); first += kPacket) {
    const size_t count = std::min(kPacket, directions.size() - first);
    alignas(32) int valid[kPacket];
    RTCRayHit8 query = {};
    for (size_t i = 0; i < kPacket; ++i) {
      const Float3 direction = directions[first + std::min(i, count - 1)];
      valid[i] = i < count ? -1 : 0;
      query.ray.org_x[i] = origin.x;
      query.ray.org_y[i] = origin.y;
      query.ray.org_z[i] = origin.z;
      query.ray.dir_x[i] = direction.x;
      query.ray.dir_y[i] = direction.y;
      query.ray.dir_z[i] = direction.z;
      query.ray.tfar[i] = std::numeric_limits<float>::infinity();
      query.ray.mask[i] = 0xffffffffu;
      query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      query.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid, fast_scene_.get(), &context, &query);
    for (size_t i = 0; i < count; ++i) {
      hits[first + i] = query.hit.primID[i] == RTC_INVALID_GEOMETRY_ID
                            ? CastRobust(origin, directions[first + i])
                            : RayHit{query.hit.primID[i], query.hit.u[i],
                                     query.hit.v[i], query.ray.tfar[i]};
    }
  }
}

bool RayCaster::IsFree(Float3 from, Float3 to) const {
  const Float3 way = to - from;
  const float length = Norm(way);
  if (length <= 2 * kOffset_m) return true;
  RTCRay ray = {};
  ray.org_x = from.x;
  ray.org_y = from.y;
  ray.org_z = from.z;
  ray.dir_x = way.x;
  ray.dir_y = way.y;
  ray.dir_z = way.z;
  ray.tnear = kOffset_m / length;
  ray.tfar = 1 - kOffset_m / length;
  ray.mask = 0xffffffffu;
  RTCIntersectContext context = MakeContext(false);
  rtcOccluded1(fast_scene_.get(), &context, &ray);
  return ray.tfar >= 0;
}

}  // namespace treeline

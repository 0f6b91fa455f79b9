#include "simulation/renderer/ray_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::renderer {
namespace {

constexpr size_t kPacket = 8;
constexpr size_t kBatchPackets = 4;
constexpr float kOffset_m = 0.001f;
constexpr float kFar_m = std::numeric_limits<float>::infinity();
// One thread builds the tree, so that it is the same each time; the
// instruction set is fixed because each rounds in its own way.
constexpr char kDeviceOptions[] = "threads=1,set_affinity=0,max_isa=avx2";

RTCIntersectContext MakeContext(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

// Some of the surfaces as one geometry; null if there is no memory.
RTCGeometry MakeGeometry(RTCDevice device,
                         std::span<const worlds::Surface> surfaces,
                         std::span<const uint32_t> chosen) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  const size_t count = chosen.size();
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
      sizeof(worlds::Float3), 4 * count));
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                              RTC_FORMAT_UINT4, 4 * sizeof(uint32_t), count));
  if (vertices == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    return nullptr;
  }
  for (const uint32_t surface : chosen) {
    for (const worlds::Float3& corner : surfaces[surface].corners) {
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

// A scene of some of the surfaces, none of them if there are none. The error
// is the device's.
RTCScene MakeScene(RTCDevice device, std::span<const worlds::Surface> surfaces,
                   std::span<const uint32_t> chosen, RTCSceneFlags flags) {
  RTCGeometry geometry = MakeGeometry(device, surfaces, chosen);
  if (geometry == nullptr) return nullptr;
  RTCScene scene = MakeScene(device, geometry, flags);
  rtcReleaseGeometry(geometry);
  return scene;
}

RayHit CastOne(RTCScene scene, worlds::Float3 origin, worlds::Float3 direction,
               float max_distance = kFar_m) {
  RTCRayHit query = {};
  query.ray.org_x = origin.x;
  query.ray.org_y = origin.y;
  query.ray.org_z = origin.z;
  query.ray.dir_x = direction.x;
  query.ray.dir_y = direction.y;
  query.ray.dir_z = direction.z;
  query.ray.tfar = max_distance;
  query.ray.mask = 0xffffffffu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context = MakeContext(false);
  rtcIntersect1(scene, &context, &query);
  return {.surface = query.hit.primID,
          .instance = static_cast<int32_t>(query.hit.instID[0]),
          .u = query.hit.u,
          .v = query.hit.v,
          .distance = query.ray.tfar};
}

// Where the rays of a packet begin: each for itself, or (step 0) all together.
struct Origins {
  const worlds::Float3* first = nullptr;
  size_t step = 0;

  const worlds::Float3& operator[](size_t i) const { return first[i * step]; }
};

// Some packets of rays, side by side.
struct RayBatch {
  std::array<RTCRayHit8, kBatchPackets> packets;

  void Set(size_t i, worlds::Float3 origin, worlds::Float3 direction,
           float max_distance) {
    RTCRayHit8& packet = packets[i / kPacket];
    const size_t lane = i % kPacket;
    packet.ray.org_x[lane] = origin.x;
    packet.ray.org_y[lane] = origin.y;
    packet.ray.org_z[lane] = origin.z;
    packet.ray.dir_x[lane] = direction.x;
    packet.ray.dir_y[lane] = direction.y;
    packet.ray.dir_z[lane] = direction.z;
    packet.ray.tnear[lane] = 0;
    packet.ray.tfar[lane] = max_distance;
    packet.ray.time[lane] = 0;
    packet.ray.mask[lane] = 0xffffffffu;
    packet.ray.id[lane] = 0;
    packet.ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
  // Replaces `hit` if the ray met something.
  void Get(size_t i, RayHit& hit) const {
    const RTCRayHit8& packet = packets[i / kPacket];
    const size_t lane = i % kPacket;
    if (packet.hit.primID[lane] == RTC_INVALID_GEOMETRY_ID) return;
    hit = {.surface = packet.hit.primID[lane],
           .instance = static_cast<int32_t>(packet.hit.instID[0][lane]),
           .u = packet.hit.u[lane],
           .v = packet.hit.v[lane],
           .distance = packet.ray.tfar[lane]};
  }
};

// Casts rays, each no further than hits[i].distance; those that meet something
// replace hits[i]. Embree takes a batch as one bundle, a third faster than
// packet by packet.
void CastBatches(RTCScene scene, const Origins& origins,
                 std::span<const worlds::Float3> directions,
                 std::span<RayHit> hits) {
  constexpr size_t kBatch = kPacket * kBatchPackets;
  RayBatch batch;
  for (size_t first = 0; first < directions.size(); first += kBatch) {
    const size_t count = std::min(kBatch, directions.size() - first);
    const size_t packets = (count + kPacket - 1) / kPacket;
    for (size_t i = 0; i < packets * kPacket; ++i) {
      // The last packet is filled up with rays that end before they begin.
      const size_t ray = first + std::min(i, count - 1);
      batch.Set(i, origins[ray], directions[ray],
                i < count ? hits[ray].distance : -1);
    }
    RTCIntersectContext context = MakeContext(true);
    rtcIntersectNM(scene, &context,
                   reinterpret_cast<RTCRayHitN*>(batch.packets.data()), kPacket,
                   static_cast<unsigned>(packets), sizeof(RTCRayHit8));
    for (size_t i = 0; i < count; ++i) batch.Get(i, hits[first + i]);
  }
}

bool IsFreeIn(RTCScene scene, worlds::Float3 from, worlds::Float3 to) {
  const worlds::Float3 way = to - from;
  const float length = worlds::Norm(way);
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
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar >= 0;
}

// Row-major 3x4, as Embree wants it.
std::array<float, 12> MatrixOf(const worlds::BodyInstance& instance) {
  const worlds::Placement& at = instance.world_from_body;
  const worlds::Float3 x = instance.scale.x * at.Direction({1, 0, 0});
  const worlds::Float3 y = instance.scale.y * at.Direction({0, 1, 0});
  const worlds::Float3 z = instance.scale.z * at.Direction({0, 0, 1});
  return {x.x, y.x,         z.x, at.origin.x, x.y, y.y,
          z.y, at.origin.y, x.z, y.z,         z.z, at.origin.z};
}

}  // namespace

void RayCaster::DeviceDeleter::operator()(RTCDeviceTy* device) const {
  rtcReleaseDevice(device);
}

void RayCaster::SceneDeleter::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}

absl::StatusOr<RayCaster> RayCaster::Create(const worlds::World& world) {
  return CreateWithout(world, {});
}

absl::StatusOr<RayCaster> RayCaster::CreateWithout(
    const worlds::World& world,
    const std::function<bool(const worlds::Surface&)>& is_left_out) {
  RayCaster caster;
  caster.device_.reset(rtcNewDevice(kDeviceOptions));
  RTCDevice device = caster.device_.get();
  if (device == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("Embree does not start: error ",
                     static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  for (uint32_t i = 0; i < world.surfaces.size(); ++i) {
    if (is_left_out && is_left_out(world.surfaces[i])) continue;
    (world.surfaces[i].kind == worlds::SurfaceKind::kGlass
         ? caster.glass_surfaces_
         : caster.solid_surfaces_)
        .push_back(i);
  }
  const std::vector<worlds::Surface>& surfaces = world.surfaces;
  caster.fast_scene_.reset(
      MakeScene(device, surfaces, caster.solid_surfaces_, RTC_SCENE_FLAG_NONE));
  caster.robust_scene_.reset(MakeScene(device, surfaces, caster.solid_surfaces_,
                                       RTC_SCENE_FLAG_ROBUST));
  if (!caster.glass_surfaces_.empty()) {
    caster.glass_scene_.reset(MakeScene(
        device, surfaces, caster.glass_surfaces_, RTC_SCENE_FLAG_ROBUST));
  }
  for (const worlds::Body& body : world.bodies) {
    std::vector<uint32_t> all(body.surfaces.size());
    std::iota(all.begin(), all.end(), 0u);
    caster.body_scenes_.emplace_back(
        MakeScene(device, body.surfaces, all, RTC_SCENE_FLAG_ROBUST));
  }
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return absl::ResourceExhaustedError("no memory for a synthetic world");
  }
  if (error != RTC_ERROR_NONE) {
    return absl::UnavailableError(absl::StrCat(
        "Embree cannot build a world: error ", static_cast<int>(error)));
  }
  return caster;
}

RayHit RayCaster::Cast(worlds::Float3 origin, worlds::Float3 direction) const {
  RayHit hit = CastOne(fast_scene_.get(), origin, direction);
  if (hit.surface == RayHit::kNothing) return CastRobust(origin, direction);
  hit.surface = solid_surfaces_[hit.surface];
  return hit;
}

RayHit RayCaster::CastRobust(worlds::Float3 origin,
                             worlds::Float3 direction) const {
  RayHit hit = CastOne(robust_scene_.get(), origin, direction);
  if (hit.surface != RayHit::kNothing) {
    hit.surface = solid_surfaces_[hit.surface];
  }
  return hit;
}

void RayCaster::CastMany(worlds::Float3 origin,
                         std::span<const worlds::Float3> directions,
                         std::span<RayHit> hits) const {
  CastFrom(&origin, 0, directions, hits);
}

void RayCaster::CastMany(std::span<const worlds::Float3> origins,
                         std::span<const worlds::Float3> directions,
                         std::span<RayHit> hits) const {
  CastFrom(origins.data(), 1, directions, hits);
}

void RayCaster::CastFrom(const worlds::Float3* origins, size_t origin_step,
                         std::span<const worlds::Float3> directions,
                         std::span<RayHit> hits) const {
  const Origins from = {origins, origin_step};
  for (RayHit& hit : hits) hit = {.distance = kFar_m};
  CastBatches(fast_scene_.get(), from, directions, hits);
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].surface == RayHit::kNothing) {
      hits[i] = CastRobust(from[i], directions[i]);
    } else {
      hits[i].surface = solid_surfaces_[hits[i].surface];
    }
  }
}

bool RayCaster::IsFree(worlds::Float3 from, worlds::Float3 to) const {
  return IsFreeIn(fast_scene_.get(), from, to);
}

RayHit RayCaster::CastGlass(worlds::Float3 origin,
                            worlds::Float3 direction) const {
  if (!has_glass()) return {};
  RayHit hit = CastOne(glass_scene_.get(), origin, direction);
  if (hit.surface != RayHit::kNothing) {
    hit.surface = glass_surfaces_[hit.surface];
  }
  return hit;
}

void RayCaster::CastManyAtGlass(worlds::Float3 origin,
                                std::span<const worlds::Float3> directions,
                                std::span<RayHit> hits) const {
  CastAtGlassFrom(&origin, 0, directions, hits);
}

void RayCaster::CastManyAtGlass(std::span<const worlds::Float3> origins,
                                std::span<const worlds::Float3> directions,
                                std::span<RayHit> hits) const {
  CastAtGlassFrom(origins.data(), 1, directions, hits);
}

void RayCaster::CastAtGlassFrom(const worlds::Float3* origins,
                                size_t origin_step,
                                std::span<const worlds::Float3> directions,
                                std::span<RayHit> hits) const {
  for (RayHit& hit : hits) hit = {.distance = kFar_m};
  if (!has_glass()) return;
  CastBatches(glass_scene_.get(), {origins, origin_step}, directions, hits);
  for (RayHit& hit : hits) {
    if (hit.surface != RayHit::kNothing) {
      hit.surface = glass_surfaces_[hit.surface];
    }
  }
}

WorldSnapshot RayCaster::At(std::vector<worlds::BodyInstance> instances) const {
  return WorldSnapshot(*this, std::move(instances));
}

WorldSnapshot::WorldSnapshot(const RayCaster& fixed,
                             std::vector<worlds::BodyInstance> instances)
    : fixed_(&fixed), instances_(std::move(instances)) {
  if (instances_.empty()) return;
  RTCDevice device = fixed.device_.get();
  scene_.reset(rtcNewScene(device));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  for (uint32_t i = 0; i < instances_.size(); ++i) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    const size_t body = static_cast<size_t>(instances_[i].body);
    rtcSetGeometryInstancedScene(geometry, fixed.body_scenes_[body].get());
    const std::array<float, 12> matrix = MatrixOf(instances_[i]);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                            matrix.data());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, i);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene_.get());
}

RayHit WorldSnapshot::Cast(worlds::Float3 origin,
                           worlds::Float3 direction) const {
  const RayHit fixed = fixed_->Cast(origin, direction);
  if (scene_ == nullptr) return fixed;
  const float limit =
      fixed.surface == RayHit::kNothing ? kFar_m : fixed.distance;
  const RayHit moving = CastOne(scene_.get(), origin, direction, limit);
  return moving.surface == RayHit::kNothing ? fixed : moving;
}

void WorldSnapshot::CastMany(worlds::Float3 origin,
                             std::span<const worlds::Float3> directions,
                             std::span<RayHit> hits) const {
  fixed_->CastMany(origin, directions, hits);
  if (scene_ == nullptr) return;
  CastBatches(scene_.get(), {&origin, 0}, directions, hits);
}

void WorldSnapshot::CastMany(std::span<const worlds::Float3> origins,
                             std::span<const worlds::Float3> directions,
                             std::span<RayHit> hits) const {
  fixed_->CastMany(origins, directions, hits);
  if (scene_ == nullptr) return;
  CastBatches(scene_.get(), {origins.data(), 1}, directions, hits);
}

bool WorldSnapshot::IsFree(worlds::Float3 from, worlds::Float3 to) const {
  return fixed_->IsFree(from, to) &&
         (scene_ == nullptr || IsFreeIn(scene_.get(), from, to));
}

}  // namespace treeline::renderer

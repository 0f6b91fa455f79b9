// Where rays meet the surfaces of a world (Embree).
#ifndef SIMULATION_RENDERER_RAY_CASTER_H_
#define SIMULATION_RENDERER_RAY_CASTER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "simulation/worlds/world.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace treeline::renderer {

struct RayHit {
  static constexpr uint32_t kNothing = 0xffffffffu;
  // Among the world's surfaces, or those of the body that was hit.
  uint32_t surface = kNothing;
  // Which of a snapshot's bodies; kFixed: what never moves.
  static constexpr int32_t kFixed = -1;
  int32_t instance = kFixed;
  float u = 0;
  float v = 0;
  // In lengths of the ray's direction.
  float distance = 0;
};

class WorldSnapshot;

// What never moves, panes of glass apart: rays go through them. Immutable and
// thread-safe. Results do not depend on threads; on machines without AVX2 they
// may differ in the last bits.
class RayCaster {
 public:
  // Copies what it needs of `world`. UNAVAILABLE if Embree does not start.
  static absl::StatusOr<RayCaster> Create(const worlds::World& world);
  // The same without the surfaces that `is_left_out` names; may be empty.
  static absl::StatusOr<RayCaster> CreateWithout(
      const worlds::World& world,
      const std::function<bool(const worlds::Surface&)>& is_left_out);

  // The world with bodies at these places. Costs tens of microseconds. This
  // caster must outlive it.
  WorldSnapshot At(std::vector<worlds::BodyInstance> instances) const;

  // The first surface along a ray; it is seen from both sides.
  RayHit Cast(worlds::Float3 origin, worlds::Float3 direction) const;

  // Casts rays from one origin, many at a time: hits[i] is for directions[i].
  // Faster than single casts where each 32 look about the same way. Both spans
  // have the same length.
  void CastMany(worlds::Float3 origin,
                std::span<const worlds::Float3> directions,
                std::span<RayHit> hits) const;
  // The same, each ray from an origin of its own.
  void CastMany(std::span<const worlds::Float3> origins,
                std::span<const worlds::Float3> directions,
                std::span<RayHit> hits) const;

  // Whether nothing lies between two points (their own surroundings of 1 mm
  // excepted).
  bool IsFree(worlds::Float3 from, worlds::Float3 to) const;

  // The first pane of glass along a ray.
  bool has_glass() const { return glass_scene_ != nullptr; }
  RayHit CastGlass(worlds::Float3 origin, worlds::Float3 direction) const;
  void CastManyAtGlass(worlds::Float3 origin,
                       std::span<const worlds::Float3> directions,
                       std::span<RayHit> hits) const;
  void CastManyAtGlass(std::span<const worlds::Float3> origins,
                       std::span<const worlds::Float3> directions,
                       std::span<RayHit> hits) const;

 private:
  friend class WorldSnapshot;
  struct DeviceDeleter {
    void operator()(RTCDeviceTy* device) const;
  };
  struct SceneDeleter {
    void operator()(RTCSceneTy* scene) const;
  };
  RayCaster() = default;
  RayHit CastRobust(worlds::Float3 origin, worlds::Float3 direction) const;
  void CastAtGlassFrom(const worlds::Float3* origins, size_t origin_step,
                       std::span<const worlds::Float3> directions,
                       std::span<RayHit> hits) const;
  void CastFrom(const worlds::Float3* origins, size_t origin_step,
                std::span<const worlds::Float3> directions,
                std::span<RayHit> hits) const;

  std::unique_ptr<RTCDeviceTy, DeviceDeleter> device_;
  // The fast one may let a ray in a million slip between two surfaces; the
  // robust one, at less than half the speed, sees where it went.
  std::unique_ptr<RTCSceneTy, SceneDeleter> fast_scene_;
  std::unique_ptr<RTCSceneTy, SceneDeleter> robust_scene_;
  // Null: there is no glass.
  std::unique_ptr<RTCSceneTy, SceneDeleter> glass_scene_;
  // Which of the world's surfaces the parts of the above are.
  std::vector<uint32_t> solid_surfaces_;
  std::vector<uint32_t> glass_surfaces_;
  // One for each of the world's bodies.
  std::vector<std::unique_ptr<RTCSceneTy, SceneDeleter>> body_scenes_;
};

// The surfaces of a world with its bodies where they are at one moment.
// Immutable and thread-safe; the same rules as for RayCaster.
class WorldSnapshot {
 public:
  const std::vector<worlds::BodyInstance>& instances() const {
    return instances_;
  }
  const RayCaster& fixed() const { return *fixed_; }

  RayHit Cast(worlds::Float3 origin, worlds::Float3 direction) const;
  void CastMany(worlds::Float3 origin,
                std::span<const worlds::Float3> directions,
                std::span<RayHit> hits) const;
  void CastMany(std::span<const worlds::Float3> origins,
                std::span<const worlds::Float3> directions,
                std::span<RayHit> hits) const;
  bool IsFree(worlds::Float3 from, worlds::Float3 to) const;

 private:
  friend class RayCaster;
  WorldSnapshot(const RayCaster& fixed,
                std::vector<worlds::BodyInstance> instances);

  const RayCaster* fixed_;
  std::vector<worlds::BodyInstance> instances_;
  // Null: there is no body.
  std::unique_ptr<RTCSceneTy, RayCaster::SceneDeleter> scene_;
};

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_RAY_CASTER_H_

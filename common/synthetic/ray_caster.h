// Where rays meet the surfaces of a world (Embree).
#ifndef COMMON_SYNTHETIC_RAY_CASTER_H_
#define COMMON_SYNTHETIC_RAY_CASTER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/synthetic/world.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace treeline {

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
  static absl::StatusOr<RayCaster> Create(const World& world);
  // The same without the surfaces that `is_left_out` names; may be empty.
  static absl::StatusOr<RayCaster> CreateWithout(
      const World& world,
      const std::function<bool(const Surface&)>& is_left_out);

  // The world with bodies at these places. Costs tens of microseconds. This
  // caster must outlive it.
  WorldSnapshot At(std::vector<BodyInstance> instances) const;

  // The first surface along a ray; it is seen from both sides.
  RayHit Cast(Float3 origin, Float3 direction) const;

  // Casts rays from one origin, many at a time: hits[i] is for directions[i].
  // Faster than single casts where each 32 look about the same way. Both spans
  // have the same length.
  void CastMany(Float3 origin, std::span<const Float3> directions,
                std::span<RayHit> hits) const;
  // The same, each ray from an origin of its own.
  void CastMany(std::span<const Float3> origins,
                std::span<const Float3> directions,
                std::span<RayHit> hits) const;

  // Whether nothing lies between two points (their own surroundings of 1 mm
  // excepted).
  bool IsFree(Float3 from, Float3 to) const;

  // The first pane of glass along a ray.
  bool has_glass() const { return glass_scene_ != nullptr; }
  RayHit CastGlass(Float3 origin, Float3 direction) const;
  void CastManyAtGlass(Float3 origin, std::span<const Float3> directions,
                       std::span<RayHit> hits) const;
  void CastManyAtGlass(std::span<const Float3> origins,
                       std::span<const Float3> directions,
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
  RayHit CastRobust(Float3 origin, Float3 direction) const;
  void CastAtGlassFrom(const Float3* origins, size_t origin_step,
                       std::span<const Float3> directions,
                       std::span<RayHit> hits) const;
  void CastFrom(const Float3* origins, size_t origin_step,
                std::span<const Float3> directions,
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
  const std::vector<BodyInstance>& instances() const { return instances_; }
  const RayCaster& fixed() const { return *fixed_; }

  RayHit Cast(Float3 origin, Float3 direction) const;
  void CastMany(Float3 origin, std::span<const Float3> directions,
                std::span<RayHit> hits) const;
  void CastMany(std::span<const Float3> origins,
                std::span<const Float3> directions,
                std::span<RayHit> hits) const;
  bool IsFree(Float3 from, Float3 to) const;

 private:
  friend class RayCaster;
  WorldSnapshot(const RayCaster& fixed, std::vector<BodyInstance> instances);

  const RayCaster* fixed_;
  std::vector<BodyInstance> instances_;
  // Null: there is no body.
  std::unique_ptr<RTCSceneTy, RayCaster::SceneDeleter> scene_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_RAY_CASTER_H_

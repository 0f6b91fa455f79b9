// Where rays meet the surfaces of a world (Embree).
#ifndef COMMON_SYNTHETIC_RAY_CASTER_H_
#define COMMON_SYNTHETIC_RAY_CASTER_H_

#include <cstdint>
#include <memory>
#include <span>

#include "absl/status/statusor.h"
#include "common/synthetic/world.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace treeline {

struct RayHit {
  static constexpr uint32_t kNothing = 0xffffffffu;
  uint32_t surface = kNothing;
  float u = 0;
  float v = 0;
  // In lengths of the ray's direction.
  float distance = 0;
};

// Immutable and thread-safe. Results do not depend on threads; on machines
// without AVX2 they may differ in the last bits.
class RayCaster {
 public:
  // Copies what it needs of `world`. UNAVAILABLE if Embree does not start.
  static absl::StatusOr<RayCaster> Create(const World& world);

  // The first surface along a ray; it is seen from both sides.
  RayHit Cast(Float3 origin, Float3 direction) const;

  // Casts rays from one origin, many at a time: hits[i] is for directions[i].
  // Faster than single casts where neighbours look the same way. Both spans
  // have the same length.
  void CastMany(Float3 origin, std::span<const Float3> directions,
                std::span<RayHit> hits) const;

  // Whether nothing lies between two points (their own surroundings of 1 mm
  // excepted).
  bool IsFree(Float3 from, Float3 to) const;

 private:
  struct DeviceDeleter {
    void operator()(RTCDeviceTy* device) const;
  };
  struct SceneDeleter {
    void operator()(RTCSceneTy* scene) const;
  };
  RayCaster() = default;
  RayHit CastRobust(Float3 origin, Float3 direction) const;

  std::unique_ptr<RTCDeviceTy, DeviceDeleter> device_;
  // The fast one may let a ray in a million slip between two surfaces; the
  // robust one, at less than half the speed, sees where it went.
  std::unique_ptr<RTCSceneTy, SceneDeleter> fast_scene_;
  std::unique_ptr<RTCSceneTy, SceneDeleter> robust_scene_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_RAY_CASTER_H_

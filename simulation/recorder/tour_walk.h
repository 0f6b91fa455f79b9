// Somebody walks the tour of a building with a camera in hand, looking around.
#ifndef SIMULATION_RECORDER_TOUR_WALK_H_
#define SIMULATION_RECORDER_TOUR_WALK_H_

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline::recorder {

// A smooth path for all times, round after round at 0.8 m/s: corners are
// rounded, the camera is 1.2 to 1.6 m above the ground below it, and keeps
// 0.4 m from what stands at its height where the tour has the room. It looks
// ahead and around, each time and with each seed to other sides.
class TourWalk {
 public:
  static constexpr double kSpeed_mps = 0.8;

  // INVALID_ARGUMENT for a world without a tour, or with one of no length.
  static absl::StatusOr<TourWalk> Create(const worlds::World& world,
                                         const renderer::RayCaster& caster,
                                         uint64_t seed);

  geometry::Rigid3 WorldFromCameraAt(double time_s) const;

  // Of one round (m).
  double length_m() const { return length_m_; }

 private:
  TourWalk() = default;
  // The ground below the way after so many metres.
  geometry::Vec3 At(double way_m) const;
  double Wave(int k, double period_s, double time_s) const;

  // Points on the ground, a few centimetres apart: a closed way.
  std::vector<geometry::Vec3> way_;
  double length_m_ = 0;
  double start_m_ = 0;
  double direction_ = 1;
  std::array<double, 8> phases_{};
};

// world_from_camera at each time (s).
using CameraPath = std::function<geometry::Rigid3(double)>;

// The walk through this world: Walk where it has a walk area, TourWalk where
// it has a tour. INVALID_ARGUMENT if it has neither.
absl::StatusOr<CameraPath> MakeCameraPath(const worlds::World& world,
                                          const renderer::RayCaster& caster,
                                          uint64_t seed);

}  // namespace treeline::recorder

#endif  // SIMULATION_RECORDER_TOUR_WALK_H_

#include "simulation/worlds/generated_world.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/plan_generator.h"
#include "simulation/worlds/building_maker.h"
#include "simulation/worlds/ground_truth.h"

namespace treeline::worlds {
namespace {

constexpr int kAttempts = 50;

absl::StatusOr<bool> IsConnected(const building::BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const World world,
      MakeBuilding("generated", plan,
                   {.with_people = false, .threads = 1, .paint = false}));
  TL_ASSIGN_OR_RETURN(const GroundTruth truth,
                      GroundTruth::Compute(world, GroundTruthOptions()));
  const GroundTruth::Reach reach = truth.ReachableFrom(
      world.places[0].placement.origin, kGeneratedRobotRadius_m);
  for (const NamedPlace& place : world.places) {
    const auto index = truth.Find(place.placement.origin);
    if (!index || !reach.Contains(*index)) return false;
  }
  std::vector<Float3> tour = world.tour;
  tour.push_back(tour.front());
  return truth.IsDriveable(tour, kGeneratedRobotRadius_m);
}

}  // namespace

absl::StatusOr<building::BuildingPlan> GeneratedPlan(uint64_t seed) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    building::BuildingPlan plan = building::DrawPlan(seed, attempt);
    TL_ASSIGN_OR_RETURN(const bool is_connected, IsConnected(plan));
    if (is_connected) return plan;
  }
  return absl::InternalError(
      absl::StrCat("no building of seed ", seed, " is connected"));
}

}  // namespace treeline::worlds

#include "simulation/worlds/generated_world.h"

#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/office_generator.h"
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

// Of the attempts that `draw` makes.
absl::StatusOr<building::BuildingPlan> FirstConnected(
    absl::FunctionRef<building::BuildingPlan(int)> draw) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    building::BuildingPlan plan = draw(attempt);
    TL_ASSIGN_OR_RETURN(const bool is_connected, IsConnected(plan));
    if (is_connected) return plan;
  }
  return absl::NotFoundError(
      absl::StrCat("of this number no building was found in ", kAttempts,
                   " drafts in which all rooms can be got to; take another"));
}

}  // namespace

absl::StatusOr<building::BuildingPlan> GeneratedPlan(uint64_t seed) {
  return FirstConnected(
      [&](int attempt) { return building::DrawPlan(seed, attempt); });
}

absl::StatusOr<building::BuildingPlan> OfficePlan(int area_m2, uint64_t seed) {
  if (area_m2 < building::kSmallestOffice_m2 ||
      area_m2 > building::kLargestOffice_m2) {
    return absl::InvalidArgumentError(absl::StrCat(
        "an office of ", area_m2, " m2; there are those of ",
        building::kSmallestOffice_m2, " to ", building::kLargestOffice_m2));
  }
  return FirstConnected([&](int attempt) {
    return building::DrawOffice(area_m2, seed, attempt);
  });
}

}  // namespace treeline::worlds

// Worlds of Gazebo as arbitrary bytes: an error that says where, or a plan that
// a world file can hold, of which a world can be made.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "simulation/building/gazebo_plan.h"
#include "simulation/building/gazebo_world.h"
#include "simulation/building/plan_file.h"
#include "simulation/worlds/building_maker.h"

namespace treeline {
namespace {

void Check(bool holds) {
  if (!holds) std::abort();
}

void Use(absl::string_view bytes) {
  const auto solids = building::ParseGazeboWorld(bytes, "world");
  if (!solids.ok()) {
    Check(absl::StartsWith(solids.status().message(), "world:"));
    return;
  }
  const auto plan = building::GazeboPlan(*solids, "world");
  if (!plan.ok()) {
    Check(absl::StartsWith(plan.status().message(), "world:"));
    return;
  }
  const auto again = building::ParsePlan(building::PlanText(*plan), "again");
  Check(again.ok() && *again == *plan);
  const auto world =
      worlds::MakeBuilding("world", *plan, {.threads = 1, .paint = false});
  if (world.ok()) Check(world->places.size() == plan->places.size());
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Use(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}

// World files as arbitrary text: an error that says where, or a building whose
// surfaces can be made, and that is the same when written and read again.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "simulation/building/plan_file.h"
#include "simulation/worlds/building_maker.h"

namespace treeline {
namespace {

void Check(bool holds) {
  if (!holds) std::abort();
}

bool IsFinite(worlds::Float3 p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void Use(absl::string_view bytes) {
  const auto plan = building::ParsePlan(bytes, "world");
  if (!plan.ok()) {
    Check(absl::StartsWith(plan.status().message(), "world:"));
    return;
  }
  const auto again = building::ParsePlan(building::PlanText(*plan), "again");
  Check(again.ok());
  const auto world =
      worlds::MakeBuilding("world", *plan, {.threads = 1, .paint = false});
  if (!world.ok()) return;  // too many surfaces
  for (const worlds::Surface& surface : world->surfaces) {
    for (const worlds::Float3& corner : surface.corners)
      Check(IsFinite(corner));
  }
  Check(world->places.size() == plan->places.size());
  Check(world->tour.size() == plan->tour.size());
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Use(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}

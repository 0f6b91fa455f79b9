#include "simulation/worlds/world.h"

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "simulation/building/cylinder_field.h"
#include "simulation/building/gazebo_plan.h"
#include "simulation/building/gazebo_world.h"
#include "simulation/building/moving_field.h"
#include "simulation/building/plan_file.h"
#include "simulation/building/shipped_worlds.h"
#include "simulation/worlds/building_maker.h"
#include "simulation/worlds/generated_world.h"
#include "simulation/worlds/rearrange.h"
#include "simulation/worlds/relight.h"
#include "simulation/worlds/room.h"

namespace treeline::worlds {
namespace {

constexpr size_t kMaxWorldFileBytes = size_t{1} << 20;

// As it is written, before anything is moved or lit otherwise.
absl::StatusOr<World> MakeNamed(absl::string_view name,
                                const WorldOptions& options) {
  if (name == "room") {
    return MakeRoom(std::string(name), std::nullopt, options.threads);
  }
  uint64_t seed = 0;
  absl::string_view rest = name;
  if (absl::ConsumePrefix(&rest, "room:") && absl::SimpleAtoi(rest, &seed)) {
    return MakeRoom(std::string(name), seed, options.threads);
  }
  rest = name;
  if (absl::ConsumePrefix(&rest, "seed:") && absl::SimpleAtoi(rest, &seed)) {
    TL_ASSIGN_OR_RETURN(const building::BuildingPlan plan, GeneratedPlan(seed));
    return MakeBuilding(std::string(name), plan, options);
  }
  rest = name;
  if (absl::ConsumePrefix(&rest, "office:")) {
    const std::vector<absl::string_view> parts = absl::StrSplit(rest, ':');
    int area_m2 = 0;
    if (parts.size() <= 2 && absl::SimpleAtoi(parts[0], &area_m2) &&
        (parts.size() == 1 || absl::SimpleAtoi(parts[1], &seed))) {
      TL_ASSIGN_OR_RETURN(const building::BuildingPlan plan,
                          OfficePlan(area_m2, seed));
      return MakeBuilding(std::string(name), plan, options);
    }
  }
  rest = name;
  if (absl::ConsumePrefix(&rest, "field:") && absl::SimpleAtoi(rest, &seed)) {
    return MakeBuilding(std::string(name),
                        building::FieldPlan(building::DrawField(seed)),
                        options);
  }
  rest = name;
  if (absl::ConsumePrefix(&rest, "moving-field:") &&
      absl::SimpleAtoi(rest, &seed)) {
    return MakeBuilding(
        std::string(name),
        building::MovingFieldPlan(building::DrawMovingField(seed)), options);
  }
  for (const building::ShippedWorld& shipped : building::ShippedWorlds()) {
    if (shipped.name != name) continue;
    TL_ASSIGN_OR_RETURN(
        const building::BuildingPlan plan,
        building::ParsePlan(shipped.text, absl::StrCat(name, ".yaml")));
    return MakeBuilding(std::string(name), plan, options);
  }
  if (IsGazeboWorld(name)) {
    TL_ASSIGN_OR_RETURN(
        const std::string text,
        base::ReadFile(std::string(name), building::kMaxGazeboBytes));
    TL_ASSIGN_OR_RETURN(const std::vector<building::GazeboSolid> solids,
                        building::ParseGazeboWorld(text, name));
    TL_ASSIGN_OR_RETURN(const building::BuildingPlan plan,
                        building::GazeboPlan(solids, name));
    return MakeBuilding(std::string(name), plan, options);
  }
  if (absl::EndsWith(name, ".yaml") || absl::StrContains(name, '/')) {
    TL_ASSIGN_OR_RETURN(const std::string text,
                        base::ReadFile(std::string(name), kMaxWorldFileBytes));
    TL_ASSIGN_OR_RETURN(const building::BuildingPlan plan,
                        building::ParsePlan(text, name));
    return MakeBuilding(std::string(name), plan, options);
  }
  std::string shipped_names;
  for (const building::ShippedWorld& shipped : building::ShippedWorlds()) {
    absl::StrAppend(&shipped_names, shipped.name, ", ");
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no world '", name, "'; there are ", shipped_names,
      "room, room:N, seed:N, field:N, moving-field:N and office:M2 with whole "
      "numbers, and files (NAME.yaml; NAME.world, of Gazebo)"));
}

}  // namespace

bool IsGazeboWorld(absl::string_view name) {
  return absl::EndsWith(name, ".world") || absl::EndsWith(name, ".sdf");
}

std::vector<BodyInstance> World::InstancesAt(double time_s) const {
  std::vector<BodyInstance> instances;
  for (size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].motion.has_value()) continue;
    instances.push_back({.body = static_cast<int>(i),
                         .world_from_body = bodies[i].motion->At(time_s)});
  }
  return instances;
}

absl::StatusOr<World> MakeWorld(absl::string_view name,
                                const WorldOptions& options) {
  TL_ASSIGN_OR_RETURN(World world, MakeNamed(name, options));
  Rearrange(options.rearranged, world);
  Relight(options.lighting.value_or(world.lighting), world);
  return world;
}

}  // namespace treeline::worlds

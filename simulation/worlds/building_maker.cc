#include "simulation/worlds/building_maker.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "simulation/worlds/building_fittings.h"
#include "simulation/worlds/building_shell.h"
#include "simulation/worlds/building_trim.h"
#include "simulation/worlds/furniture.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {
namespace {

// More would take minutes to light.
constexpr size_t kMaxSurfaces = 100000;

float F(double value) { return static_cast<float>(value); }

int Number(size_t i) { return static_cast<int>(i); }

void AddShell(const building::BuildingPlan& plan, BuildingShell& shell) {
  for (size_t i = 0; i < plan.rooms.size(); ++i) {
    shell.AddRoom(plan.rooms[i], Number(i));
  }
  for (const building::PlanPlatform& platform : plan.platforms) {
    shell.AddPlatform(platform);
  }
  for (const building::PlanRamp& ramp : plan.ramps) shell.AddRamp(ramp);
  for (const building::PlanStairs& stairs : plan.stairs) {
    shell.AddStairs(stairs);
  }
  for (size_t i = 0; i < plan.walls.size(); ++i) {
    shell.AddWall(plan.walls[i], Number(i));
  }
  for (const building::PlanPillar& pillar : plan.pillars) {
    shell.AddPillar(pillar);
  }
}

// Doors, windows and posters.
void AddWallFittings(const building::BuildingPlan& plan,
                     BuildingFittings& fittings) {
  for (size_t i = 0; i < plan.doors.size(); ++i) {
    fittings.AddDoor(plan.doors[i], Number(i));
  }
  for (const building::PlanWindow& window : plan.windows) {
    fittings.AddWindow(window);
  }
  for (const building::PlanPoster& poster : plan.posters)
    fittings.AddPoster(poster);
}

}  // namespace

absl::StatusOr<World> MakeBuilding(std::string name,
                                   const building::BuildingPlan& plan,
                                   const WorldOptions& options) {
  WorldBuilder builder;
  FurnitureMaker furniture(builder, plan.seed);
  builder.set_paint(options.paint);
  const BuildingTrim trim = MakeBuildingTrim(builder);
  BuildingShell shell(plan, trim, builder);
  BuildingFittings fittings(plan, options, trim, builder, shell, furniture);
  AddShell(plan, shell);
  AddWallFittings(plan, fittings);
  for (const building::PlanFurniture& piece : plan.furniture) {
    fittings.AddFurniture(piece);
    if (builder.surface_count() > kMaxSurfaces) break;
  }
  if (builder.surface_count() > kMaxSurfaces) {
    return absl::InvalidArgumentError(absl::StrCat(
        "world '", name, "' has more than ", kMaxSurfaces, " surfaces"));
  }
  if (options.with_people) {
    for (const building::PlanMover& mover : plan.movers) {
      fittings.AddMover(mover);
    }
  }
  fittings.AddCrate();
  World world =
      builder.Build(std::move(name),
                    {F(plan.size_m[0]), F(plan.size_m[1]), F(plan.size_m[2])},
                    {}, options.threads);
  world.lighting = plan.lighting;
  for (const building::PlanMover& mover : plan.movers) {
    std::vector<Float3>& way = world.ways.emplace_back();
    for (const building::PlanMover::Stop& stop : mover.path) {
      way.push_back(
          {F(stop.at.x_m), F(stop.at.y_m), GroundHeight(plan, stop.at)});
    }
  }
  for (const building::PlanPlace& place : plan.places) {
    world.places.push_back(
        {.name = place.name, .placement = fittings.StandAt(place.stand)});
  }
  for (const building::PlanPoint& corner : plan.tour) {
    world.tour.push_back(
        {F(corner.x_m), F(corner.y_m), GroundHeight(plan, corner)});
  }
  return world;
}

}  // namespace treeline::worlds

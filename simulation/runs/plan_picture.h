// A world from above, with the way that a robot took.
#ifndef SIMULATION_RUNS_PLAN_PICTURE_H_
#define SIMULATION_RUNS_PLAN_PICTURE_H_

#include <optional>
#include <vector>

#include "common/geometry/rigid2.h"
#include "common/image/image.h"
#include "simulation/runs/simulation_run.h"
#include "simulation/simulator/terrain.h"
#include "simulation/worlds/world.h"

namespace treeline::runs {

// What else a plan shows, in the world's frame.
struct PlanMarks {
  // Where it was to go: a green arrow.
  std::optional<geometry::Rigid2> goal = std::nullopt;
  // What the robot had planned: a thin magenta line.
  std::vector<geometry::Vec3> path = {};
  // The robot's estimate of where it is: a red arrow; the truth: a blue one.
  std::optional<geometry::Rigid2> estimate = std::nullopt;
  std::optional<geometry::Rigid2> truth = std::nullopt;
  // What moved about: a teal dot where it is, behind it the way that it came.
  std::vector<std::vector<geometry::Vec2>> movers = {};
  // Nothing but what is so near, along x and y, to the track and the goal.
  std::optional<double> within_m = std::nullopt;
};

// The ways of what moves in `world` in the `last_s` seconds before a time, as
// PlanMarks has them.
std::vector<std::vector<geometry::Vec2>> WaysOfMovers(
    const worlds::World& world, double time_s, double last_s);

// North (+y) is up. Ground is grey, lighter where it is higher; ramps are
// ochre, stairs brown, furniture dark, walls black, glass blue. The tour is a
// thin grey line, the track blue from a green start; collisions are red where
// the robot caused them and orange where not, falls are purple. Of floors over
// one another the highest shows.
image::ColorImage DrawPlan(const worlds::World& world,
                           const simulator::Terrain& terrain,
                           const SimulationResult& result,
                           const PlanMarks& marks = {});

}  // namespace treeline::runs

#endif  // SIMULATION_RUNS_PLAN_PICTURE_H_

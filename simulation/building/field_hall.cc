#include "simulation/building/field_hall.h"

#include <cmath>

namespace treeline::building {

BuildingPlan PlanOf(const FieldHall& hall, uint64_t seed) {
  BuildingPlan plan;
  plan.size_m = {hall.width_m, hall.depth_m, 3};
  plan.seed = seed;
  PlanRoom room;
  room.name = "hall";
  room.area = {0, 0, hall.width_m, hall.depth_m};
  room.floor = "concrete";
  room.walls.fill("white");
  room.lamps = {hall.lamps[0], hall.lamps[1]};
  plan.rooms.push_back(room);
  const double x_m = hall.width_m / 2;
  const double y_m = hall.start_y_m;
  plan.places = {
      {.name = "start", .stand = {.at = {x_m, y_m, {}}, .facing_deg = 90}},
      {.name = "goal",
       .stand = {.at = {x_m, y_m + hall.goal_ahead_m, {}}, .facing_deg = 90}}};
  // Around the start.
  plan.tour = {{x_m, y_m, {}}, {x_m + 1, y_m, {}}, {x_m, y_m + 1, {}}};
  return plan;
}

double ToMillimetres(double length_m) {
  return std::round(length_m * 1000) / 1000;
}

}  // namespace treeline::building

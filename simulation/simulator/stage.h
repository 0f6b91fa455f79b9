// What moves in a simulated world: bodies by their script or by order, and
// obstacles that somebody put there.
#ifndef SIMULATION_SIMULATOR_STAGE_H_
#define SIMULATION_SIMULATOR_STAGE_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "simulation/simulator/oriented_box.h"
#include "simulation/worlds/world.h"

namespace treeline::simulator {

// A body that is on the stage.
struct Actor {
  // The body's name, or what the obstacle was called.
  std::string name;
  worlds::BodyInstance instance;
};

// Not thread-safe.
class Stage {
 public:
  // The world must outlive it.
  explicit Stage(const worlds::World& world);

  // Who is where at a time: first the world's bodies, then obstacles in the
  // order in which they came.
  std::vector<Actor> ActorsAt(double time_s) const;
  std::vector<worlds::BodyInstance> InstancesAt(double time_s) const;

  // Where a body's surfaces are.
  std::vector<QuadCorners> QuadsOf(const worlds::BodyInstance& instance) const;
  // The radius and height that a body fills about its origin.
  double RadiusOf_m(const worlds::BodyInstance& instance) const;
  double HeightOf_m(const worlds::BodyInstance& instance) const;

  // Puts a body there that the world only keeps in store (World::bodies
  // without motion) or a second one of any kind, its measures times `scale`.
  // NOT_FOUND: no such body, and which there are; ALREADY_EXISTS: something is
  // called `name` already.
  absl::Status AddObstacle(absl::string_view name, absl::string_view body,
                           const worlds::Placement& world_from_body,
                           worlds::Float3 scale = {1, 1, 1});
  absl::Status RemoveObstacle(absl::string_view name);

  // Takes an obstacle or one of the world's bodies to a place, where it stays;
  // a body's script ends with that. NOT_FOUND for other names.
  absl::Status Move(absl::string_view name,
                    const worlds::Placement& world_from_body);
  // Turns a body about its origin, where its hinge is, to this angle from
  // where its script has it at time 0. NOT_FOUND as above.
  absl::Status TurnDoor(absl::string_view name, double angle_rad);
  // A body follows its script again.
  absl::Status Release(absl::string_view name);

 private:
  absl::Status Unknown(absl::string_view name) const;
  std::optional<size_t> BodyCalled(absl::string_view name) const;
  std::optional<size_t> ObstacleCalled(absl::string_view name) const;

  const worlds::World* world_;
  // Bodies that were taken somewhere, by index.
  std::map<size_t, worlds::Placement> moved_;
  std::vector<Actor> obstacles_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_STAGE_H_

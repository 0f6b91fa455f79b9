#include "simulation/simulator/stage.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace treeline::simulator {

Stage::Stage(const worlds::World& world) : world_(&world) {}

std::vector<Actor> Stage::ActorsAt(double time_s) const {
  std::vector<Actor> actors;
  for (size_t i = 0; i < world_->bodies.size(); ++i) {
    const worlds::Body& body = world_->bodies[i];
    const auto moved = moved_.find(i);
    if (moved == moved_.end() && !body.motion.has_value()) continue;
    actors.push_back(
        {.name = body.name,
         .instance = {.body = static_cast<int>(i),
                      .world_from_body = moved != moved_.end()
                                             ? moved->second
                                             : body.motion->At(time_s)}});
  }
  actors.insert(actors.end(), obstacles_.begin(), obstacles_.end());
  return actors;
}

std::vector<worlds::BodyInstance> Stage::InstancesAt(double time_s) const {
  std::vector<worlds::BodyInstance> instances;
  for (const Actor& actor : ActorsAt(time_s)) {
    instances.push_back(actor.instance);
  }
  return instances;
}

std::vector<QuadCorners> Stage::QuadsOf(
    const worlds::BodyInstance& instance) const {
  const worlds::Body& body = world_->bodies[static_cast<size_t>(instance.body)];
  std::vector<QuadCorners> quads;
  quads.reserve(body.surfaces.size());
  for (const worlds::Surface& surface : body.surfaces) {
    QuadCorners corners;
    for (size_t i = 0; i < 4; ++i) {
      const worlds::Float3 at =
          instance.world_from_body.Point(instance.scale * surface.corners[i]);
      corners[i] = {at.x, at.y, at.z};
    }
    quads.push_back(corners);
  }
  return quads;
}

double Stage::RadiusOf_m(const worlds::BodyInstance& instance) const {
  const worlds::Body& body = world_->bodies[static_cast<size_t>(instance.body)];
  return body.radius_m * std::max(instance.scale.x, instance.scale.y);
}

double Stage::HeightOf_m(const worlds::BodyInstance& instance) const {
  const worlds::Body& body = world_->bodies[static_cast<size_t>(instance.body)];
  return body.height_m * instance.scale.z;
}

std::optional<size_t> Stage::BodyCalled(absl::string_view name) const {
  for (size_t i = 0; i < world_->bodies.size(); ++i) {
    if (world_->bodies[i].name == name) return i;
  }
  return std::nullopt;
}

std::optional<size_t> Stage::ObstacleCalled(absl::string_view name) const {
  for (size_t i = 0; i < obstacles_.size(); ++i) {
    if (obstacles_[i].name == name) return i;
  }
  return std::nullopt;
}

absl::Status Stage::Unknown(absl::string_view name) const {
  std::vector<std::string> known;
  for (const worlds::Body& body : world_->bodies) known.push_back(body.name);
  for (const Actor& obstacle : obstacles_) known.push_back(obstacle.name);
  return absl::NotFoundError(absl::StrCat(
      "the world has no body called '", name, "'; ",
      known.empty() ? "it has none at all"
                    : absl::StrCat("it has ", absl::StrJoin(known, ", "))));
}

absl::Status Stage::AddObstacle(absl::string_view name, absl::string_view body,
                                const worlds::Placement& world_from_body,
                                worlds::Float3 scale) {
  const auto index = BodyCalled(body);
  if (!index.has_value()) return Unknown(body);
  const bool taken = ObstacleCalled(name).has_value() ||
                     (name != body && BodyCalled(name).has_value());
  if (taken) {
    return absl::AlreadyExistsError(
        absl::StrCat("there is a '", name, "' already"));
  }
  obstacles_.push_back({.name = std::string(name),
                        .instance = {.body = static_cast<int>(*index),
                                     .world_from_body = world_from_body,
                                     .scale = scale}});
  return absl::OkStatus();
}

absl::Status Stage::RemoveObstacle(absl::string_view name) {
  const auto index = ObstacleCalled(name);
  if (!index.has_value()) {
    return absl::NotFoundError(
        absl::StrCat("no obstacle called '", name, "' was put here"));
  }
  obstacles_.erase(obstacles_.begin() + static_cast<std::ptrdiff_t>(*index));
  return absl::OkStatus();
}

absl::Status Stage::Move(absl::string_view name,
                         const worlds::Placement& world_from_body) {
  if (const auto obstacle = ObstacleCalled(name); obstacle.has_value()) {
    obstacles_[*obstacle].instance.world_from_body = world_from_body;
    return absl::OkStatus();
  }
  const auto body = BodyCalled(name);
  if (!body.has_value()) return Unknown(name);
  moved_[*body] = world_from_body;
  return absl::OkStatus();
}

absl::Status Stage::TurnDoor(absl::string_view name, double angle_rad) {
  const auto body = BodyCalled(name);
  if (!body.has_value()) return Unknown(name);
  const std::optional<worlds::Motion>& motion = world_->bodies[*body].motion;
  if (!motion.has_value()) {
    return absl::FailedPreconditionError(
        absl::StrCat("'", name, "' has no place of its own to turn at"));
  }
  moved_[*body] = motion->At(0).At({}, static_cast<float>(angle_rad));
  return absl::OkStatus();
}

absl::Status Stage::Release(absl::string_view name) {
  const auto body = BodyCalled(name);
  if (!body.has_value()) return Unknown(name);
  moved_.erase(*body);
  return absl::OkStatus();
}

}  // namespace treeline::simulator

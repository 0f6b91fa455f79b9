#include "common/synthetic/world.h"

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/synthetic/room.h"

namespace treeline {

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
  if (name == "room") {
    return MakeRoom(std::string(name), std::nullopt, options.threads);
  }
  uint64_t seed = 0;
  absl::string_view rest = name;
  if (absl::ConsumePrefix(&rest, "room:") && absl::SimpleAtoi(rest, &seed)) {
    return MakeRoom(std::string(name), seed, options.threads);
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "world '", name, "' is neither 'room' nor 'room:N' with a whole N"));
}

}  // namespace treeline

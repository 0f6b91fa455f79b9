// Many drives with the local controller alone, and what became of them:
//   control_missions WORLD FIRST-SEED LAST-SEED [people] [crates] [error]
//       [trace]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/control/control_run.h"

namespace treeline {
namespace {

struct Flags {
  std::string world;
  uint64_t first = 0;
  uint64_t last = 0;
  bool people = false;
  bool crates = false;
  bool error = false;
  bool trace = false;
};

void PutCrates(const std::vector<core::LevelPose>& path, base::Random& random,
               simulator::Simulator& simulator) {
  for (int i = 0; i < 2 && path.size() > 1; ++i) {
    const size_t leg = random.NextBelow(static_cast<uint32_t>(path.size() - 1));
    const geometry::Vec2 a = path[leg].map_from_base.translation;
    const geometry::Vec2 b = path[leg + 1].map_from_base.translation;
    const geometry::Vec2 at = a + random.NextUniform(0.3, 0.9) * (b - a) +
                              geometry::Vec2{random.NextUniform(-0.3, 0.3),
                                             random.NextUniform(-0.3, 0.3)};
    // Neither on the robot nor on its goal.
    if (Norm(at - path.front().map_from_base.translation) < 1.1 ||
        Norm(at - path.back().map_from_base.translation) < 1.1) {
      continue;
    }
    (void)simulator.AddObstacle("new-" + std::to_string(i), "crate",
                                {.position = at,
                                 .yaw_rad = random.NextUniform(-3, 3),
                                 .height_m = path[leg].place.height_m});
  }
}

bool RunSeed(const ControlWorld& world, const Flags& flags, uint64_t seed,
             double& seconds) {
  base::Random random(seed, 1);
  core::LevelPose start;
  core::LevelPose goal;
  std::vector<core::LevelPose> path;
  simulator::SimulatorOptions options;
  options.seed = seed;
  std::unique_ptr<simulator::Simulator> simulator;
  while (path.size() < 2 || simulator == nullptr) {
    start = world.AnyPlace(random, 0.5);
    goal = world.AnyPlace(random, 0.45);
    if (Norm(start.map_from_base.translation - goal.map_from_base.translation) <
        2) {
      continue;
    }
    path = world.FindPath(start, goal, 0.40);
    options.start = {.position = start.map_from_base.translation,
                     .yaw_rad = start.map_from_base.yaw_rad,
                     .height_m = start.place.height_m};
    auto made = simulator::Simulator::Create(world.world(), options);
    simulator = made.ok() ? *std::move(made) : nullptr;
  }
  if (flags.crates) PutCrates(path, random, *simulator);
  auto controller =
      *control::LocalController::Make(world.map(), core::RobotModel(),
                                      {.front = simulator->laser().Info()}, {});
  const ControlRunResult result =
      RunControl(world, *simulator, *controller, path,
                 {.max_s = 100,
                  .error_m = flags.error ? 0.03 : 0,
                  .error_rad = flags.error ? 0.01 : 0,
                  .seed = seed,
                  .traces = flags.trace,
                  .before_step = {}});
  const bool is_good =
      result.arrived && result.collisions_caused == 0 && result.falls == 0;
  std::printf(
      "%s seed %llu (%.1f %.1f -> %.1f %.1f): %s %.1f s for %.1f of "
      "%.1f m, off %.3f m %.3f rad, caused %d suffered %d falls %d "
      "blocked %d waited %.1f guarded %.1f swings %d %d step %.2f ms "
      "(%.2f) %s\n",
      is_good ? "ok  " : "BAD ", static_cast<unsigned long long>(seed),
      start.map_from_base.translation.x, start.map_from_base.translation.y,
      goal.map_from_base.translation.x, goal.map_from_base.translation.y,
      result.arrived ? "arrived" : "NOT THERE", result.seconds, result.driven_m,
      result.path_m, result.error_m, result.error_rad, result.collisions_caused,
      result.collisions_suffered, result.falls, result.times_blocked,
      result.waited_s, result.guarded_s, result.speed_swings,
      result.turn_swings, result.mean_step_ms, result.longest_step_ms,
      result.why.c_str());
  std::fflush(stdout);
  seconds += result.seconds;
  return is_good;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  using treeline::ControlWorld;
  if (argc < 4) {
    std::fprintf(stderr,
                 "control_missions WORLD FIRST LAST [people] [crates] "
                 "[error] [trace]\n");
    return 2;
  }
  treeline::Flags flags;
  flags.world = argv[1];
  flags.first = std::strtoull(argv[2], nullptr, 10);
  flags.last = std::strtoull(argv[3], nullptr, 10);
  for (int i = 4; i < argc; ++i) {
    const std::string flag = argv[i];
    flags.people |= flag == "people";
    flags.crates |= flag == "crates";
    flags.error |= flag == "error";
    flags.trace |= flag == "trace";
  }
  const ControlWorld world(flags.world, flags.people);
  int good = 0;
  int all = 0;
  double seconds = 0;
  for (uint64_t seed = flags.first; seed <= flags.last; ++seed) {
    good += treeline::RunSeed(world, flags, seed, seconds) ? 1 : 0;
    ++all;
  }
  std::printf("%s: %d of %d good, %.1f s on average\n", flags.world.c_str(),
              good, all, seconds / all);
  return good == all ? 0 : 1;
}

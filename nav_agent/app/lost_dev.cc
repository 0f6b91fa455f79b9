// Dev: lost_dev WORLD FIRST LAST METHOD SERVER(true|dead|alias|none)
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include "nav_agent/app/testing_lost_robot.h"
using namespace treeline;
int main(int argc, char** argv) {
  const LostPlace& place = LostPlaceOf(argv[1]);
  int found = 0, wrong = 0, help = 0, self = 0, late = 0;
  for (uint64_t seed = atoi(argv[2]); seed <= (uint64_t)atoi(argv[3]); ++seed) {
    LostAndFoundOptions options;
    if (!strcmp(argv[4], "amcl")) options.method = RecoveryMethod::kAmclOnly;
    if (!strcmp(argv[4], "injection")) options.method = RecoveryMethod::kInjectionOnly;
    LostRobot robot(place, seed, true, options);
    const std::string server = argc > 5 ? argv[5] : "true";
    if (server == "dead") robot.server().answers = [](const RgbdFrame&) -> MadeUpServer::Answer { return absl::UnavailableError("dead"); };
    Random random(seed, 9);
    if (server == "wrong") robot.server().answers = [&](const RgbdFrame& f) -> MadeUpServer::Answer {
      // Confident, upright, on free ground, and wrong.
      const NavigationMap& map = *place.map;
      while (true) {
        const int level = random.NextBelow(map.levels());
        const CellIndex cell{(int)random.NextBelow(map.grid(0).width), (int)random.NextBelow(map.grid(0).height)};
        if (map.ClearanceAt_m(level, cell) < 0.4) continue;
        const Vec2 at = map.grid(level).CenterInMap(cell);
        const auto g = map.GroundOf(at, level);
        if (!g || map.SlopeAt_rad(level, at) > 0.01) continue;
        return robot.AnswerFor({Rotation3::FromAxisAngle({0,0,random.NextUniform(-3.1,3.1)}), {at.x, at.y, g->height_m}}, f, 0.99);
      }
    };
    robot.TellTruth();
    for (int i = 0; i < 100; ++i) robot.Step();
    if (!robot.CarryAway(seed)) { std::printf("seed %d no room\n", (int)seed); continue; }
    // declared?
    const double t0 = Seconds(robot.simulator().now());
    double declared = -1;
    RecoveryState state = RecoveryState::kIdle;
    for (int i = 0; i < 40 * 300; ++i) {
      state = robot.Step().state;
      if (declared < 0 && robot.lost().IsActive()) declared = Seconds(robot.simulator().now()) - t0;
      if (state == RecoveryState::kFound || state == RecoveryState::kNeedHelp) break;
      if (declared < 0 && i > 40 * 15) break;
    }
    const double t1 = Seconds(robot.simulator().now()) - t0;
    const char* what = "";
    if (declared < 0) { what = robot.IsRight() ? "self" : "LATE"; (robot.IsRight() ? self : late)++; }
    else if (state == RecoveryState::kFound) { what = robot.IsRight() ? "found" : "WRONG"; (robot.IsRight() ? found : wrong)++; }
    else { what = "help"; ++help; }
    std::printf("seed %d %s declared %.1f done %.1f asked %d err %.2f %.2f\n", (int)seed, what, declared, t1, robot.server().asked, robot.Error_m(), robot.Error_rad());
    if (argc > 6) for (auto& n : robot.notes) std::printf("   %s: %s\n", n.kind.c_str(), n.text.c_str());
    std::fflush(stdout);
  }
  std::printf("found %d wrong %d help %d self %d late %d\n", found, wrong, help, self, late);
}

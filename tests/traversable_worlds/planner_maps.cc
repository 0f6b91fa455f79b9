#include "tests/traversable_worlds/planner_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <string_view>
#include <utility>

#include "common/base/random.h"
#include "nav_agent/app/plan/plan_run.h"
#include "nav_agent/planning/plan_frame.h"

namespace treeline {
namespace {

constexpr double kCell_m = 0.05;
constexpr std::string_view kMovingAiEnding = ".map";
constexpr std::string_view kMapServerEnding = ".yaml";
constexpr int kMaxSide = 8192;

// A square of cells; true: blocked.
struct Raster {
  int size = 0;
  std::vector<bool> cells;

  bool Contains(int x, int y) const {
    return x >= 0 && y >= 0 && x < size && y < size;
  }
  void Set(int x, int y, bool is_blocked) {
    if (!Contains(x, y)) return;
    cells[static_cast<size_t>(y) * static_cast<size_t>(size) +
          static_cast<size_t>(x)] = is_blocked;
  }
  bool At(int x, int y) const {
    return !Contains(x, y) ||
           cells[static_cast<size_t>(y) * static_cast<size_t>(size) +
                 static_cast<size_t>(x)];
  }
  void Fill(int x0, int x1, int y0, int y1, bool is_blocked) {
    for (int y = std::max(0, y0); y < std::min(size, y1); ++y) {
      for (int x = std::max(0, x0); x < std::min(size, x1); ++x) {
        Set(x, y, is_blocked);
      }
    }
  }
  // A rectangle turned by an angle about its middle.
  void FillTurned(geometry::Vec2 middle, geometry::Vec2 half, double yaw_rad,
                  bool is_blocked) {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    const int reach = static_cast<int>(geometry::Norm(half)) + 1;
    for (int y = static_cast<int>(middle.y) - reach;
         y <= static_cast<int>(middle.y) + reach; ++y) {
      for (int x = static_cast<int>(middle.x) - reach;
           x <= static_cast<int>(middle.x) + reach; ++x) {
        const double dx = x + 0.5 - middle.x;
        const double dy = y + 0.5 - middle.y;
        if (std::abs(c * dx + s * dy) < half.x &&
            std::abs(-s * dx + c * dy) < half.y) {
          Set(x, y, is_blocked);
        }
      }
    }
  }
};

Raster MakeCity(int size, base::Random& random) {
  Raster raster{size, std::vector<bool>(static_cast<size_t>(size) *
                                        static_cast<size_t>(size))};
  const double yaw_rad = random.NextUniform(0, std::numbers::pi / 2);
  const double pitch = random.NextUniform(60, 100);
  const geometry::Vec2 along = {std::cos(yaw_rad), std::sin(yaw_rad)};
  const geometry::Vec2 across = {-along.y, along.x};
  const int reach = static_cast<int>(size / pitch) + 2;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const geometry::Vec2 middle =
          geometry::Vec2{size / 2.0, size / 2.0} + (i * pitch) * along +
          (j * pitch) * across +
          geometry::Vec2{random.NextUniform(-4, 4), random.NextUniform(-4, 4)};
      const geometry::Vec2 half = {pitch / 2 - random.NextUniform(7, 16),
                                   pitch / 2 - random.NextUniform(7, 16)};
      const double own_rad = yaw_rad + random.NextUniform(-0.08, 0.08);
      if (random.NextUnit() < 0.1) continue;  // a square
      raster.FillTurned(middle, half, own_rad, true);
      if (random.NextUnit() < 0.4) {  // a yard with a gate
        raster.FillTurned(middle, 0.6 * half, own_rad, false);
        raster.FillTurned(middle + 0.6 * half.x * along,
                          {0.5 * half.x, random.NextUniform(8, 14)}, own_rad,
                          false);
      }
    }
  }
  return raster;
}

Raster MakeMaze(int size, base::Random& random) {
  Raster raster{
      size, std::vector<bool>(
                static_cast<size_t>(size) * static_cast<size_t>(size), true)};
  constexpr int kWay = 24;
  constexpr int kPitch = kWay + 4;
  const int count = (size - 4) / kPitch;
  const auto index = [count](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(count) +
           static_cast<size_t>(x);
  };
  const auto carve = [&raster](int x0, int y0, int x1, int y1) {
    raster.Fill(4 + kPitch * std::min(x0, x1),
                4 + kPitch * std::max(x0, x1) + kWay,
                4 + kPitch * std::min(y0, y1),
                4 + kPitch * std::max(y0, y1) + kWay, false);
  };
  std::vector<bool> is_reached(index(0, count));
  std::vector<std::pair<int, int>> stack = {{0, 0}};
  is_reached[0] = true;
  carve(0, 0, 0, 0);
  while (!stack.empty()) {
    const auto [x, y] = stack.back();
    std::vector<std::pair<int, int>> next;
    for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0},
                                 std::pair{0, 1}, std::pair{0, -1}}) {
      if (x + dx < 0 || y + dy < 0 || x + dx >= count || y + dy >= count ||
          is_reached[index(x + dx, y + dy)]) {
        continue;
      }
      next.emplace_back(x + dx, y + dy);
    }
    if (next.empty()) {
      stack.pop_back();
      continue;
    }
    const auto to = next[random.NextBelow(static_cast<uint32_t>(next.size()))];
    is_reached[index(to.first, to.second)] = true;
    carve(x, y, to.first, to.second);
    stack.push_back(to);
  }
  // A few more ways, so that there are several.
  for (int i = 0; i < count * count / 12; ++i) {
    const int x = static_cast<int>(
        random.NextBelow(static_cast<uint32_t>(std::max(1, count - 1))));
    const int y = static_cast<int>(
        random.NextBelow(static_cast<uint32_t>(std::max(1, count - 1))));
    if (random.NextUnit() < 0.5) {
      carve(x, y, x + 1, y);
    } else {
      carve(x, y, x, y + 1);
    }
  }
  return raster;
}

Raster MakeRooms(int size, base::Random& random) {
  Raster raster{size, std::vector<bool>(static_cast<size_t>(size) *
                                        static_cast<size_t>(size))};
  const int pitch = 70 + static_cast<int>(random.NextBelow(30));
  for (int at = pitch; at < size; at += pitch) {
    raster.Fill(at, at + 3, 0, size, true);
    raster.Fill(0, size, at, at + 3, true);
  }
  for (int y = 0; y < size; y += pitch) {
    for (int x = 0; x < size; x += pitch) {
      const auto door = [&] {
        return std::pair{5 + static_cast<int>(random.NextBelow(
                                 static_cast<uint32_t>(pitch - 32))),
                         16 + static_cast<int>(random.NextBelow(8))};
      };
      if (random.NextUnit() < 0.75) {
        const auto [at, width] = door();
        raster.Fill(x + pitch, x + pitch + 3, y + at, y + at + width, false);
      }
      if (random.NextUnit() < 0.75) {
        const auto [at, width] = door();
        raster.Fill(x + at, x + at + width, y + pitch, y + pitch + 3, false);
      }
      for (int i = 0; i < 2; ++i) {  // furniture
        raster.FillTurned({x + random.NextUniform(20, pitch - 20),
                           y + random.NextUniform(20, pitch - 20)},
                          {random.NextUniform(3, 12), random.NextUniform(3, 8)},
                          random.NextUniform(0, std::numbers::pi), true);
      }
    }
  }
  return raster;
}

Raster MakeCaves(int size, base::Random& random) {
  constexpr int kScale = 8;
  const int coarse = size / kScale + 1;
  Raster small{coarse, std::vector<bool>(static_cast<size_t>(coarse) *
                                         static_cast<size_t>(coarse))};
  for (int y = 0; y < coarse; ++y) {
    for (int x = 0; x < coarse; ++x) small.Set(x, y, random.NextUnit() < 0.42);
  }
  const auto count = [](const Raster& raster, int x, int y, int reach) {
    int blocked = 0;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        blocked += raster.At(x + dx, y + dy) ? 1 : 0;
      }
    }
    return blocked;
  };
  const auto smooth = [&count](Raster& raster, int reach, int limit) {
    const Raster before = raster;
    for (int y = 0; y < raster.size; ++y) {
      for (int x = 0; x < raster.size; ++x) {
        raster.Set(x, y, count(before, x, y, reach) >= limit);
      }
    }
  };
  for (int i = 0; i < 5; ++i) smooth(small, 1, 5);
  Raster raster{size, std::vector<bool>(static_cast<size_t>(size) *
                                        static_cast<size_t>(size))};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      raster.Set(x, y, small.At(x / kScale, y / kScale));
    }
  }
  for (int i = 0; i < 2; ++i) smooth(raster, 3, 25);
  return raster;
}

Raster MakeCylinders(int size, base::Random& random) {
  Raster raster{size, std::vector<bool>(static_cast<size_t>(size) *
                                        static_cast<size_t>(size))};
  const double metres = size * kCell_m;
  const int posts = static_cast<int>(0.55 * metres * metres);
  for (int i = 0; i < posts; ++i) {
    const double middle_x = random.NextUniform(0, size);
    const double middle_y = random.NextUniform(0, size);
    for (int y = static_cast<int>(middle_y) - 2; y <= middle_y + 2; ++y) {
      for (int x = static_cast<int>(middle_x) - 2; x <= middle_x + 2; ++x) {
        if (std::hypot(x + 0.5 - middle_x, y + 0.5 - middle_y) < 1.5) {
          raster.Set(x, y, true);
        }
      }
    }
  }
  return raster;
}

std::shared_ptr<const traversability::NavigationMap> FlatMap(
    int width, int height, const std::vector<bool>& is_blocked) {
  traversability::TraversableLevel level;
  level.grid = core::OccupancyGrid::Filled(width, height, kCell_m, {},
                                           core::Occupancy::kFree);
  for (size_t i = 0; i < is_blocked.size(); ++i) {
    if (is_blocked[i]) level.grid.cells[i] = core::Occupancy::kOccupied;
  }
  level.height_m.assign(is_blocked.size(), 0);
  level.slope_rad.assign(is_blocked.size(), 0);
  level.clearance_m.assign(is_blocked.size(), 2.5F);
  traversability::TraversableMap levels;
  levels.levels.push_back(std::move(level));
  auto map = traversability::NavigationMap::Make(std::move(levels));
  if (!map.ok()) std::abort();
  return std::make_shared<const traversability::NavigationMap>(*std::move(map));
}

// Null if it is none. Rows come from the top.
std::shared_ptr<const traversability::NavigationMap> ReadMovingAi(
    std::istream& file) {
  std::string word;
  int width = 0;
  int height = 0;
  while (file >> word && word != "map") {
    if (word == "height") file >> height;
    if (word == "width") file >> width;
  }
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    return nullptr;
  }
  std::vector<bool> is_blocked(static_cast<size_t>(width) *
                               static_cast<size_t>(height));
  for (int y = height - 1; y >= 0; --y) {
    if (!(file >> word) || word.size() != static_cast<size_t>(width)) {
      return nullptr;
    }
    for (size_t x = 0; x < word.size(); ++x) {
      is_blocked[static_cast<size_t>(y) * word.size() + x] =
          std::string_view(".GS").find(word[x]) == std::string_view::npos;
    }
  }
  return FlatMap(width, height, is_blocked);
}

}  // namespace

const std::vector<std::string>& PlannerMapKinds() {
  static const std::vector<std::string>* const kinds =
      new std::vector<std::string>{"city", "maze", "rooms", "caves",
                                   "cylinders"};
  return *kinds;
}

std::shared_ptr<const traversability::NavigationMap> MakePlannerMap(
    const std::string& kind, int size, uint64_t seed) {
  base::Random random(seed, static_cast<uint64_t>(size));
  Raster raster = kind == "city"    ? MakeCity(size, random)
                  : kind == "maze"  ? MakeMaze(size, random)
                  : kind == "rooms" ? MakeRooms(size, random)
                  : kind == "caves" ? MakeCaves(size, random)
                                    : MakeCylinders(size, random);
  raster.Fill(0, size, 0, 2, true);
  raster.Fill(0, size, size - 2, size, true);
  raster.Fill(0, 2, 0, size, true);
  raster.Fill(size - 2, size, 0, size, true);
  return FlatMap(size, size, raster.cells);
}

bool IsMapFile(const std::string& kind) {
  return kind.ends_with(kMovingAiEnding) || kind.ends_with(kMapServerEnding);
}

std::shared_ptr<const traversability::NavigationMap> ReadPlannerMap(
    const std::string& path) {
  if (path.ends_with(kMovingAiEnding)) {
    std::ifstream file(path);
    auto map = ReadMovingAi(file);
    if (map == nullptr) {
      std::fprintf(stderr, "%s is no map of moving-AI\n", path.c_str());
      std::exit(2);
    }
    return map;
  }
  auto map = plan_app::LoadNavigationMap(path, false);
  if (!map.ok()) {
    std::fprintf(stderr, "%s\n", map.status().ToString().c_str());
    std::exit(2);
  }
  return *std::move(map);
}

std::vector<planning::PlanRequest> RequestsOn(
    const std::shared_ptr<const traversability::NavigationMap>& map, int count,
    uint64_t seed) {
  const planning::PlanGround ground(map, core::RobotModel(),
                                    planning::GlobalPlannerOptions().margin_m);
  const planning::ConfigurationSpace space(ground.index, ground.footprint, {});
  const planning::Regions& regions = *ground.regions;
  int largest = 0;
  for (int area = 1; area < regions.areas(); ++area) {
    if (regions.CellsOf(area) > regions.CellsOf(largest)) largest = area;
  }
  uint64_t draw = 0;
  const auto pose = [&] {
    for (;;) {
      base::Random random(seed, draw++);
      const auto level = static_cast<int>(
          random.NextBelow(static_cast<uint32_t>(map->levels())));
      const geometry::Vec2 at = ground.index->CenterOf(
          {static_cast<int>(
               random.NextBelow(static_cast<uint32_t>(ground.index->width()))),
           static_cast<int>(random.NextBelow(
               static_cast<uint32_t>(ground.index->height())))});
      const planning::Stand stand = {
          .spot = {at, level}, .yaw_rad = random.NextUniform(-3.14, 3.14)};
      if (regions.AreaOf(*ground.index, stand.spot) != largest) continue;
      if (!space.Fits(stand.spot, stand.yaw_rad)) continue;
      return core::LevelPose{
          .map_from_base = map->grid(0).map_from_grid *
                           geometry::Rigid2{stand.spot.at, stand.yaw_rad},
          .place = {.level = stand.spot.level, .height_m = 0}};
    }
  };
  std::vector<planning::PlanRequest> requests;
  for (int i = 0; i < count; ++i) {
    requests.push_back({.start = pose(),
                        .goal = pose(),
                        .blockages = {},
                        .seed = seed + static_cast<uint64_t>(i)});
  }
  return requests;
}

double Share(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[std::min(
      values.size() - 1,
      static_cast<size_t>(share * static_cast<double>(values.size())))];
}

}  // namespace treeline

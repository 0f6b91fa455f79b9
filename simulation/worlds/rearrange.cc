#include "simulation/worlds/rearrange.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/random.h"
#include "simulation/worlds/ground_columns.h"

namespace treeline::worlds {
namespace {

constexpr uint64_t kStream = 0x2ea77;
constexpr double kMissing = 0.3;
constexpr double kFarthest_m = 1.0;
// Nobody would see less.
constexpr double kNearest_m = 0.15;
constexpr double kMaxTurn_rad = std::numbers::pi / 3;
constexpr int kTries = 60;
// From a piece to what stands beside it.
constexpr float kGap_m = 0.03f;
// Rugs and thresholds are ground.
constexpr float kFlat_m = 0.03f;
constexpr float kLevel_m = 0.02f;
// A robot's radius and what it keeps away; a person's is less.
constexpr float kWayClear_m = 0.45f;
constexpr float kPlaceClear_m = 0.6f;
// What is lower is below a hand-held camera.
constexpr float kCameraLow_m = 1.0f;
constexpr float kWalkMargin_m = 0.4f;

struct Box {
  Float3 low{1e9f, 1e9f, 1e9f};
  Float3 high{-1e9f, -1e9f, -1e9f};

  void Add(Float3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y),
            std::max(high.z, p.z)};
  }
  Float3 Middle() const { return 0.5f * (low + high); }
  // How far apart they are, seen from above; 0: they overlap.
  float Distance_m(const Box& other) const {
    const float x =
        std::max({low.x - other.high.x, other.low.x - high.x, 0.0f});
    const float y =
        std::max({low.y - other.high.y, other.low.y - high.y, 0.0f});
    return std::hypot(x, y);
  }
};

Box BoxOf(const Surface& surface) {
  Box box;
  for (const Float3& corner : surface.corners) box.Add(corner);
  return box;
}

// A turn about an upright line, and a shift.
struct Move {
  Float3 middle;
  Placement to_middle;

  Float3 Point(Float3 p) const { return to_middle.Point(p - middle); }
};

void MovePiece(const Move& move, std::span<Surface> surfaces,
               std::span<AreaLight> lights) {
  for (Surface& surface : surfaces) {
    for (Float3& corner : surface.corners) corner = move.Point(corner);
  }
  for (AreaLight& light : lights) {
    light.corner = move.Point(light.corner);
    light.edge_u = move.to_middle.Direction(light.edge_u);
    light.edge_v = move.to_middle.Direction(light.edge_v);
  }
}

// Whether a box stands off a closed way.
bool IsOff(const std::vector<Float3>& way, const Box& box, float clear_m) {
  constexpr float kStep_m = 0.1f;
  for (size_t i = 0; i < way.size(); ++i) {
    const Float3 from = way[i];
    const Float3 to = way[(i + 1) % way.size()];
    const int steps =
        1 + static_cast<int>(std::ceil(Norm(to - from) / kStep_m));
    for (int k = 0; k <= steps; ++k) {
      Box here;
      here.Add(
          Mix(from, to, static_cast<float>(k) / static_cast<float>(steps)));
      if (std::abs(here.low.z - box.low.z) < 1 &&
          here.Distance_m(box) < clear_m) {
        return false;
      }
    }
  }
  return true;
}

class Rearranger {
 public:
  Rearranger(const Rearrangement& rearranged, World& world)
      : rearranged_(rearranged), world_(world) {
    boxes_.reserve(world.surfaces.size());
    for (const Surface& surface : world.surfaces) {
      boxes_.push_back(BoxOf(surface));
    }
    is_gone_.assign(world.surfaces.size(), false);
    is_light_gone_.assign(world.lights.size(), false);
  }

  void Run() {
    for (size_t i = 0; i < world_.pieces.size(); ++i) {
      base::Random random(rearranged_.seed, kStream + i);
      if (random.NextUnit() >= rearranged_.share) continue;
      const Piece& piece = world_.pieces[i];
      if (random.NextUnit() < kMissing || !MoveAside(piece, random)) {
        Remove(piece);
      }
    }
    Erase(is_gone_, world_.surfaces);
    Erase(is_light_gone_, world_.lights);
    CountAnew();
  }

 private:
  template <typename Thing>
  static void Erase(const std::vector<bool>& is_gone,
                    std::vector<Thing>& things) {
    size_t kept = 0;
    for (size_t i = 0; i < things.size(); ++i) {
      if (!is_gone[i]) things[kept++] = things[i];
    }
    things.erase(things.begin() + static_cast<std::ptrdiff_t>(kept),
                 things.end());
  }

  // Where pieces are in what is left.
  void CountAnew() {
    size_t surfaces_gone = 0;
    size_t lights_gone = 0;
    for (Piece& piece : world_.pieces) {
      const bool is_gone = is_gone_[piece.first_surface];
      piece.first_surface -= surfaces_gone;
      piece.first_light -= lights_gone;
      if (!is_gone) continue;
      surfaces_gone += std::exchange(piece.surface_count, 0);
      lights_gone += std::exchange(piece.light_count, 0);
    }
  }

  void Remove(const Piece& piece) {
    std::fill_n(
        is_gone_.begin() + static_cast<std::ptrdiff_t>(piece.first_surface),
        piece.surface_count, true);
    std::fill_n(
        is_light_gone_.begin() + static_cast<std::ptrdiff_t>(piece.first_light),
        piece.light_count, true);
  }

  std::span<Surface> SurfacesOf(const Piece& piece) {
    return std::span(world_.surfaces)
        .subspan(piece.first_surface, piece.surface_count);
  }

  // False: there is no room.
  bool MoveAside(const Piece& piece, base::Random& random) {
    Box box;
    for (const Surface& surface : SurfacesOf(piece)) {
      for (const Float3& corner : surface.corners) box.Add(corner);
    }
    const std::vector<size_t> near = Around(piece, box);
    const Float3 middle = box.Middle();
    for (int i = 0; i < kTries; ++i) {
      const double way = random.NextUniform(0, 2 * std::numbers::pi);
      // Evenly over the ring.
      const double away_m = std::sqrt(random.NextUniform(
          kNearest_m * kNearest_m, kFarthest_m * kFarthest_m));
      const Move move = {
          .middle = middle,
          .to_middle = {
              middle + Float3{static_cast<float>(away_m * std::cos(way)),
                              static_cast<float>(away_m * std::sin(way)), 0},
              static_cast<float>(
                  random.NextUniform(-kMaxTurn_rad, kMaxTurn_rad))}};
      Box there;
      for (const Surface& surface : SurfacesOf(piece)) {
        for (const Float3& corner : surface.corners) {
          there.Add(move.Point(corner));
        }
      }
      if (!HasRoom(there, near) || !StandsLevel(there, near) || IsInWay(there))
        continue;
      MovePiece(move, SurfacesOf(piece),
                std::span(world_.lights)
                    .subspan(piece.first_light, piece.light_count));
      for (size_t k = 0; k < piece.surface_count; ++k) {
        const size_t surface = piece.first_surface + k;
        boxes_[surface] = BoxOf(world_.surfaces[surface]);
      }
      return true;
    }
    return false;
  }

  // Other surfaces that it can come to.
  std::vector<size_t> Around(const Piece& piece, const Box& box) const {
    // Turned, it reaches out further than before.
    const float reach_m =
        static_cast<float>(kFarthest_m) + kGap_m +
        0.5f * std::hypot(box.high.x - box.low.x, box.high.y - box.low.y);
    std::vector<size_t> near;
    for (size_t i = 0; i < boxes_.size(); ++i) {
      const bool is_own = i >= piece.first_surface &&
                          i < piece.first_surface + piece.surface_count;
      if (!is_own && !is_gone_[i] && boxes_[i].low.z < box.high.z &&
          boxes_[i].high.z > box.low.z - kLevel_m &&
          boxes_[i].Distance_m(box) < reach_m) {
        near.push_back(i);
      }
    }
    return near;
  }

  bool HasRoom(const Box& box, const std::vector<size_t>& near) const {
    return std::ranges::none_of(near, [&](size_t i) {
      return boxes_[i].high.z > box.low.z + kFlat_m &&
             boxes_[i].Distance_m(box) < kGap_m;
    });
  }

  // Whether there is ground at its height below its corners and its middle.
  bool StandsLevel(const Box& box, const std::vector<size_t>& near) const {
    const Float3 middle = box.Middle();
    const std::array<std::pair<float, float>, 5> feet = {
        {{box.low.x, box.low.y},
         {box.high.x, box.low.y},
         {box.low.x, box.high.y},
         {box.high.x, box.high.y},
         {middle.x, middle.y}}};
    return std::ranges::all_of(feet, [&](const std::pair<float, float>& foot) {
      return std::ranges::any_of(near, [&](size_t i) {
        const Surface& surface = world_.surfaces[i];
        float height_m = 0;
        return surface.kind != SurfaceKind::kStair &&
               surface.kind != SurfaceKind::kRamp &&
               surface.Normal().z > 0.99f &&
               HeightOnSurface(surface, foot.first, foot.second, height_m) &&
               std::abs(height_m - box.low.z) < kLevel_m;
      });
    });
  }

  bool IsInWay(const Box& box) const {
    if (!IsOff(world_.tour, box, kWayClear_m)) return true;
    for (const std::vector<Float3>& way : world_.ways) {
      if (!IsOff(way, box, kWayClear_m)) return true;
    }
    for (const NamedPlace& place : world_.places) {
      if (!IsOff({place.placement.origin}, box, kPlaceClear_m)) return true;
    }
    const WalkArea& walk = world_.walk_area;
    if (!(walk.half_x_m > 0) || box.high.z < kCameraLow_m) return false;
    const Float3 middle = box.Middle();
    const double x =
        (middle.x - walk.center_x_m) / (walk.half_x_m + kWalkMargin_m);
    const double y =
        (middle.y - walk.center_y_m) / (walk.half_y_m + kWalkMargin_m);
    return x * x + y * y < 1;
  }

  const Rearrangement& rearranged_;
  World& world_;
  std::vector<Box> boxes_;  // of surfaces
  std::vector<bool> is_gone_;
  std::vector<bool> is_light_gone_;
};

}  // namespace

void Rearrange(const Rearrangement& rearranged, World& world) {
  if (rearranged.share > 0) Rearranger(rearranged, world).Run();
}

absl::StatusOr<Rearrangement> ParseRearrangement(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits(':', 1));
  Rearrangement rearranged;
  if (!absl::SimpleAtoi(parts.first, &rearranged.seed) ||
      !absl::SimpleAtod(parts.second, &rearranged.share) ||
      !(rearranged.share >= 0 && rearranged.share <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", text.substr(0, 40),
                     "' is no SEED:SHARE: a whole number and a share in 0..1"));
  }
  return rearranged;
}

}  // namespace treeline::worlds

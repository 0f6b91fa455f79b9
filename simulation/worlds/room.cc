#include "simulation/worlds/room.h"

#include <array>
#include <cmath>
#include <utility>

#include "simulation/worlds/furniture.h"
#include "simulation/worlds/paint_fronts.h"
#include "simulation/worlds/paint_materials.h"
#include "simulation/worlds/paint_prints.h"
#include "simulation/worlds/world.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {
namespace {

using ProfilePoint = WorldBuilder::ProfilePoint;

constexpr float kPi = 3.14159265f;
// Furniture of one wall may reach this far into the next one's beginning.
constexpr float kCorner_m = 0.97f;
// The room called "room": picked by eye.
constexpr uint64_t kRoomSeed = 3;

class RoomMaker {
 public:
  explicit RoomMaker(uint64_t seed)
      : random_(seed, 0x400), furniture_(builder_, seed) {
    size_.x = Uniform(4.9f, 5.5f);
    size_.y = Uniform(4.0f, 4.5f);
    size_.z = Uniform(2.5f, 2.7f);
    white_ = Textured(
        [] {
          return PaintPlain({0.90f, 0.89f, 0.86f}, 0.06f, 1);
        },
        0.4f);
  }

  World Make(std::string name, int threads) {
    AddShell();
    AddCeilingLamp();
    // Two long walls and two short ones; the seed says which is which.
    const int seat_wall = random_.NextBelow(2) == 0 ? 0 : 2;
    const int window_wall = random_.NextBelow(2) == 0 ? 1 : 3;
    FurnishSeatWall(seat_wall);
    FurnishBookWall(2 - seat_wall);
    FurnishWindowWall(window_wall);
    FurnishDoorWall(4 - window_wall);
    AddMiddle();
    return builder_.Build(std::move(name), size_,
                          {.center_x_m = size_.x / 2,
                           .center_y_m = size_.y / 2,
                           .half_x_m = size_.x / 2 - 1.25,
                           .half_y_m = size_.y / 2 - 1.2},
                          threads);
  }

 private:
  float Uniform(float low, float high) {
    return static_cast<float>(random_.NextUniform(low, high));
  }

  Finish Textured(std::function<Canvas()> paint, float tile_m = 0,
                  float emission = 0) {
    return {.texture = builder_.AddTexture(std::move(paint)),
            .tile_m = tile_m,
            .emission = emission};
  }

  // Walls 0 to 3, counter-clockwise from the one along the x axis. Their
  // frames have x along the wall and y into the room.
  float WallLength(int wall) const { return wall % 2 == 0 ? size_.x : size_.y; }
  Placement Wall(int wall) const {
    const std::array<Float3, 4> corners = {Float3{0, 0, 0},
                                           {size_.x, 0, 0},
                                           {size_.x, size_.y, 0},
                                           {0, size_.y, 0}};
    return {corners[static_cast<size_t>(wall)],
            static_cast<float>(wall) * kPi / 2};
  }

  void AddShell() {
    const uint64_t seed = furniture_.NextSeed();
    const float hue = Uniform(0, 1);
    const Float3 pale = Hsv({Uniform(0.08f, 0.6f), 0.10f, 0.86f});
    const Float3 bold = Hsv({hue + 0.5f, Uniform(0.25f, 0.4f), 0.70f});
    const std::array<Finish, 4> finishes = {
        Textured([=] { return PaintWallpaper(hue, seed); }),
        Textured([=] { return PaintPlaster(pale, seed + 1); }),
        Textured([=] { return PaintPlaster(bold, seed + 2); }),
        Textured([=] { return PaintBrick(seed + 3); })};
    const uint32_t first = random_.NextBelow(4);
    for (int wall = 0; wall < 4; ++wall) {
      const float length = WallLength(wall);
      builder_.AddPanel(Wall(wall), {length, 0, size_.z}, {-length, 0, 0},
                        {0, 0, -size_.z},
                        finishes[(first + static_cast<uint32_t>(wall)) % 4]);
      builder_.AddBox(Wall(wall), {0.013f, 0, 0},
                      {length - 0.013f, 0.012f, 0.07f}, {.sides = white_});
    }
    const Placement origin;
    builder_.AddPanel(origin, {0, size_.y, 0}, {size_.x, 0, 0},
                      {0, -size_.y, 0},
                      Textured([=] { return PaintPlanks(seed + 4); }));
    builder_.AddPanel(origin, {0, 0, size_.z}, {size_.x, 0, 0}, {0, size_.y, 0},
                      Textured([=] {
                        return PaintPlaster({0.92f, 0.91f, 0.88f}, seed + 5);
                      }));
  }

  void AddCeilingLamp() {
    const Placement middle = {{size_.x / 2, size_.y / 2, 0}, 0};
    const float z = size_.z - 0.38f;
    const Finish shade = Textured(
        [] {
          return PaintFabric({0.95f, 0.90f, 0.78f}, 7);
        },
        0, 1.5f);
    builder_.BeginLamp();
    const ProfilePoint bowl[] = {
        {0.001f, 0}, {0.16f, 0.02f}, {0.24f, 0.09f}, {0.25f, 0.14f}};
    builder_.AddTurned(middle, {0, 0, z}, bowl, 28, shade);
    const ProfilePoint cable[] = {{0.008f, 0.13f}, {0.008f, 0.38f}};
    builder_.AddTurned(middle, {0, 0, z}, cable, 8, white_);
    const Float3 corner = middle.Point({-0.2f, -0.2f, z - 0.01f});
    builder_.AddLight({.corner = corner,
                       .edge_u = {0.4f, 0, 0},
                       .edge_v = {0, 0.4f, 0},
                       .radiance = {17, 15.5f, 13}});
    builder_.AddLight({.corner = corner + Float3{0, 0.4f, 0.18f},
                       .edge_u = {0.4f, 0, 0},
                       .edge_v = {0, -0.4f, 0},
                       .radiance = {12, 11, 9}});
    builder_.EndLamp();
  }

  void AddWindow(const Placement& wall, float x) {
    constexpr float kWidth = 1.6f;
    constexpr float kLow = 0.95f;
    constexpr float kHigh = 2.15f;
    const uint64_t seed = furniture_.NextSeed();
    builder_.AddView(wall, {x + kWidth, 0, kHigh}, {-kWidth, 0, 0},
                     {0, 0, kLow - kHigh}, kSkyRadiance,
                     Textured([=] { return PaintWindowView(seed); }, 0, 1.9f));
    // Frame, mullions and sill.
    for (const float bar :
         {x - 0.05f, x + kWidth / 2 - 0.03f, x + kWidth - 0.01f}) {
      builder_.AddBox(wall, {bar, 0, kLow}, {bar + 0.06f, 0.04f, kHigh},
                      {.sides = white_});
    }
    for (const float bar : {kLow - 0.05f, kHigh - 0.01f}) {
      builder_.AddBox(wall, {x - 0.05f, 0, bar},
                      {x + kWidth + 0.05f, 0.041f, bar + 0.06f},
                      {.sides = white_, .has_bottom = true});
    }
    builder_.AddBox(wall, {x - 0.1f, 0, kLow - 0.08f},
                    {x + kWidth + 0.1f, 0.14f, kLow - 0.051f},
                    {.sides = white_, .has_bottom = true});
    const float hue = Uniform(0, 1);
    const Finish curtain = Textured([=] { return PaintCurtain(hue, seed); });
    for (const float side : {x - 0.42f, x + kWidth + 0.04f}) {
      builder_.AddBox(wall, {side, 0.05f, 0.12f}, {side + 0.38f, 0.11f, 2.32f},
                      {.sides = curtain, .has_bottom = true});
    }
    builder_.AddBox(wall, {x - 0.5f, 0.06f, 2.325f},
                    {x + kWidth + 0.5f, 0.09f, 2.35f},
                    {.sides = white_, .has_bottom = true});
    builder_.AddBox(wall, {x + 0.1f, 0.02f, 0.15f},
                    {x + kWidth - 0.1f, 0.1f, 0.72f},
                    {.sides = white_,
                     .front = Textured([=] { return PaintRadiator(seed); }),
                     .has_bottom = true});
  }

  void AddDoor(const Placement& wall, float x) {
    const uint64_t seed = furniture_.NextSeed();
    const Float3 color = Hsv({Uniform(0, 1), 0.15f, 0.82f});
    builder_.AddBox(wall, {x, 0, 0}, {x + 0.9f, 0.025f, 2.03f},
                    {.sides = white_, .front = Textured([=] {
                                        return PaintDoor(color, seed);
                                      })});
    for (const float bar : {x - 0.08f, x + 0.9f}) {
      builder_.AddBox(wall, {bar, 0, 0}, {bar + 0.08f, 0.045f, 2.11f},
                      {.sides = white_});
    }
    builder_.AddBox(wall, {x, 0, 2.03f}, {x + 0.9f, 0.044f, 2.11f},
                    {.sides = white_, .has_bottom = true});
    const Finish brass = Textured(
        [] {
          return PaintPlain({0.75f, 0.62f, 0.30f}, 0.1f, 3);
        },
        0.4f);
    builder_.AddBox(wall, {x + 0.07f, 0.026f, 1.01f},
                    {x + 0.20f, 0.075f, 1.035f},
                    {.sides = brass, .has_bottom = true});
    // The light switch.
    builder_.AddBox(wall, {x - 0.24f, 0, 1.06f}, {x - 0.16f, 0.012f, 1.14f},
                    {.sides = white_, .has_bottom = true});
  }

  // Pictures side by side from x0 to x1, their middles about 1.6 m high.
  void HangPictures(const Placement& wall, float x0, float x1) {
    float x = x0 + Uniform(0.02f, 0.12f);
    while (true) {
      const float width = Uniform(0.34f, 0.72f);
      const float height = width * Uniform(0.75f, 1.35f);
      if (x + width > x1) return;
      const float z = 1.62f + Uniform(-0.08f, 0.08f) - height / 2;
      furniture_.things().Picture(wall.At({x, 0, z}), width, height);
      x += width + Uniform(0.08f, 0.3f);
    }
  }

  // Makes something that could stand elsewhere.
  template <typename Make>
  void AddPiece(Make make) {
    builder_.BeginPiece();
    make();
    builder_.EndPiece();
  }
  void AddPlant(const Placement& at, float low_m, float high_m) {
    AddPiece([&] { furniture_.things().Plant(at, Uniform(low_m, high_m)); });
  }
  void AddChair(const Placement& at) {
    AddPiece([&] { furniture_.home().Chair(at); });
  }
  void AddBoxes(const Placement& at) {
    AddPiece([&] { furniture_.things().BoxStack(at); });
  }

  void FurnishSeatWall(int wall) {
    const Placement at = Wall(wall);
    const float x = kCorner_m + Uniform(0.0f, 0.15f);
    AddPlant(at.At({x, 0.03f, 0}), 1.0f, 1.35f);
    AddPiece([&] { furniture_.home().Sofa(at.At({x + 0.55f, 0.02f, 0})); });
    AddPiece([&] {
      furniture_.things().FloorLamp(at.At({x + 2.6f, 0.1f, 0}));
    });
    HangPictures(at, x + 0.4f, x + 2.6f);
    furniture_.things().Clock(at.At({x + 2.75f, 0, 1.95f}));
    const float rest = WallLength(wall) - (x + 3.1f);
    if (rest > 0.55f) {
      AddBoxes(at.At({x + 3.1f, 0.03f, 0}));
    }
  }

  void FurnishBookWall(int wall) {
    const Placement at = Wall(wall);
    float x = kCorner_m + Uniform(0.0f, 0.2f);
    furniture_.home().Bookcase(at.At({x, 0, 0}), 0.9f);
    furniture_.home().Bookcase(at.At({x + 0.91f, 0, 0}), 0.9f);
    x += 1.9f + Uniform(0, 0.15f);
    const float width = std::min(1.9f, WallLength(wall) - x - 0.1f);
    furniture_.home().Sideboard(at.At({x, 0, 0}), width);
    HangPictures(at, x + 0.05f, x + width);
  }

  void FurnishWindowWall(int wall) {
    const Placement at = Wall(wall);
    const float x = 1.38f + Uniform(0.0f, 0.1f);
    AddWindow(at, x);
    furniture_.home().Desk(at.At({x + 0.05f, 0.12f, 0}));
    AddChair(at.At({x + 0.75f, 1.08f, 0}, kPi + Uniform(-0.4f, 0.4f)));
    AddPlant(at.At({WallLength(wall) - 0.55f, 0.1f, 0}), 0.6f, 0.9f);
    HangPictures(at, 0.05f, x - 0.45f);
  }

  void FurnishDoorWall(int wall) {
    const Placement at = Wall(wall);
    const float x = kCorner_m + Uniform(0.1f, 0.25f);
    AddDoor(at, x + 0.1f);
    furniture_.home().Wardrobe(at.At({WallLength(wall) - 1.05f, 0, 0}));
    const float free = WallLength(wall) - 1.1f;
    furniture_.things().WallShelf(at.At({x + 1.18f, 0, 1.45f}),
                                  std::max(0.5f, free - x - 1.25f));
    AddBoxes(at.At({x + 1.2f, 0.02f, 0}));
    HangPictures(at, 0.05f, x - 0.1f);
  }

  void AddMiddle() {
    const uint64_t seed = furniture_.NextSeed();
    const float hue = Uniform(0, 1);
    const float turn = Uniform(-0.15f, 0.15f);
    const Placement middle = {{size_.x / 2, size_.y / 2, 0}, turn};
    builder_.AddBox(middle, {-1.15f, -0.75f, 0}, {1.15f, 0.75f, 0.008f},
                    {.sides = white_,
                     .top = Textured([=] { return PaintRug(hue, seed); })});
    const Placement rug = middle.At({0, 0, 0.0085f});
    const float table_turn = Uniform(-0.1f, 0.1f);
    AddPiece([&] {
      furniture_.home().CoffeeTable(rug.At({0.05f, 0, 0}, table_turn));
    });
    AddChair(rug.At({-0.82f, 0.25f, 0}, 1.3f + Uniform(-0.3f, 0.3f)));
  }

  WorldBuilder builder_;
  base::Random random_;
  FurnitureMaker furniture_;
  Float3 size_;
  Finish white_;
};

}  // namespace

World MakeRoom(std::string name, std::optional<uint64_t> seed, int threads) {
  return RoomMaker(seed.value_or(kRoomSeed)).Make(std::move(name), threads);
}

}  // namespace treeline::worlds

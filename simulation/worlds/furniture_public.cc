// Furniture of cafes and offices, and furniture by its name.
#include <cmath>

#include "simulation/worlds/furniture.h"
#include "simulation/worlds/noise.h"
#include "simulation/worlds/paint.h"
#include "simulation/worlds/paint_building.h"

namespace treeline::worlds {
namespace {

using ProfilePoint = WorldBuilder::ProfilePoint;

constexpr float kPi = 3.14159265f;

}  // namespace

void FurnitureMaker::CafeTable(const Placement& at) {
  const Finish& wood = random_.NextBelow(2) == 0 ? dark_wood_ : light_wood_;
  const ProfilePoint foot[] = {
      {0.20f, 0}, {0.20f, 0.02f}, {0.035f, 0.035f}, {0.03f, 0.71f}};
  builder_.AddTurned(at, {0, 0, 0}, foot, 16, black_);
  const ProfilePoint top[] = {
      {0.001f, 0.71f}, {0.345f, 0.711f}, {0.35f, 0.74f}, {0.001f, 0.7405f}};
  builder_.AddTurned(at, {0, 0, 0}, top, 24, wood);
  SmallThing(at.At({Uniform(-0.1f, 0.1f), Uniform(-0.1f, 0.1f), 0.742f}));
  const Finish page =
      Stretched([seed = NextSeed()] { return PaintMagazine(seed); });
  builder_.AddBox(at.At({0.1f, -0.2f, 0.742f}, Uniform(-1, 1)), {0, 0, 0},
                  {0.15f, 0.2f, 0.004f}, {.sides = paper_edge_, .top = page});
}

void FurnitureMaker::Table(const Placement& at, float width_m) {
  const Finish& wood = random_.NextBelow(2) == 0 ? dark_wood_ : light_wood_;
  const float half = width_m / 2;
  TableLegs(at, {0.04f - half, -0.36f, 0}, {half - 0.04f, 0.36f, 0.71f}, 0.06f,
            wood);
  builder_.AddBox(at, {-half, -0.4f, 0.71f}, {half, 0.4f, 0.745f},
                  {.sides = wood, .has_bottom = true});
  for (float x = 0.25f - half; x < half - 0.2f; x += Uniform(0.5f, 0.8f)) {
    if (random_.NextBelow(3) == 0) {
      SmallThing(at.At({x, Uniform(-0.2f, 0.2f), 0.746f}));
    } else {
      const Finish page =
          Stretched([seed = NextSeed()] { return PaintPage(seed); });
      builder_.AddBox(
          at.At({x, Uniform(-0.2f, 0.1f), 0.746f}, Uniform(-0.5f, 0.5f)),
          {-0.1f, -0.14f, 0}, {0.1f, 0.14f, 0.003f},
          {.sides = paper_edge_, .top = page});
    }
  }
}

void FurnitureMaker::Counter(const Placement& at, float width_m) {
  const float half = width_m / 2;
  const Float3 tone = Hsv({Uniform(0, 1), Uniform(0.2f, 0.5f), 0.6f});
  const int columns = std::max(2, static_cast<int>(width_m / 0.6f));
  const Finish front = Stretched(
      [=, seed = NextSeed()] { return PaintCupboard(tone, columns, 2, seed); });
  builder_.AddBox(at, {-half + 0.03f, -0.33f, 0}, {half - 0.03f, 0.3f, 1.02f},
                  {.sides = dark_wood_, .front = front});
  builder_.AddBox(at, {-half, -0.35f, 1.02f}, {half, 0.35f, 1.06f},
                  {.sides = light_wood_, .has_bottom = true});
  const Finish screen =
      Stretched([seed = NextSeed()] { return PaintScreen(seed); }, 0.4f);
  // A till, a coffee machine, and what one sells.
  builder_.AddBox(at, {half - 0.75f, -0.2f, 1.061f},
                  {half - 0.4f, 0.05f, 1.18f}, {.sides = black_});
  builder_.AddBox(at, {half - 0.72f, -0.02f, 1.181f},
                  {half - 0.43f, 0.02f, 1.42f},
                  {.sides = black_, .front = screen, .has_bottom = true});
  if (width_m > 1.8f) {
    const Finish machine = Stretched([seed = NextSeed()] {
      return PaintCupboard({0.6f, 0.6f, 0.62f}, 3, 2, seed);
    });
    builder_.AddBox(at, {-half + 0.15f, -0.3f, 1.061f},
                    {-half + 0.85f, 0.12f, 1.5f},
                    {.sides = metal_, .front = machine});
  }
  for (float x = 1.05f - half; x < half - 0.9f; x += Uniform(0.25f, 0.4f)) {
    SmallThing(at.At({x, Uniform(-0.1f, 0.15f), 1.061f}));
  }
}

void FurnitureMaker::Bench(const Placement& at, float width_m) {
  const float half = width_m / 2;
  TableLegs(at, {0.05f - half, -0.17f, 0}, {half - 0.05f, 0.17f, 0.41f}, 0.05f,
            metal_);
  for (int i = 0; i < 4; ++i) {
    const float y = -0.2f + 0.102f * static_cast<float>(i);
    builder_.AddBox(at, {-half, y, 0.41f}, {half, y + 0.09f, 0.45f},
                    {.sides = light_wood_, .has_bottom = true});
  }
}

void FurnitureMaker::Stool(const Placement& at) {
  const ProfilePoint stem[] = {
      {0.17f, 0}, {0.17f, 0.015f}, {0.02f, 0.03f}, {0.02f, 0.62f}};
  builder_.AddTurned(at, {0, 0, 0}, stem, 14, metal_);
  const float hue = Uniform(0, 1);
  const Finish seat =
      Stretched([hue, seed = NextSeed()] { return PaintClothes(hue, seed); });
  const ProfilePoint cushion[] = {
      {0.001f, 0.62f}, {0.17f, 0.622f}, {0.175f, 0.68f}, {0.001f, 0.69f}};
  builder_.AddTurned(at, {0, 0, 0}, cushion, 16, seat);
}

void FurnitureMaker::Machine(const Placement& at) {
  const uint64_t seed = NextSeed();
  const Float3 body = Hsv({Uniform(0, 1), 0.6f, 0.5f});
  const Finish sides = Stretched([=] { return PaintPlain(body, 0.2f, seed); });
  const Finish front = Stretched(
      [=] {
        Canvas canvas(256, 512, body);
        canvas.Rect(14, 40, 180, 400, {0.12f, 0.13f, 0.15f});
        for (int row = 0; row < 7; ++row) {
          for (int column = 0; column < 6; ++column) {
            const float x = 20 + 26 * static_cast<float>(column);
            const float y = 52 + 48 * static_cast<float>(row);
            const Float3 can = Hsv({CellNoise(column, row, seed), 0.7f, 0.85f});
            canvas.Rect(x, y, x + 18, y + 34, can);
            canvas.Rect(x + 3, y + 10, x + 15, y + 18, {1, 1, 1}, 0.7f);
          }
        }
        canvas.Rect(196, 120, 240, 190, {0.7f, 0.9f, 0.75f});
        canvas.Text(20, 230, 10, 20, {1, 1, 1}, seed);
        canvas.Rect(14, 430, 180, 490, {0.05f, 0.05f, 0.05f});
        return canvas;
      },
      0.3f);
  builder_.AddBox(at, {-0.475f, -0.4f, 0}, {0.475f, 0.4f, 1.86f},
                  {.sides = sides, .front = front});
}

void FurnitureMaker::OfficeChair(const Placement& at) {
  const float hue = Uniform(0.5f, 0.75f);
  const Finish cloth =
      Stretched([hue, seed = NextSeed()] { return PaintClothes(hue, seed); });
  for (int i = 0; i < 5; ++i) {
    builder_.AddBox(at.At({0, 0, 0}, 2 * kPi * static_cast<float>(i) / 5),
                    {0.02f, -0.02f, 0.03f}, {0.29f, 0.02f, 0.08f},
                    {.sides = black_, .has_bottom = true});
  }
  const ProfilePoint stem[] = {{0.03f, 0.05f}, {0.03f, 0.42f}};
  builder_.AddTurned(at, {0, 0, 0}, stem, 8, metal_);
  builder_.AddBox(at, {-0.24f, -0.23f, 0.42f}, {0.24f, 0.24f, 0.49f},
                  {.sides = cloth, .has_bottom = true});
  builder_.AddBox(at, {-0.22f, -0.26f, 0.55f}, {0.22f, -0.20f, 1.05f},
                  {.sides = cloth, .has_bottom = true});
  builder_.AddBox(at, {-0.03f, -0.27f, 0.44f}, {0.03f, -0.235f, 0.6f},
                  {.sides = black_});
}

void FurnitureMaker::Bin(const Placement& at) {
  const ProfilePoint bin[] = {{0.11f, 0},
                              {0.15f, 0.4f},
                              {0.14f, 0.4f},
                              {0.10f, 0.05f},
                              {0.001f, 0.05f}};
  builder_.AddTurned(at, {0, 0, 0}, bin, 16, metal_);
}

void FurnitureMaker::Rack(const Placement& at, float width_m) {
  const float half = width_m / 2;
  TableLegs(at, {-half, -0.225f, 0}, {half, 0.225f, 1.8f}, 0.035f, metal_);
  for (int shelf = 0; shelf < 4; ++shelf) {
    const float z = 0.12f + 0.52f * static_cast<float>(shelf);
    builder_.AddBox(at, {-half + 0.001f, -0.22f, z},
                    {half - 0.001f, 0.22f, z + 0.03f},
                    {.sides = metal_, .has_bottom = true});
    for (float x = 0.06f - half; x < half - 0.3f; x += Uniform(0.36f, 0.5f)) {
      const Finish face =
          Stretched([seed = NextSeed()] { return PaintCardboard(seed); });
      builder_.AddBox(
          at, {x, -0.18f, z + 0.0305f},
          {x + 0.3f, Uniform(0.08f, 0.18f), z + 0.03f + Uniform(0.18f, 0.4f)},
          {.sides = face, .front = face});
    }
  }
}

void FurnitureMaker::Crate(const Placement& at, float width_m) {
  const Finish face =
      Stretched([seed = NextSeed()] { return PaintCardboard(seed); });
  const float half = width_m / 2;
  builder_.AddBox(at, {-half, -0.3f, 0}, {half, 0.3f, 0.55f},
                  {.sides = face, .front = face, .top = face});
}

void FurnitureMaker::Rug(const Placement& at, float width_m) {
  const float hue = Uniform(0, 1);
  const float half = width_m / 2;
  builder_.AddBox(
      at, {-half, -0.7f, 0}, {half, 0.7f, 0.008f},
      {.sides = paper_edge_, .top = Stretched([hue, seed = NextSeed()] {
                               return PaintRug(hue, seed);
                             })});
}

bool FurnitureMaker::ByName(absl::string_view name, const Placement& at,
                            float width_m) {
  const struct {
    absl::string_view name;
    void (FurnitureMaker::*make)(const Placement&);
  } kFixed[] = {
      {"desk", &FurnitureMaker::Desk},
      {"wardrobe", &FurnitureMaker::Wardrobe},
      {"sofa", &FurnitureMaker::Sofa},
      {"floor_lamp", &FurnitureMaker::FloorLamp},
      {"boxes", &FurnitureMaker::BoxStack},
      {"chair", &FurnitureMaker::Chair},
      {"coffee_table", &FurnitureMaker::CoffeeTable},
      {"cafe_table", &FurnitureMaker::CafeTable},
      {"stool", &FurnitureMaker::Stool},
      {"machine", &FurnitureMaker::Machine},
      {"office_chair", &FurnitureMaker::OfficeChair},
      {"bin", &FurnitureMaker::Bin},
  };
  const struct {
    absl::string_view name;
    void (FurnitureMaker::*make)(const Placement&, float);
  } kWide[] = {
      {"bookcase", &FurnitureMaker::Bookcase},
      {"sideboard", &FurnitureMaker::Sideboard},
      {"table", &FurnitureMaker::Table},
      {"counter", &FurnitureMaker::Counter},
      {"bench", &FurnitureMaker::Bench},
      {"rack", &FurnitureMaker::Rack},
      {"crate", &FurnitureMaker::Crate},
      {"rug", &FurnitureMaker::Rug},
  };
  for (const auto& piece : kFixed) {
    if (piece.name != name) continue;
    (this->*piece.make)(at);
    return true;
  }
  for (const auto& piece : kWide) {
    if (piece.name != name) continue;
    (this->*piece.make)(at, width_m);
    return true;
  }
  if (name != "plant") return false;
  Plant(at, Uniform(0.7f, 1.3f));
  return true;
}

}  // namespace treeline::worlds

#include "simulation/worlds/furniture_public.h"

#include <cmath>

#include "simulation/worlds/noise.h"
#include "simulation/worlds/paint_building.h"
#include "simulation/worlds/paint_fronts.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {
namespace {

using ProfilePoint = WorldBuilder::ProfilePoint;

constexpr float kPi = 3.14159265f;

}  // namespace

void PublicFurniture::CafeTable(const Placement& at) {
  const Finish& wood =
      shop_.random.NextBelow(2) == 0 ? shop_.dark_wood : shop_.light_wood;
  const ProfilePoint foot[] = {
      {0.20f, 0}, {0.20f, 0.02f}, {0.035f, 0.035f}, {0.03f, 0.71f}};
  shop_.builder.AddTurned(at, {0, 0, 0}, foot, 16, shop_.black);
  const ProfilePoint top[] = {
      {0.001f, 0.71f}, {0.345f, 0.711f}, {0.35f, 0.74f}, {0.001f, 0.7405f}};
  shop_.builder.AddTurned(at, {0, 0, 0}, top, 24, wood);
  things_.SmallThing(
      at.At({shop_.Uniform(-0.1f, 0.1f), shop_.Uniform(-0.1f, 0.1f), 0.742f}));
  const Finish page = shop_.Stretched(
      [seed = shop_.NextSeed()] { return PaintMagazine(seed); });
  shop_.builder.AddBox(at.At({0.1f, -0.2f, 0.742f}, shop_.Uniform(-1, 1)),
                       {0, 0, 0}, {0.15f, 0.2f, 0.004f},
                       {.sides = shop_.paper_edge, .top = page});
}

void PublicFurniture::Table(const Placement& at, float width_m) {
  const Finish& wood =
      shop_.random.NextBelow(2) == 0 ? shop_.dark_wood : shop_.light_wood;
  const float half = width_m / 2;
  shop_.TableLegs(at, {0.04f - half, -0.36f, 0}, {half - 0.04f, 0.36f, 0.71f},
                  0.06f, wood);
  shop_.builder.AddBox(at, {-half, -0.4f, 0.71f}, {half, 0.4f, 0.745f},
                       {.sides = wood, .has_bottom = true});
  for (float x = 0.25f - half; x < half - 0.2f;
       x += shop_.Uniform(0.5f, 0.8f)) {
    if (shop_.random.NextBelow(3) == 0) {
      things_.SmallThing(at.At({x, shop_.Uniform(-0.2f, 0.2f), 0.746f}));
    } else {
      const Finish page = shop_.Stretched(
          [seed = shop_.NextSeed()] { return PaintPage(seed); });
      shop_.builder.AddBox(at.At({x, shop_.Uniform(-0.2f, 0.1f), 0.746f},
                                 shop_.Uniform(-0.5f, 0.5f)),
                           {-0.1f, -0.14f, 0}, {0.1f, 0.14f, 0.003f},
                           {.sides = shop_.paper_edge, .top = page});
    }
  }
}

void PublicFurniture::Counter(const Placement& at, float width_m) {
  const float half = width_m / 2;
  const Float3 tone =
      Hsv({shop_.Uniform(0, 1), shop_.Uniform(0.2f, 0.5f), 0.6f});
  const int columns = std::max(2, static_cast<int>(width_m / 0.6f));
  const Finish front = shop_.Stretched([=, seed = shop_.NextSeed()] {
    return PaintCupboard(tone, columns, 2, seed);
  });
  shop_.builder.AddBox(at, {-half + 0.03f, -0.33f, 0},
                       {half - 0.03f, 0.3f, 1.02f},
                       {.sides = shop_.dark_wood, .front = front});
  shop_.builder.AddBox(at, {-half, -0.35f, 1.02f}, {half, 0.35f, 1.06f},
                       {.sides = shop_.light_wood, .has_bottom = true});
  const Finish screen = shop_.Stretched(
      [seed = shop_.NextSeed()] { return PaintScreen(seed); }, 0.4f);
  // A till, a coffee machine, and what one sells.
  shop_.builder.AddBox(at, {half - 0.75f, -0.2f, 1.061f},
                       {half - 0.4f, 0.05f, 1.18f}, {.sides = shop_.black});
  shop_.builder.AddBox(
      at, {half - 0.72f, -0.02f, 1.181f}, {half - 0.43f, 0.02f, 1.42f},
      {.sides = shop_.black, .front = screen, .has_bottom = true});
  if (width_m > 1.8f) {
    const Finish machine = shop_.Stretched([seed = shop_.NextSeed()] {
      return PaintCupboard({0.6f, 0.6f, 0.62f}, 3, 2, seed);
    });
    shop_.builder.AddBox(at, {-half + 0.15f, -0.3f, 1.061f},
                         {-half + 0.85f, 0.12f, 1.5f},
                         {.sides = shop_.metal, .front = machine});
  }
  for (float x = 1.05f - half; x < half - 0.9f;
       x += shop_.Uniform(0.25f, 0.4f)) {
    things_.SmallThing(at.At({x, shop_.Uniform(-0.1f, 0.15f), 1.061f}));
  }
}

void PublicFurniture::Bench(const Placement& at, float width_m) {
  const float half = width_m / 2;
  shop_.TableLegs(at, {0.05f - half, -0.17f, 0}, {half - 0.05f, 0.17f, 0.41f},
                  0.05f, shop_.metal);
  for (int i = 0; i < 4; ++i) {
    const float y = -0.2f + 0.102f * static_cast<float>(i);
    shop_.builder.AddBox(at, {-half, y, 0.41f}, {half, y + 0.09f, 0.45f},
                         {.sides = shop_.light_wood, .has_bottom = true});
  }
}

void PublicFurniture::Stool(const Placement& at) {
  const ProfilePoint stem[] = {
      {0.17f, 0}, {0.17f, 0.015f}, {0.02f, 0.03f}, {0.02f, 0.62f}};
  shop_.builder.AddTurned(at, {0, 0, 0}, stem, 14, shop_.metal);
  const float hue = shop_.Uniform(0, 1);
  const Finish seat = shop_.Stretched(
      [hue, seed = shop_.NextSeed()] { return PaintClothes(hue, seed); });
  const ProfilePoint cushion[] = {
      {0.001f, 0.62f}, {0.17f, 0.622f}, {0.175f, 0.68f}, {0.001f, 0.69f}};
  shop_.builder.AddTurned(at, {0, 0, 0}, cushion, 16, seat);
}

void PublicFurniture::Machine(const Placement& at) {
  const uint64_t seed = shop_.NextSeed();
  const Float3 body = Hsv({shop_.Uniform(0, 1), 0.6f, 0.5f});
  const Finish sides =
      shop_.Stretched([=] { return PaintPlain(body, 0.2f, seed); });
  const Finish front = shop_.Stretched(
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
  shop_.builder.AddBox(at, {-0.475f, -0.4f, 0}, {0.475f, 0.4f, 1.86f},
                       {.sides = sides, .front = front});
}

void PublicFurniture::OfficeChair(const Placement& at) {
  const float hue = shop_.Uniform(0.5f, 0.75f);
  const Finish cloth = shop_.Stretched(
      [hue, seed = shop_.NextSeed()] { return PaintClothes(hue, seed); });
  for (int i = 0; i < 5; ++i) {
    shop_.builder.AddBox(at.At({0, 0, 0}, 2 * kPi * static_cast<float>(i) / 5),
                         {0.02f, -0.02f, 0.03f}, {0.29f, 0.02f, 0.08f},
                         {.sides = shop_.black, .has_bottom = true});
  }
  const ProfilePoint stem[] = {{0.03f, 0.05f}, {0.03f, 0.42f}};
  shop_.builder.AddTurned(at, {0, 0, 0}, stem, 8, shop_.metal);
  shop_.builder.AddBox(at, {-0.24f, -0.23f, 0.42f}, {0.24f, 0.24f, 0.49f},
                       {.sides = cloth, .has_bottom = true});
  shop_.builder.AddBox(at, {-0.22f, -0.26f, 0.55f}, {0.22f, -0.20f, 1.05f},
                       {.sides = cloth, .has_bottom = true});
  shop_.builder.AddBox(at, {-0.03f, -0.27f, 0.44f}, {0.03f, -0.235f, 0.6f},
                       {.sides = shop_.black});
}

void PublicFurniture::Bin(const Placement& at) {
  const ProfilePoint bin[] = {{0.11f, 0},
                              {0.15f, 0.4f},
                              {0.14f, 0.4f},
                              {0.10f, 0.05f},
                              {0.001f, 0.05f}};
  shop_.builder.AddTurned(at, {0, 0, 0}, bin, 16, shop_.metal);
}

void PublicFurniture::Rack(const Placement& at, float width_m) {
  const float half = width_m / 2;
  shop_.TableLegs(at, {-half, -0.225f, 0}, {half, 0.225f, 1.8f}, 0.035f,
                  shop_.metal);
  for (int shelf = 0; shelf < 4; ++shelf) {
    const float z = 0.12f + 0.52f * static_cast<float>(shelf);
    shop_.builder.AddBox(at, {-half + 0.001f, -0.22f, z},
                         {half - 0.001f, 0.22f, z + 0.03f},
                         {.sides = shop_.metal, .has_bottom = true});
    for (float x = 0.06f - half; x < half - 0.3f;
         x += shop_.Uniform(0.36f, 0.5f)) {
      const Finish face = shop_.Stretched(
          [seed = shop_.NextSeed()] { return PaintCardboard(seed); });
      shop_.builder.AddBox(at, {x, -0.18f, z + 0.0305f},
                           {x + 0.3f, shop_.Uniform(0.08f, 0.18f),
                            z + 0.03f + shop_.Uniform(0.18f, 0.4f)},
                           {.sides = face, .front = face});
    }
  }
}

void PublicFurniture::Crate(const Placement& at, float width_m) {
  const Finish face = shop_.Stretched(
      [seed = shop_.NextSeed()] { return PaintCardboard(seed); });
  const float half = width_m / 2;
  shop_.builder.AddBox(at, {-half, -0.3f, 0}, {half, 0.3f, 0.55f},
                       {.sides = face, .front = face, .top = face});
}

void PublicFurniture::Rug(const Placement& at, float width_m) {
  const float hue = shop_.Uniform(0, 1);
  const float half = width_m / 2;
  shop_.builder.AddBox(at, {-half, -0.7f, 0}, {half, 0.7f, 0.008f},
                       {.sides = shop_.paper_edge,
                        .top = shop_.Stretched([hue, seed = shop_.NextSeed()] {
                          return PaintRug(hue, seed);
                        })});
}

}  // namespace treeline::worlds

#include "simulation/worlds/furniture_home.h"

#include <cmath>

#include "simulation/worlds/paint_fronts.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {
namespace {

using ProfilePoint = WorldBuilder::ProfilePoint;

}  // namespace

void HomeFurniture::Bookcase(const Placement& at, float width_m) {
  constexpr float kDepth = 0.3f;
  constexpr float kHeight = 2.05f;
  constexpr float kBoard = 0.022f;
  constexpr int kShelves = 6;
  const Finish wood =
      shop_.random.NextBelow(2) == 0 ? shop_.dark_wood : shop_.light_wood;
  shop_.builder.AddBox(at, {0, 0, 0}, {kBoard, kDepth, kHeight},
                       {.sides = wood});
  shop_.builder.AddBox(at, {width_m - kBoard, 0, 0}, {width_m, kDepth, kHeight},
                       {.sides = wood});
  shop_.builder.AddPanel(at, {width_m - kBoard, 0.012f, kHeight},
                         {-(width_m - 2 * kBoard), 0, 0}, {0, 0, -kHeight},
                         wood);
  const float pitch = (kHeight - kBoard - 0.08f) / kShelves;
  for (int i = 0; i <= kShelves; ++i) {
    const float z = 0.08f + pitch * static_cast<float>(i);
    shop_.builder.AddBox(at, {kBoard, 0.013f, z - kBoard},
                         {width_m - kBoard, kDepth - 0.005f, z},
                         {.sides = wood, .has_bottom = true});
    if (i < kShelves) {
      things_.Books(at, kBoard, width_m - kBoard, kDepth, z + 0.0005f,
                    pitch - kBoard);
    }
  }
  for (float x = 0.18f; x < width_m - 0.15f; x += 0.33f) {
    things_.SmallThing(at.At({x, 0.15f, kHeight + 0.0005f}));
  }
}

void HomeFurniture::Desk(const Placement& at) {
  constexpr float kTop = 0.74f;
  shop_.builder.AddBox(at, {0, 0.02f, kTop - 0.03f}, {1.5f, 0.75f, kTop},
                       {.sides = shop_.light_wood, .has_bottom = true});
  shop_.TableLegs(at, {0.03f, 0.05f, 0}, {1.47f, 0.72f, kTop - 0.03f}, 0.05f,
                  shop_.metal);
  const Finish drawers = shop_.Stretched([seed = shop_.NextSeed()] {
    return PaintCupboard({0.75f, 0.60f, 0.42f}, 1, 3, seed);
  });
  shop_.builder.AddBox(at, {1.0f, 0.08f, 0.06f}, {1.4f, 0.68f, kTop - 0.04f},
                       {.sides = shop_.light_wood, .front = drawers});
  for (int i = 0; i < 3; ++i) {
    const float z = 0.16f + 0.213f * static_cast<float>(i);
    shop_.builder.AddBox(at, {1.15f, 0.68f, z}, {1.25f, 0.70f, z + 0.015f},
                         {.sides = shop_.black, .has_bottom = true});
  }
  // Monitor, keyboard, pages, and what else there is.
  const float z = kTop + 0.0005f;
  const Finish screen = shop_.Stretched(
      [seed = shop_.NextSeed()] { return PaintScreen(seed); }, 0.55f);
  shop_.builder.AddBox(at, {0.58f, 0.16f, z}, {0.82f, 0.34f, z + 0.015f},
                       {.sides = shop_.black});
  shop_.builder.AddBox(at, {0.67f, 0.22f, z}, {0.73f, 0.25f, z + 0.16f},
                       {.sides = shop_.black});
  shop_.builder.AddBox(at, {0.40f, 0.25f, z + 0.12f}, {1.0f, 0.285f, z + 0.48f},
                       {.sides = shop_.black, .has_bottom = true});
  shop_.builder.AddPanel(at, {0.985f, 0.2855f, z + 0.465f}, {-0.57f, 0, 0},
                         {0, 0, -0.32f}, screen);
  const Finish keys = shop_.Stretched(
      [seed = shop_.NextSeed()] { return PaintKeyboard(seed); });
  shop_.builder.AddBox(at, {0.47f, 0.44f, z}, {0.92f, 0.58f, z + 0.02f},
                       {.sides = shop_.black, .top = keys});
  for (int i = 0; i < 4; ++i) {
    const Finish page =
        shop_.Stretched([seed = shop_.NextSeed()] { return PaintPage(seed); });
    const float x =
        i < 2 ? shop_.Uniform(0.05f, 0.2f) : shop_.Uniform(1.05f, 1.2f);
    const float y = shop_.Uniform(0.34f, 0.42f);
    const float layer = z + 0.002f * static_cast<float>(i);
    shop_.builder.AddPanel(at.At({x, y, 0}, shop_.Uniform(-0.3f, 0.3f)),
                           {0.21f, 0, layer}, {-0.21f, 0, 0}, {0, 0.297f, 0},
                           page);
  }
  things_.SmallThing(at.At({0.2f, 0.2f, z}));
  things_.SmallThing(at.At({1.3f, 0.2f, z}));
  things_.SmallThing(at.At({1.02f, 0.60f, z}));
}

void HomeFurniture::Sideboard(const Placement& at, float width_m) {
  const float height = shop_.Uniform(0.72f, 0.9f);
  const Float3 tone =
      Hsv({shop_.Uniform(0.03f, 0.12f), 0.5f, shop_.Uniform(0.4f, 0.8f)});
  const int columns = static_cast<int>(width_m / 0.5f);
  const int rows = 1 + static_cast<int>(shop_.random.NextBelow(3));
  const Finish body = shop_.Wood(tone);
  const Finish front = shop_.Stretched([=, seed = shop_.NextSeed()] {
    return PaintCupboard(tone, columns, rows, seed);
  });
  shop_.builder.AddBox(at, {0.03f, 0.03f, 0}, {width_m - 0.03f, 0.40f, 0.07f},
                       {.sides = shop_.black});
  shop_.builder.AddBox(at, {0, 0.01f, 0.07f}, {width_m, 0.45f, height},
                       {.sides = body, .front = front});
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows; ++row) {
      const float x = width_m * (static_cast<float>(column) + 0.5f) /
                      static_cast<float>(columns);
      const float z = 0.07f + (height - 0.07f) *
                                  (static_cast<float>(row) + 0.8f) /
                                  static_cast<float>(rows);
      shop_.builder.AddBox(at, {x - 0.05f, 0.45f, z - 0.006f},
                           {x + 0.05f, 0.475f, z + 0.006f},
                           {.sides = shop_.metal, .has_bottom = true});
    }
  }
  for (float x = 0.2f; x < width_m - 0.15f; x += shop_.Uniform(0.3f, 0.45f)) {
    things_.SmallThing(
        at.At({x, 0.22f, height + 0.0005f}, shop_.Uniform(-0.3f, 0.3f)));
  }
}

void HomeFurniture::Wardrobe(const Placement& at) {
  const Float3 tone =
      Hsv({shop_.Uniform(0.05f, 0.1f), 0.45f, shop_.Uniform(0.55f, 0.8f)});
  const Finish body = shop_.Wood(tone);
  const Finish front = shop_.Stretched(
      [=, seed = shop_.NextSeed()] { return PaintCupboard(tone, 2, 1, seed); });
  shop_.builder.AddBox(at, {0, 0.01f, 0}, {1.0f, 0.6f, 2.05f},
                       {.sides = body, .front = front});
  for (const float x : {0.45f, 0.53f}) {
    shop_.builder.AddBox(at, {x, 0.6f, 0.95f}, {x + 0.02f, 0.63f, 1.1f},
                         {.sides = shop_.metal, .has_bottom = true});
  }
  const Finish card = shop_.Stretched(
      [seed = shop_.NextSeed()] { return PaintCardboard(seed); });
  shop_.builder.AddBox(at, {0.1f, 0.08f, 2.0505f}, {0.55f, 0.5f, 2.32f},
                       {.sides = card});
  things_.SmallThing(at.At({0.8f, 0.3f, 2.0505f}));
}

void HomeFurniture::Sofa(const Placement& at) {
  const float hue = shop_.Uniform(0, 1);
  const Float3 color =
      Hsv({hue, shop_.Uniform(0.2f, 0.6f), shop_.Uniform(0.35f, 0.7f)});
  const uint64_t seed = shop_.NextSeed();
  const Finish fabric = {.texture = shop_.builder.AddTexture(
                             [=] { return PaintFabric(color, seed); }),
                         .tile_m = 0.5f};
  shop_.builder.AddBox(at, {0, 0.03f, 0.08f}, {1.9f, 0.88f, 0.30f},
                       {.sides = fabric, .has_bottom = true});
  shop_.builder.AddBox(at, {0, 0.031f, 0.30f}, {0.2f, 0.879f, 0.62f},
                       {.sides = fabric});
  shop_.builder.AddBox(at, {1.7f, 0.031f, 0.30f}, {1.9f, 0.879f, 0.62f},
                       {.sides = fabric});
  shop_.builder.AddBox(at, {0.2f, 0.032f, 0.30f}, {1.7f, 0.25f, 0.86f},
                       {.sides = fabric});
  for (const float x : {0.205f, 0.955f}) {
    shop_.builder.AddBox(at, {x, 0.251f, 0.301f}, {x + 0.74f, 0.87f, 0.44f},
                         {.sides = fabric});
  }
  for (int i = 0; i < 3; ++i) {
    const float cushion_hue = hue + shop_.Uniform(0.2f, 0.8f);
    const uint64_t cushion_seed = shop_.NextSeed();
    const Finish cushion = shop_.Stretched(
        [=] { return PaintCushion(cushion_hue, cushion_seed); });
    const float x = 0.28f + 0.48f * static_cast<float>(i);
    shop_.builder.AddBox(
        at.At({x, 0.27f, 0.441f}, shop_.Uniform(-0.25f, 0.15f)), {0, 0, 0},
        {0.4f, 0.13f, 0.38f}, {.sides = cushion});
  }
}

void HomeFurniture::Chair(const Placement& at) {
  const Finish& wood =
      shop_.random.NextBelow(2) == 0 ? shop_.dark_wood : shop_.light_wood;
  const float hue = shop_.Uniform(0, 1);
  const Finish seat = shop_.Stretched(
      [=, seed = shop_.NextSeed()] { return PaintCushion(hue, seed); });
  shop_.TableLegs(at, {-0.21f, -0.21f, 0}, {0.21f, 0.21f, 0.42f}, 0.035f, wood);
  shop_.builder.AddBox(at, {-0.22f, -0.22f, 0.42f}, {0.22f, 0.22f, 0.46f},
                       {.sides = wood, .top = seat, .has_bottom = true});
  for (const float x : {-0.22f, 0.185f}) {
    shop_.builder.AddBox(at, {x, -0.22f, 0.4605f}, {x + 0.035f, -0.185f, 0.92f},
                         {.sides = wood});
  }
  for (int i = 0; i < 3; ++i) {
    const float z = 0.56f + 0.12f * static_cast<float>(i);
    shop_.builder.AddBox(at, {-0.184f, -0.215f, z},
                         {0.184f, -0.195f, z + 0.06f},
                         {.sides = wood, .has_bottom = true});
  }
}

void HomeFurniture::CoffeeTable(const Placement& at) {
  shop_.TableLegs(at, {-0.47f, -0.27f, 0}, {0.47f, 0.27f, 0.40f}, 0.05f,
                  shop_.dark_wood);
  shop_.builder.AddBox(at, {-0.5f, -0.3f, 0.40f}, {0.5f, 0.3f, 0.435f},
                       {.sides = shop_.dark_wood, .has_bottom = true});
  const float z = 0.4355f;
  for (int i = 0; i < 3; ++i) {
    const Finish title = shop_.Stretched(
        [seed = shop_.NextSeed()] { return PaintMagazine(seed); });
    const float x = -0.4f + 0.27f * static_cast<float>(i);
    const float y = shop_.Uniform(-0.2f, -0.05f);
    shop_.builder.AddBox(at.At({x, y, z}, shop_.Uniform(-0.4f, 0.4f)),
                         {0, 0, 0}, {0.21f, 0.28f, 0.006f},
                         {.sides = shop_.paper_edge, .top = title});
  }
  const ProfilePoint bowl[] = {{0.001f, 0.002f}, {0.06f, 0.004f},
                               {0.13f, 0.07f},   {0.12f, 0.07f},
                               {0.05f, 0.02f},   {0.001f, 0.018f}};
  shop_.builder.AddTurned(at, {0.33f, 0.1f, z}, bowl, 20,
                          shop_.Plain(Hsv({shop_.Uniform(0, 1), 0.5f, 0.7f})));
}

}  // namespace treeline::worlds

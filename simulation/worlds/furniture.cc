#include "simulation/worlds/furniture.h"

#include <cmath>

#include "simulation/worlds/paint.h"

namespace treeline::worlds {
namespace {

using ProfilePoint = WorldBuilder::ProfilePoint;

}  // namespace

FurnitureMaker::FurnitureMaker(WorldBuilder& builder, uint64_t seed)
    : builder_(builder), random_(seed, 0xf0) {
  const float warmth = Uniform(0.9f, 1.1f);
  dark_wood_ = Wood({0.40f * warmth, 0.25f, 0.16f});
  light_wood_ = Wood({0.78f * warmth, 0.62f, 0.43f});
  white_ = Plain({0.88f, 0.87f, 0.84f});
  black_ = Plain({0.13f, 0.13f, 0.14f});
  metal_ = Plain({0.62f, 0.63f, 0.66f});
  paper_edge_ = Plain({0.90f, 0.87f, 0.78f});
  spines_ = builder_.AddTexture(
      [texture_seed = NextSeed()] { return PaintBookSpines(texture_seed); });
  leaf_ = builder_.AddTexture(
      [texture_seed = NextSeed()] { return PaintLeaf(texture_seed); });
  next_picture_ = static_cast<int>(random_.NextBelow(6));
}

Finish FurnitureMaker::Wood(Float3 tone) {
  const uint64_t seed = NextSeed();
  return {.texture = builder_.AddTexture(
              [tone, seed] { return PaintWood(tone, seed); }),
          .tile_m = 0.8f};
}

Finish FurnitureMaker::Plain(Float3 color) {
  const uint64_t seed = NextSeed();
  return {.texture = builder_.AddTexture(
              [color, seed] { return PaintPlain(color, 0.12f, seed); }),
          .tile_m = 0.4f};
}

Finish FurnitureMaker::Stretched(std::function<Canvas()> paint,
                                 float emission) {
  return {.texture = builder_.AddTexture(std::move(paint)),
          .tile_m = 0,
          .emission = emission};
}

void FurnitureMaker::Books(const Placement& at, float x0, float x1,
                           float depth_m, float z_m, float space_m) {
  float x = x0 + 0.01f;
  while (x < x1 - 0.05f) {
    const float choice = Uniform(0, 1);
    if (choice < 0.05f) {  // a gap, or something else on the shelf
      if (x + 0.22f < x1 && space_m > 0.24f) {
        SmallThing(at.At({x + 0.11f, depth_m * 0.55f, z_m}));
      }
      x += 0.22f;
      continue;
    }
    const float thick = Uniform(0.018f, 0.055f);
    const float high = std::min(Uniform(0.17f, 0.31f), space_m - 0.02f);
    const float deep = std::min(Uniform(0.13f, 0.24f), depth_m - 0.02f);
    if (x + thick > x1) break;
    const int cell =
        static_cast<int>(random_.NextBelow(kSpineColumns * kSpineRows));
    const float u0 = static_cast<float>(cell % kSpineColumns) / kSpineColumns;
    const float v0 = static_cast<float>(cell / kSpineColumns) / kSpineRows;
    const Finish spine = {.texture = spines_,
                          .u0 = u0,
                          .v0 = v0,
                          .u1 = u0 + 1.0f / kSpineColumns,
                          .v1 = v0 + 1.0f / kSpineRows};
    // The sides show a plain strip of the spine.
    Finish cover = spine;
    cover.u1 = u0 + 0.25f / kSpineColumns;
    builder_.AddBox(at, {x, 0.02f, z_m}, {x + thick, 0.02f + deep, z_m + high},
                    {.sides = cover, .front = spine, .top = paper_edge_});
    x += thick + 0.001f;
  }
}

void FurnitureMaker::Bookcase(const Placement& at, float width_m) {
  constexpr float kDepth = 0.3f;
  constexpr float kHeight = 2.05f;
  constexpr float kBoard = 0.022f;
  constexpr int kShelves = 6;
  const Finish wood = random_.NextBelow(2) == 0 ? dark_wood_ : light_wood_;
  builder_.AddBox(at, {0, 0, 0}, {kBoard, kDepth, kHeight}, {.sides = wood});
  builder_.AddBox(at, {width_m - kBoard, 0, 0}, {width_m, kDepth, kHeight},
                  {.sides = wood});
  builder_.AddPanel(at, {width_m - kBoard, 0.012f, kHeight},
                    {-(width_m - 2 * kBoard), 0, 0}, {0, 0, -kHeight}, wood);
  const float pitch = (kHeight - kBoard - 0.08f) / kShelves;
  for (int i = 0; i <= kShelves; ++i) {
    const float z = 0.08f + pitch * static_cast<float>(i);
    builder_.AddBox(at, {kBoard, 0.013f, z - kBoard},
                    {width_m - kBoard, kDepth - 0.005f, z},
                    {.sides = wood, .has_bottom = true});
    if (i < kShelves) {
      Books(at, kBoard, width_m - kBoard, kDepth, z + 0.0005f, pitch - kBoard);
    }
  }
  for (float x = 0.18f; x < width_m - 0.15f; x += 0.33f) {
    SmallThing(at.At({x, 0.15f, kHeight + 0.0005f}));
  }
}

void FurnitureMaker::TableLegs(const Placement& at, Float3 low, Float3 high,
                               float thick_m, const Finish& finish) {
  for (const float x : {low.x, high.x - thick_m}) {
    for (const float y : {low.y, high.y - thick_m}) {
      builder_.AddBox(at, {x, y, low.z}, {x + thick_m, y + thick_m, high.z},
                      {.sides = finish});
    }
  }
}

void FurnitureMaker::Desk(const Placement& at) {
  constexpr float kTop = 0.74f;
  builder_.AddBox(at, {0, 0.02f, kTop - 0.03f}, {1.5f, 0.75f, kTop},
                  {.sides = light_wood_, .has_bottom = true});
  TableLegs(at, {0.03f, 0.05f, 0}, {1.47f, 0.72f, kTop - 0.03f}, 0.05f, metal_);
  const Finish drawers = Stretched([seed = NextSeed()] {
    return PaintCupboard({0.75f, 0.60f, 0.42f}, 1, 3, seed);
  });
  builder_.AddBox(at, {1.0f, 0.08f, 0.06f}, {1.4f, 0.68f, kTop - 0.04f},
                  {.sides = light_wood_, .front = drawers});
  for (int i = 0; i < 3; ++i) {
    const float z = 0.16f + 0.213f * static_cast<float>(i);
    builder_.AddBox(at, {1.15f, 0.68f, z}, {1.25f, 0.70f, z + 0.015f},
                    {.sides = black_, .has_bottom = true});
  }
  // Monitor, keyboard, pages, and what else there is.
  const float z = kTop + 0.0005f;
  const Finish screen =
      Stretched([seed = NextSeed()] { return PaintScreen(seed); }, 0.55f);
  builder_.AddBox(at, {0.58f, 0.16f, z}, {0.82f, 0.34f, z + 0.015f},
                  {.sides = black_});
  builder_.AddBox(at, {0.67f, 0.22f, z}, {0.73f, 0.25f, z + 0.16f},
                  {.sides = black_});
  builder_.AddBox(at, {0.40f, 0.25f, z + 0.12f}, {1.0f, 0.285f, z + 0.48f},
                  {.sides = black_, .has_bottom = true});
  builder_.AddPanel(at, {0.985f, 0.2855f, z + 0.465f}, {-0.57f, 0, 0},
                    {0, 0, -0.32f}, screen);
  const Finish keys =
      Stretched([seed = NextSeed()] { return PaintKeyboard(seed); });
  builder_.AddBox(at, {0.47f, 0.44f, z}, {0.92f, 0.58f, z + 0.02f},
                  {.sides = black_, .top = keys});
  for (int i = 0; i < 4; ++i) {
    const Finish page =
        Stretched([seed = NextSeed()] { return PaintPage(seed); });
    const float x = i < 2 ? Uniform(0.05f, 0.2f) : Uniform(1.05f, 1.2f);
    const float y = Uniform(0.34f, 0.42f);
    const float layer = z + 0.002f * static_cast<float>(i);
    builder_.AddPanel(at.At({x, y, 0}, Uniform(-0.3f, 0.3f)), {0.21f, 0, layer},
                      {-0.21f, 0, 0}, {0, 0.297f, 0}, page);
  }
  SmallThing(at.At({0.2f, 0.2f, z}));
  SmallThing(at.At({1.3f, 0.2f, z}));
  SmallThing(at.At({1.02f, 0.60f, z}));
}

void FurnitureMaker::Sideboard(const Placement& at, float width_m) {
  const float height = Uniform(0.72f, 0.9f);
  const Float3 tone = Hsv({Uniform(0.03f, 0.12f), 0.5f, Uniform(0.4f, 0.8f)});
  const int columns = static_cast<int>(width_m / 0.5f);
  const int rows = 1 + static_cast<int>(random_.NextBelow(3));
  const Finish body = Wood(tone);
  const Finish front = Stretched([=, seed = NextSeed()] {
    return PaintCupboard(tone, columns, rows, seed);
  });
  builder_.AddBox(at, {0.03f, 0.03f, 0}, {width_m - 0.03f, 0.40f, 0.07f},
                  {.sides = black_});
  builder_.AddBox(at, {0, 0.01f, 0.07f}, {width_m, 0.45f, height},
                  {.sides = body, .front = front});
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows; ++row) {
      const float x = width_m * (static_cast<float>(column) + 0.5f) /
                      static_cast<float>(columns);
      const float z = 0.07f + (height - 0.07f) *
                                  (static_cast<float>(row) + 0.8f) /
                                  static_cast<float>(rows);
      builder_.AddBox(at, {x - 0.05f, 0.45f, z - 0.006f},
                      {x + 0.05f, 0.475f, z + 0.006f},
                      {.sides = metal_, .has_bottom = true});
    }
  }
  for (float x = 0.2f; x < width_m - 0.15f; x += Uniform(0.3f, 0.45f)) {
    SmallThing(at.At({x, 0.22f, height + 0.0005f}, Uniform(-0.3f, 0.3f)));
  }
}

void FurnitureMaker::Wardrobe(const Placement& at) {
  const Float3 tone = Hsv({Uniform(0.05f, 0.1f), 0.45f, Uniform(0.55f, 0.8f)});
  const Finish body = Wood(tone);
  const Finish front = Stretched(
      [=, seed = NextSeed()] { return PaintCupboard(tone, 2, 1, seed); });
  builder_.AddBox(at, {0, 0.01f, 0}, {1.0f, 0.6f, 2.05f},
                  {.sides = body, .front = front});
  for (const float x : {0.45f, 0.53f}) {
    builder_.AddBox(at, {x, 0.6f, 0.95f}, {x + 0.02f, 0.63f, 1.1f},
                    {.sides = metal_, .has_bottom = true});
  }
  const Finish card =
      Stretched([seed = NextSeed()] { return PaintCardboard(seed); });
  builder_.AddBox(at, {0.1f, 0.08f, 2.0505f}, {0.55f, 0.5f, 2.32f},
                  {.sides = card});
  SmallThing(at.At({0.8f, 0.3f, 2.0505f}));
}

void FurnitureMaker::Sofa(const Placement& at) {
  const float hue = Uniform(0, 1);
  const Float3 color = Hsv({hue, Uniform(0.2f, 0.6f), Uniform(0.35f, 0.7f)});
  const uint64_t seed = NextSeed();
  const Finish fabric = {
      .texture = builder_.AddTexture([=] { return PaintFabric(color, seed); }),
      .tile_m = 0.5f};
  builder_.AddBox(at, {0, 0.03f, 0.08f}, {1.9f, 0.88f, 0.30f},
                  {.sides = fabric, .has_bottom = true});
  builder_.AddBox(at, {0, 0.031f, 0.30f}, {0.2f, 0.879f, 0.62f},
                  {.sides = fabric});
  builder_.AddBox(at, {1.7f, 0.031f, 0.30f}, {1.9f, 0.879f, 0.62f},
                  {.sides = fabric});
  builder_.AddBox(at, {0.2f, 0.032f, 0.30f}, {1.7f, 0.25f, 0.86f},
                  {.sides = fabric});
  for (const float x : {0.205f, 0.955f}) {
    builder_.AddBox(at, {x, 0.251f, 0.301f}, {x + 0.74f, 0.87f, 0.44f},
                    {.sides = fabric});
  }
  for (int i = 0; i < 3; ++i) {
    const float cushion_hue = hue + Uniform(0.2f, 0.8f);
    const uint64_t cushion_seed = NextSeed();
    const Finish cushion =
        Stretched([=] { return PaintCushion(cushion_hue, cushion_seed); });
    const float x = 0.28f + 0.48f * static_cast<float>(i);
    builder_.AddBox(at.At({x, 0.27f, 0.441f}, Uniform(-0.25f, 0.15f)),
                    {0, 0, 0}, {0.4f, 0.13f, 0.38f}, {.sides = cushion});
  }
}

void FurnitureMaker::Chair(const Placement& at) {
  const Finish& wood = random_.NextBelow(2) == 0 ? dark_wood_ : light_wood_;
  const float hue = Uniform(0, 1);
  const Finish seat =
      Stretched([=, seed = NextSeed()] { return PaintCushion(hue, seed); });
  TableLegs(at, {-0.21f, -0.21f, 0}, {0.21f, 0.21f, 0.42f}, 0.035f, wood);
  builder_.AddBox(at, {-0.22f, -0.22f, 0.42f}, {0.22f, 0.22f, 0.46f},
                  {.sides = wood, .top = seat, .has_bottom = true});
  for (const float x : {-0.22f, 0.185f}) {
    builder_.AddBox(at, {x, -0.22f, 0.4605f}, {x + 0.035f, -0.185f, 0.92f},
                    {.sides = wood});
  }
  for (int i = 0; i < 3; ++i) {
    const float z = 0.56f + 0.12f * static_cast<float>(i);
    builder_.AddBox(at, {-0.184f, -0.215f, z}, {0.184f, -0.195f, z + 0.06f},
                    {.sides = wood, .has_bottom = true});
  }
}

void FurnitureMaker::CoffeeTable(const Placement& at) {
  TableLegs(at, {-0.47f, -0.27f, 0}, {0.47f, 0.27f, 0.40f}, 0.05f, dark_wood_);
  builder_.AddBox(at, {-0.5f, -0.3f, 0.40f}, {0.5f, 0.3f, 0.435f},
                  {.sides = dark_wood_, .has_bottom = true});
  const float z = 0.4355f;
  for (int i = 0; i < 3; ++i) {
    const Finish title =
        Stretched([seed = NextSeed()] { return PaintMagazine(seed); });
    const float x = -0.4f + 0.27f * static_cast<float>(i);
    const float y = Uniform(-0.2f, -0.05f);
    builder_.AddBox(at.At({x, y, z}, Uniform(-0.4f, 0.4f)), {0, 0, 0},
                    {0.21f, 0.28f, 0.006f},
                    {.sides = paper_edge_, .top = title});
  }
  const ProfilePoint bowl[] = {{0.001f, 0.002f}, {0.06f, 0.004f},
                               {0.13f, 0.07f},   {0.12f, 0.07f},
                               {0.05f, 0.02f},   {0.001f, 0.018f}};
  builder_.AddTurned(at, {0.33f, 0.1f, z}, bowl, 20,
                     Plain(Hsv({Uniform(0, 1), 0.5f, 0.7f})));
}

}  // namespace treeline::worlds

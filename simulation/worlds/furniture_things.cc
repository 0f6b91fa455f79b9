#include "simulation/worlds/furniture_things.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/worlds/paint_fronts.h"
#include "simulation/worlds/paint_materials.h"
#include "simulation/worlds/paint_prints.h"

namespace treeline::worlds {
namespace {

using ProfilePoint = WorldBuilder::ProfilePoint;

constexpr float kPi = 3.14159265f;

}  // namespace

void SmallFurnishings::Books(const Placement& at, float x0, float x1,
                             float depth_m, float z_m, float space_m) {
  float x = x0 + 0.01f;
  while (x < x1 - 0.05f) {
    const float choice = shop_.Uniform(0, 1);
    if (choice < 0.05f) {  // a gap, or something else on the shelf
      if (x + 0.22f < x1 && space_m > 0.24f) {
        SmallThing(at.At({x + 0.11f, depth_m * 0.55f, z_m}));
      }
      x += 0.22f;
      continue;
    }
    const float thick = shop_.Uniform(0.018f, 0.055f);
    const float high = std::min(shop_.Uniform(0.17f, 0.31f), space_m - 0.02f);
    const float deep = std::min(shop_.Uniform(0.13f, 0.24f), depth_m - 0.02f);
    if (x + thick > x1) break;
    const int cell =
        static_cast<int>(shop_.random.NextBelow(kSpineColumns * kSpineRows));
    const float u0 = static_cast<float>(cell % kSpineColumns) / kSpineColumns;
    const float v0 = static_cast<float>(cell / kSpineColumns) / kSpineRows;
    const Finish spine = {.texture = shop_.spines,
                          .u0 = u0,
                          .v0 = v0,
                          .u1 = u0 + 1.0f / kSpineColumns,
                          .v1 = v0 + 1.0f / kSpineRows};
    // The sides show a plain strip of the spine.
    Finish cover = spine;
    cover.u1 = u0 + 0.25f / kSpineColumns;
    shop_.builder.AddBox(
        at, {x, 0.02f, z_m}, {x + thick, 0.02f + deep, z_m + high},
        {.sides = cover, .front = spine, .top = shop_.paper_edge});
    x += thick + 0.001f;
  }
}

void SmallFurnishings::FloorLamp(const Placement& at) {
  const Float3 middle = {0.2f, 0.2f, 0};
  const ProfilePoint foot[] = {
      {0.15f, 0}, {0.15f, 0.02f}, {0.014f, 0.03f}, {0.012f, 1.45f}};
  shop_.builder.AddTurned(at, middle, foot, 16, shop_.black);
  const Float3 color = Hsv({shop_.Uniform(0.08f, 0.14f), 0.35f, 0.95f});
  const uint64_t seed = shop_.NextSeed();
  const Finish shade =
      shop_.Stretched([=] { return PaintFabric(color, seed); }, 1.1f);
  shop_.builder.BeginLamp();
  const ProfilePoint cone[] = {{0.20f, 1.38f}, {0.13f, 1.66f}};
  shop_.builder.AddTurned(at, middle, cone, 24, shade);
  const Float3 corner = at.Point(middle + Float3{-0.08f, -0.08f, 1.37f});
  shop_.builder.AddLight({.corner = corner,
                          .edge_u = at.Direction({0.16f, 0, 0}),
                          .edge_v = at.Direction({0, 0.16f, 0}),
                          .radiance = {9, 7.2f, 5}});
  shop_.builder.EndLamp();
}

void SmallFurnishings::Plant(const Placement& at, float height_m,
                             float behind_m) {
  const float radius = 0.07f + 0.06f * height_m;
  const float pot_height = 0.14f + 0.12f * height_m;
  const Float3 middle = {0.2f, 0.2f, 0};
  const ProfilePoint pot[] = {{0.75f * radius, 0},
                              {radius, pot_height},
                              {0.88f * radius, pot_height},
                              {0.85f * radius, 0.9f * pot_height},
                              {0.001f, 0.9f * pot_height}};
  shop_.builder.AddTurned(
      at, middle, pot, 20,
      shop_.Plain(Hsv({shop_.Uniform(0.0f, 0.1f), 0.55f, 0.65f})));
  const int leaves = 30 + static_cast<int>(60 * height_m);
  const float crown = height_m - pot_height;
  for (int i = 0; i < leaves; ++i) {
    const float turn = shop_.Uniform(0, 2 * kPi);
    const float rise = shop_.Uniform(0, 1);
    const float slope = shop_.Uniform(-0.4f, 0.9f);
    const float length =
        (0.55f + 0.45f * height_m) * shop_.Uniform(0.18f, 0.36f);
    const float width = length * shop_.Uniform(0.3f, 0.5f);
    const Float3 out = {std::cos(turn), std::sin(turn), slope};
    const Float3 across = Normalized(
        Float3{-std::sin(turn), std::cos(turn), shop_.Uniform(-0.5f, 0.5f)});
    const Float3 root = middle + Float3{0.03f * out.x, 0.03f * out.y,
                                        pot_height + 0.85f * crown * rise};
    // A kite, as wide as it gets at two fifths of its length.
    const Float3 along = length * Normalized(out);
    const Float3 waist = root + 0.4f * along;
    const Float3 half = (0.5f * width) * across;
    std::array<Float3, 4> corners = {root, waist - half, root + along,
                                     waist + half};
    // Leaves that would grow into the wall behind, or beside, turn round.
    const auto any = [&](auto&& is_outside) {
      return std::any_of(corners.begin(), corners.end(), is_outside);
    };
    if (any([&](Float3 p) { return p.y < middle.y - behind_m; })) {
      for (Float3& p : corners) p.y = 2 * middle.y - p.y;
    }
    if (any([](Float3 p) { return p.x > 0.5f; })) {
      for (Float3& p : corners) p.x = 2 * middle.x - p.x;
    }
    shop_.builder.AddQuad(at, corners, {.texture = shop_.leaf});
  }
}

void SmallFurnishings::BoxStack(const Placement& at) {
  float z = 0;
  float width = shop_.Uniform(0.52f, 0.66f);
  for (int i = 0; i < 3; ++i) {
    const float depth = 0.72f * width;
    const float height = shop_.Uniform(0.26f, 0.40f);
    const auto face = [&] {
      return shop_.Stretched(
          [seed = shop_.NextSeed()] { return PaintCardboard(seed); });
    };
    const Finish sides = face();
    const Finish front = face();
    const Float3 corner = {shop_.Uniform(0.03f, 0.06f),
                           shop_.Uniform(0.05f, 0.08f), z};
    shop_.builder.AddBox(at.At(corner, shop_.Uniform(-0.06f, 0.06f)), {0, 0, 0},
                         {width, depth, height},
                         {.sides = sides, .front = front});
    z += height + 0.0005f;
    width *= shop_.Uniform(0.72f, 0.9f);
  }
}

void SmallFurnishings::Picture(const Placement& at, float width_m,
                               float height_m) {
  const Finish& frame =
      shop_.random.NextBelow(3) == 0
          ? shop_.black
          : (shop_.random.NextBelow(2) == 0 ? shop_.dark_wood
                                            : shop_.light_wood);
  const int kind = shop_.next_picture++;
  const Finish print = shop_.Stretched(
      [kind, seed = shop_.NextSeed()] { return PaintPicture(kind, seed); });
  const float bar = shop_.Uniform(0.018f, 0.04f);
  shop_.builder.AddBox(at, {0, 0.001f, height_m - bar},
                       {width_m, 0.028f, height_m},
                       {.sides = frame, .has_bottom = true});
  shop_.builder.AddBox(at, {0, 0.001f, 0}, {width_m, 0.028f, bar},
                       {.sides = frame, .has_bottom = true});
  for (const float x : {0.0f, width_m - bar}) {
    shop_.builder.AddBox(at, {x, 0.001f, bar},
                         {x + bar, 0.028f, height_m - bar}, {.sides = frame});
  }
  shop_.builder.AddPanel(at, {width_m - bar, 0.012f, height_m - bar},
                         {2 * bar - width_m, 0, 0}, {0, 0, 2 * bar - height_m},
                         print);
}

void SmallFurnishings::WallShelf(const Placement& at, float width_m) {
  shop_.builder.AddBox(at, {0, 0.001f, 0}, {width_m, 0.24f, 0.028f},
                       {.sides = shop_.light_wood, .has_bottom = true});
  for (const float x : {0.08f, width_m - 0.11f}) {
    shop_.builder.AddBox(at, {x, 0.001f, -0.13f}, {x + 0.03f, 0.03f, -0.0005f},
                         {.sides = shop_.metal, .has_bottom = true});
  }
  const float split = shop_.Uniform(0.35f, 0.6f) * width_m;
  Books(at, 0.03f, split, 0.24f, 0.0285f, 0.32f);
  for (float x = split + 0.12f; x < width_m - 0.08f;
       x += shop_.Uniform(0.2f, 0.3f)) {
    SmallThing(at.At({x, 0.12f, 0.0285f}));
  }
}

void SmallFurnishings::Clock(const Placement& at) {
  const Finish face =
      shop_.Stretched([seed = shop_.NextSeed()] { return PaintClock(seed); });
  shop_.builder.AddBox(
      at, {0, 0.001f, 0}, {0.32f, 0.035f, 0.32f},
      {.sides = shop_.dark_wood, .front = face, .has_bottom = true});
}

void SmallFurnishings::SmallThing(const Placement& at) {
  const Float3 color = Hsv({shop_.Uniform(0, 1), shop_.Uniform(0.25f, 0.8f),
                            shop_.Uniform(0.4f, 0.9f)});
  switch (shop_.random.NextBelow(7)) {
    case 0: {  // vase
      const float height = shop_.Uniform(0.14f, 0.24f);
      const float radius = shop_.Uniform(0.035f, 0.06f);
      const ProfilePoint vase[] = {{0.6f * radius, 0},
                                   {radius, 0.35f * height},
                                   {0.9f * radius, 0.6f * height},
                                   {0.4f * radius, 0.85f * height},
                                   {0.55f * radius, height}};
      shop_.builder.AddTurned(at, {0, 0, 0}, vase, 16, shop_.Plain(color));
      return;
    }
    case 1: {  // mug
      const ProfilePoint mug[] = {{0.038f, 0},
                                  {0.042f, 0.095f},
                                  {0.037f, 0.095f},
                                  {0.035f, 0.03f},
                                  {0.001f, 0.03f}};
      shop_.builder.AddTurned(at, {0, 0, 0}, mug, 16,
                              shop_.Stretched([color, seed = shop_.NextSeed()] {
                                Canvas canvas(64, 64, color);
                                canvas.Text(6, 60, 24, 14, {1, 1, 1}, seed);
                                return canvas;
                              }));
      return;
    }
    case 2: {  // photograph in a stand
      const Finish print = shop_.Stretched(
          [seed = shop_.NextSeed()] { return PaintPicture(0, seed); });
      shop_.builder.AddBox(at, {-0.075f, -0.01f, 0}, {0.075f, 0.01f, 0.2f},
                           {.sides = shop_.dark_wood});
      shop_.builder.AddPanel(at, {0.062f, 0.0105f, 0.187f}, {-0.124f, 0, 0},
                             {0, 0, -0.174f}, print);
      return;
    }
    case 3: {  // pile of books
      float z = 0;
      for (int i = 0; i < 4; ++i) {
        const float thick = shop_.Uniform(0.02f, 0.045f);
        const Finish title = shop_.Stretched(
            [seed = shop_.NextSeed()] { return PaintMagazine(seed); });
        shop_.builder.AddBox(at.At({0, 0, z}, shop_.Uniform(-0.4f, 0.4f)),
                             {-0.08f, -0.07f, 0}, {0.08f, 0.07f, thick},
                             {.sides = title, .top = title});
        z += thick + 0.0005f;
      }
      return;
    }
    case 4: {  // box of something
      const Finish print = shop_.Stretched(
          [seed = shop_.NextSeed()] { return PaintMagazine(seed); });
      const float width = shop_.Uniform(0.05f, 0.09f);
      shop_.builder.AddBox(at, {-width, -0.05f, 0},
                           {width, 0.05f, shop_.Uniform(0.1f, 0.22f)},
                           {.sides = print});
      return;
    }
    case 5:  // small plant
      Plant(at.At({-0.2f, -0.2f, 0}), 0.32f, 0.1f);
      return;
    default: {  // radio
      const Finish front = shop_.Stretched([color, seed = shop_.NextSeed()] {
        Canvas canvas(128, 64, color);
        canvas.Disc(34, 32, 24, {0.15f, 0.15f, 0.15f});
        canvas.Disc(34, 32, 12, {0.4f, 0.4f, 0.4f});
        canvas.Rect(66, 8, 122, 30, {0.9f, 0.85f, 0.6f});
        canvas.Text(68, 120, 14, 10, {0.2f, 0.1f, 0.1f}, seed);
        canvas.Disc(80, 46, 8, {0.9f, 0.9f, 0.9f});
        canvas.Disc(108, 46, 8, {0.9f, 0.9f, 0.9f});
        return canvas;
      });
      shop_.builder.AddBox(at, {-0.12f, -0.05f, 0}, {0.12f, 0.05f, 0.13f},
                           {.sides = shop_.dark_wood, .front = front});
    }
  }
}

}  // namespace treeline::worlds

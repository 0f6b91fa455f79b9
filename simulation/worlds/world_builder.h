// Puts a World together from boxes, panels and turned pieces.
#ifndef SIMULATION_WORLDS_WORLD_BUILDER_H_
#define SIMULATION_WORLDS_WORLD_BUILDER_H_

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "simulation/worlds/placement.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {

// What a surface looks like.
struct Finish {
  int texture = 0;
  // Side of the picture on the surface (m); 0: stretched over the surface.
  float tile_m = 0;
  float emission = 0;
  // The part of a stretched picture that is shown.
  float u0 = 0;
  float v0 = 0;
  float u1 = 1;
  float v1 = 1;
};

class WorldBuilder {
 public:
  // Registers a picture; Build paints it.
  int AddTexture(std::function<Canvas()> paint);

  // A flat rectangle: `top_left` as seen from the front, with the edges to the
  // right and downwards. All in the frame of `placement`.
  void AddPanel(const Placement& placement, Float3 top_left, Float3 right,
                Float3 down, const Finish& finish);

  // Any flat quadrilateral; see Surface for the order of its corners.
  void AddQuad(const Placement& placement, const std::array<Float3, 4>& corners,
               const Finish& finish);

  // A box from `low` to `high` without a bottom. Faces other than the front
  // (towards +y) and the top show `sides`.
  struct BoxFinish {
    Finish sides;
    std::optional<Finish> front{};
    std::optional<Finish> top{};
    bool has_bottom = false;
  };
  void AddBox(const Placement& placement, Float3 low, Float3 high,
              const BoxFinish& finish);

  // A piece turned about the vertical through `base`: through the profile's
  // (radius, height) points from bottom to top.
  struct ProfilePoint {
    float radius_m = 0;
    float height_m = 0;
  };
  void AddTurned(const Placement& placement, Float3 base,
                 std::span<const ProfilePoint> profile, int segments,
                 const Finish& finish);

  // What surfaces with an emission, and lights, from here to EndLamp are of.
  void BeginLamp() { source_ = next_lamp_++; }
  void EndLamp() { source_ = kNoLamp; }
  void AddLight(AreaLight light);

  // What is seen through a window: a panel on a wall, 4 mm before it, and the
  // light of the sky that it lets in. As AddPanel.
  void AddView(const Placement& wall, Float3 top_left, Float3 right,
               Float3 down, Float3 sky_radiance, const Finish& finish);

  // Surfaces and lights from here to EndPiece are something that could stand
  // elsewhere. Not within a body or a group.
  void BeginPiece();
  void EndPiece();

  // What surfaces are from here on; kOther at first.
  void set_kind(SurfaceKind kind) { kind_ = kind; }

  // Surfaces from here to EndBody belong to a body that can move, and are
  // placed in its frame (see Body). Bodies cannot be nested.
  void BeginBody();
  // Returns the body's index.
  int EndBody(std::string name, float radius_m, float height_m,
              std::optional<Motion> motion);

  // Surfaces and lights from here to EndGroup are a piece of their own, which
  // AddGroup puts anywhere, any number of times; lamps are another one each
  // time. Not within a body.
  struct Group {
    std::vector<Surface> surfaces;
    std::vector<AreaLight> lights;
  };
  void BeginGroup();
  Group EndGroup();
  void AddGroup(const Group& group, const Placement& placement);

  size_t surface_count() const { return surfaces_.size(); }

  // Without paint, every picture is one grey texel: for who needs no more than
  // the geometry.
  void set_paint(bool paint) { paint_ = paint; }

  // Paints the textures, in parallel, and hands over the world, which has
  // neither places nor a tour yet.
  World Build(std::string name, Float3 size_m, const WalkArea& walk_area,
              int threads);

 private:
  void AddSurface(const std::array<Float3, 4>& corners, const Finish& finish);

  std::vector<std::function<Canvas()>> painters_;
  std::vector<Surface> surfaces_;
  std::vector<AreaLight> lights_;
  std::vector<Body> bodies_;
  SurfaceKind kind_ = SurfaceKind::kOther;
  // While a body is being built: where its surfaces begin.
  std::optional<size_t> body_begin_;
  // While a group is being built: where its surfaces and lights begin.
  size_t group_begin_ = 0;
  size_t group_lights_begin_ = 0;
  int source_ = kNoLamp;
  int next_lamp_ = 0;
  std::vector<Piece> pieces_;
  bool paint_ = true;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_WORLD_BUILDER_H_

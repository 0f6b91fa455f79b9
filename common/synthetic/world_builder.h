// Puts a World together from boxes, panels and turned pieces.
#ifndef COMMON_SYNTHETIC_WORLD_BUILDER_H_
#define COMMON_SYNTHETIC_WORLD_BUILDER_H_

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/synthetic/world.h"

namespace treeline {

// Where a piece stands in the world: it is turned by yaw about z, then moved.
// In its own frame a piece of furniture has x along the wall, y out of the
// wall into the room, and z up, and its back left corner (seen from above,
// looking along y) at the origin.
struct Placement {
  Float3 origin;
  float yaw_rad = 0;

  Float3 Direction(Float3 local) const;
  Float3 Point(Float3 local) const { return origin + Direction(local); }
  // The placement of something that stands at `local` within this one.
  Placement At(Float3 local, float turn_rad = 0) const {
    return {Point(local), yaw_rad + turn_rad};
  }
};

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

  void AddLight(const AreaLight& light) { lights_.push_back(light); }

  // Paints the textures, in parallel, and hands over the world.
  World Build(std::string name, Float3 size_m, const WalkArea& walk_area,
              int threads);

 private:
  void AddSurface(const std::array<Float3, 4>& corners, const Finish& finish);

  std::vector<std::function<Canvas()>> painters_;
  std::vector<Surface> surfaces_;
  std::vector<AreaLight> lights_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_WORLD_BUILDER_H_

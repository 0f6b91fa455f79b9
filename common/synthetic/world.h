// A synthetic place: textured surfaces and lights. World frame: z up, metres,
// the floor at z = 0, x and y from a corner along the walls.
#ifndef COMMON_SYNTHETIC_WORLD_H_
#define COMMON_SYNTHETIC_WORLD_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/synthetic/float3.h"
#include "common/synthetic/texture.h"

namespace treeline {

// A planar quadrilateral. Its corners, seen from the front: top left, top
// right, bottom right, bottom left. (u, v) is (0, 0), (1, 0), (1, 1), (0, 1)
// there.
struct Surface {
  std::array<Float3, 4> corners;
  int texture = 0;
  // Texture coordinates are affine in (u, v):
  //   texture_origin + u * texture_u + v * texture_v.
  std::array<float, 2> texture_origin{0, 0};
  std::array<float, 2> texture_u{1, 0};
  std::array<float, 2> texture_v{0, 1};
  // Light that leaves the surface, as a multiple of its reflectance: lamp
  // shades, windows, screens. 0 for others.
  float emission = 0;

  Float3 Normal() const {
    return Normalized(Cross(corners[3] - corners[0], corners[1] - corners[0]));
  }
  Float3 PointAt(float u, float v) const {
    return Mix(Mix(corners[0], corners[1], u), Mix(corners[3], corners[2], u),
               v);
  }
  float LengthU() const {
    return 0.5f *
           (Norm(corners[1] - corners[0]) + Norm(corners[2] - corners[3]));
  }
  float LengthV() const {
    return 0.5f *
           (Norm(corners[3] - corners[0]) + Norm(corners[2] - corners[1]));
  }
};

// A parallelogram that shines to the side that its Surface-like normal points
// to: lamps and windows. Invisible itself; a Surface with emission shows it.
struct AreaLight {
  Float3 corner;
  Float3 edge_u;
  Float3 edge_v;
  Float3 radiance;  // linear; a white wall in full light is about 1

  // Not of unit length: its length is the area (m^2).
  Float3 AreaNormal() const { return Cross(edge_v, edge_u); }
};

// Where somebody can walk about with a camera: an ellipse, seen from above.
struct WalkArea {
  double center_x_m = 0;
  double center_y_m = 0;
  double half_x_m = 0;
  double half_y_m = 0;
};

struct World {
  std::string name;
  Float3 size_m;
  std::vector<Texture> textures;
  std::vector<Surface> surfaces;
  std::vector<AreaLight> lights;
  WalkArea walk_area;
};

// "room": a furnished living room with a desk; "seed:N" for a whole number N:
// a room of the same kind with other measures, furniture and pictures.
// INVALID_ARGUMENT for other names. Paints on up to `threads` threads; the
// result does not depend on how many.
absl::StatusOr<World> MakeWorld(absl::string_view name, int threads);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_WORLD_H_

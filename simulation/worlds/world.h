// A synthetic place: textured surfaces and lights. World frame: z up, metres,
// the floor at z = 0, x and y from a corner along the walls.
#ifndef SIMULATION_WORLDS_WORLD_H_
#define SIMULATION_WORLDS_WORLD_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "simulation/building/lighting.h"
#include "simulation/worlds/float3.h"
#include "simulation/worlds/placement.h"
#include "simulation/worlds/texture.h"

namespace treeline::worlds {

// What a surface is for those who drive, and for sensors.
enum class SurfaceKind : uint8_t {
  kOther,  // furniture, people, what lies about
  kWall,
  kCeiling,
  kFloor,  // level ground, platforms included
  kRamp,   // ground that rises
  kStair,
  // Cameras and light go through; see RayCaster::CastGlass.
  kGlass
};

// What light comes from: a lamp, by its number from 0, or one of these.
inline constexpr int kNoLamp = -1;  // screens, for instance
inline constexpr int kSky = -2;     // what is seen in a window

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
  Float3 emission{};
  // What the emission comes from.
  int source = kNoLamp;
  // The share of the light on it that the reflectance is applied to: less than
  // 1 of windows when it is dark outside.
  float reflection = 1;
  SurfaceKind kind = SurfaceKind::kOther;

  // What leaves the surface, as a multiple of its reflectance, where `light`
  // falls on it.
  Float3 Leaving(Float3 light) const { return reflection * light + emission; }

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
  int source = kNoLamp;

  // Not of unit length: its length is the area (m^2).
  Float3 AreaNormal() const { return Cross(edge_v, edge_u); }
};

// The light of the sky in a window shines from so far before its view, which is
// on the wall: not through the window's bars.
inline constexpr float kSkyBeforeView_m = 0.041f;
// By day; linear, as AreaLight::radiance.
inline constexpr Float3 kSkyRadiance = {1.5f, 1.75f, 2.1f};

// The sun through a window: where a ray towards the sun meets this
// parallelogram and nothing before.
struct Sunbeam {
  Float3 corner;
  Float3 edge_u;
  Float3 edge_v;
  Float3 to_sun;    // of unit length
  Float3 radiance;  // of a white surface that faces the sun
};

// Something that stands on the floor and could stand elsewhere: its surfaces
// among the world's, and its lights among those of all lamps (some of which
// are not there once a world is relit).
struct Piece {
  size_t first_surface = 0;
  size_t surface_count = 0;
  size_t first_light = 0;
  size_t light_count = 0;
};

// Where somebody can walk about with a camera: an ellipse, seen from above.
struct WalkArea {
  double center_x_m = 0;
  double center_y_m = 0;
  double half_x_m = 0;
  double half_y_m = 0;
};

// Something that moves as a whole: a person, a cart, the leaf of a door.
struct Body {
  std::string name;
  // In the body's frame: z up, the origin on the ground below its middle, or at
  // the hinge of a door.
  std::vector<Surface> surfaces;
  // The upright cylinder about the frame's z axis that holds it.
  float radius_m = 0;
  float height_m = 0;
  // Where it is when; nullopt: nowhere, unless somebody puts it there, any
  // number of times (a crate that blocks the way).
  std::optional<Motion> motion;
};

// A body at one place at one moment.
struct BodyInstance {
  int body = 0;  // among World::bodies
  Placement world_from_body;
  // Factors on the body's measures, along its axes. Positive.
  Float3 scale{1, 1, 1};
};

// A place on the ground that has a name: where a robot starts, or may be sent.
struct NamedPlace {
  std::string name;
  Placement placement;
};

struct World {
  std::string name;
  Float3 size_m;
  std::vector<Texture> textures;
  // What never moves.
  std::vector<Surface> surfaces;
  std::vector<AreaLight> lights;
  std::vector<Sunbeam> sunbeams;
  building::Lighting lighting = building::Lighting::kDay;
  std::vector<Piece> pieces;
  std::vector<Body> bodies;
  // Where somebody stands and looks around, in a room; half_x_m is 0 where
  // there is a tour instead.
  WalkArea walk_area;
  // A closed way over the ground that comes by everything, wide enough for a
  // robot: corners, in order.
  std::vector<Float3> tour;
  std::vector<NamedPlace> places;
  // Closed ways that people and carts take, whether they are about or not.
  std::vector<std::vector<Float3>> ways;

  // Bodies that have a motion, where they are at this time.
  std::vector<BodyInstance> InstancesAt(double time_s) const;
};

// Of what can be moved, a share is missing or stands elsewhere.
struct Rearrangement {
  uint64_t seed = 0;
  double share = 0;  // in [0, 1]

  bool operator==(const Rearrangement&) const = default;
};

// Which state of a world is wanted.
struct WorldOptions {
  // Whether objects that the world's file moves after mapping have been moved.
  bool after_moves = false;
  // See Rearrange. What is fixed, and what things look like, stays.
  Rearrangement rearranged{};
  // See Relight; nullopt: that of the world's file, or day.
  std::optional<building::Lighting> lighting{};
  // Whether people and carts are about.
  bool with_people = true;
  // Paints on up to so many; < 1: all. The result does not depend on it.
  int threads = 0;
  // Whether surfaces get their pictures. false: one grey texel each, for who
  // needs no more than the geometry.
  bool paint = true;
};

// The world called `name`:
//   room          a furnished living room with a desk
//   room:N        a room of the same kind, with other measures, furniture and
//                 pictures, for each whole number N
//   cafe, lab, office-floor, two-storey
//                 buildings that every program carries (worlds/*.yaml)
//   seed:N, field:N, moving-field:N
//                 a generated building; a field of cylinders, of moving ones
//   office:M2, office:M2:N  an office building of so many square metres
//   FILE          a world file of your own: ends in .yaml or contains a '/';
//                 see docs/reference/world-files.md. Or a world of Gazebo
//                 (IsGazeboWorld): building/gazebo_plan.h
// INVALID_ARGUMENT for other names, and for files with mistakes, "FILE:LINE:
// reason"; NOT_FOUND and so on for files that cannot be read.
absl::StatusOr<World> MakeWorld(absl::string_view name,
                                const WorldOptions& options);

// Whether the name is that of a file of Gazebo's: ends in .world or .sdf.
bool IsGazeboWorld(absl::string_view name);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_WORLD_H_

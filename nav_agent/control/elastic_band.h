// Elastic bands (Quinlan and Khatib, "Elastic Bands: Connecting Path Planning
// and Control", ICRA 1993; thesis 6.5.1): a path as bubbles of free space that
// contracts and is pushed away by what stands beside it.
#ifndef NAV_AGENT_CONTROL_ELASTIC_BAND_H_
#define NAV_AGENT_CONTROL_ELASTIC_BAND_H_

#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/setting_parameters.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// A place on the band: where the robot stands there, and by how much its
// footprint may be moved in any direction without touching anything (m).
struct BandBubble {
  geometry::Rigid2 map_from_base;
  double radius_m = 0;
};

// What bubbles are made of.
class BandSpace {
 public:
  virtual ~BandSpace() = default;
  // The free distance of the footprint at this pose, at most max_distance_m;
  // negative where it touches something, and where nothing is known (m).
  virtual double FreeDistance_m(const geometry::Rigid2& map_from_base,
                                double max_distance_m) const = 0;
  // Unit vector from the nearest obstacle; 0 if there is none.
  virtual geometry::Vec2 Away(geometry::Vec2 point_in_map) const = 0;
};

struct ElasticBandOptions {
  // rho_0: obstacles further from the footprint do not push (m).
  double influence_m = kInflation_m;
  // k_r / k_c (1/m).
  double repulsion = kRepulsion;
  // A bubble moves by this times its radius times the force in one go, at most
  // max_move_m.
  double gain = kBandGain;
  double max_move_m = kCell_m;
  // Neighbours at most this far apart, half of a robot's length, and at least
  // (m).
  double max_spacing_m = core::RobotModel().front_m;
  double min_spacing_m = kTwoCells_m;
  // What a turn between neighbours takes of their room (m of way for 1 rad).
  double turn_m_per_rad = kTurnWay;
  int iterations = kBandIterations;
  int max_bubbles = kMaxBubbles;

  absl::Status Validate() const;
};

// With bubbles b_i of radius rho_i and headings along the band:
//
//   f_c = ((b_(i-1) - b_i) / |b_(i-1) - b_i| + (b_(i+1) - b_i) / |...|)
//   f_r = k_r / k_c (rho_0 - rho) d rho / d b  while rho < rho_0
//   f   = f_c + f_r, without its part along b_(i+1) - b_(i-1)
//   b_i += gain rho_i f
//
// The first and the last stay where they are. Neighbours hang together if their
// distance is less than the sum of their radii. Not thread-safe.
class ElasticBand {
 public:
  explicit ElasticBand(const ElasticBandOptions& options) : options_(options) {}

  const std::vector<BandBubble>& bubbles() const { return bubbles_; }
  bool is_empty() const { return bubbles_.empty(); }
  void Clear() { bubbles_.clear(); }
  // A new band through these points; headings follow from them but for the
  // first and the last.
  void Set(const std::vector<geometry::Rigid2>& map_from_base);
  // The band begins at the robot: what lies behind it is cut off. How far the
  // robot was from it (m).
  double BeginAt(const geometry::Rigid2& map_from_base);
  // One more at the end, which becomes free to move with that.
  void Append(const geometry::Rigid2& map_from_base);

  // Some iterations in this space, with filling of gaps and thinning out.
  void Relax(const BandSpace& space);
  // The first bubble that touches something or does not hang together with the
  // one before it; nullopt: the band is whole.
  std::optional<size_t> FirstBreak(const BandSpace& space) const;

 private:
  void SetHeadings();
  void Measure(const BandSpace& space, BandBubble& bubble) const;
  geometry::Vec2 ForceOn(size_t i, const BandSpace& space) const;
  void MoveBubbles(const BandSpace& space);
  void FillAndThin(const BandSpace& space);
  double WayBetween_m(const BandBubble& a, const BandBubble& b) const;
  bool HangTogether(const BandBubble& a, const BandBubble& b,
                    const BandSpace& space) const;

  ElasticBandOptions options_;
  std::vector<BandBubble> bubbles_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ELASTIC_BAND_H_

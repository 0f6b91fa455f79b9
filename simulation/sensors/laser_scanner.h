// A planar laser scanner of the UTM-30LX's kind in a synthetic world.
#ifndef SIMULATION_SENSORS_LASER_SCANNER_H_
#define SIMULATION_SENSORS_LASER_SCANNER_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "simulation/renderer/hit_normals.h"
#include "simulation/renderer/ray_caster.h"

namespace treeline::sensors {

// Defaults: Hokuyo UTM-30LX (data sheet C-42-3615): 1081 beams over 270
// degrees, 40 Hz, a mirror that turns once in 25 ms, sigma < 10 mm up to 10 m
// and < 30 mm up to 30 m. docs/reference/synthetic-sensors.md has the model.
struct LaserScannerOptions {
  int beams = 1081;  // [2, 100000]
  // Of the first beam, and from one to the next, counter-clockwise in the
  // scanner's frame (x forward, y left).
  double angle_min_rad = -2.35619449019;
  double angle_increment_rad = 0.00436332313;
  // From one beam to the next, and from a scan's first to the next scan's.
  double beam_interval_s = 0.025 / 1440;
  double scan_interval_s = 0.025;
  double range_min_m = 0.1;
  double range_max_m = 30;
  // Standard deviation of a range: base + per_m * range.
  double noise_base_m = 0.006;
  double noise_per_m = 0.0004;
  // Ranges are whole multiples of this; 0: any number.
  double range_step_m = 0.001;
  // Beams that come back without a range by chance, and those that meet a
  // surface at less than grazing_deg.
  double random_loss = 0.001;
  double grazing_deg = 3;
  // The share of beams that a pane of glass returns when it is met at right
  // angles; it falls evenly to none at glass_angle_deg from that. Other beams
  // go through and come back from what is behind. 0 deg: no pane returns any.
  double glass_return = 0.7;
  double glass_angle_deg = 12;

  // INVALID_ARGUMENT with the name of what is out of range.
  absl::Status Validate() const;
};

// One scan, in order of the beams. Ranges in m, by REP 117: +infinity where
// nothing came back, -infinity for what is too near. Intensities, in arbitrary
// units up to 4000, fall with range, slant and darkness; 0 without a range.
struct LaserReturns {
  std::vector<float> ranges_m;
  std::vector<uint16_t> intensities;
};

// Immutable and thread-safe.
class LaserScanner {
 public:
  // Copies what it needs of `world`, which must be the one that snapshots are
  // of. INVALID_ARGUMENT for options out of range.
  static absl::StatusOr<LaserScanner> Create(const worlds::World& world,
                                             const LaserScannerOptions& options,
                                             uint64_t seed);

  const LaserScannerOptions& options() const { return options_; }

  // One scan, whose first beam leaves with the scanner at the first pose, and
  // its last with it at the second (a scanner that moves sees a skewed world;
  // in between it moves evenly). Bodies stand still meanwhile. `scan` numbers
  // the scans: (seed, scan) determine the noise.
  LaserReturns Scan(const renderer::WorldSnapshot& snapshot,
                    const geometry::Rigid3& world_from_laser_at_first,
                    const geometry::Rigid3& world_from_laser_at_last,
                    uint64_t scan) const;

 private:
  // One beam's chances, drawn whether they are needed or not: what one beam
  // meets does not change the noise of the next.
  struct Chances {
    float normal = 0;
    float loss = 0;
    float glass = 0;
  };
  struct Echo {
    float range_m = 0;
    float intensity = 0;
  };

  LaserScanner(const worlds::World& world, const LaserScannerOptions& options,
               uint64_t seed);
  bool ReturnsFromGlass(const renderer::WorldSnapshot& snapshot,
                        const renderer::RayHit& solid,
                        const renderer::RayHit& pane, worlds::Float3 direction,
                        const Chances& chances) const;
  Echo Measure(const renderer::WorldSnapshot& snapshot,
               const renderer::RayHit& hit, worlds::Float3 direction,
               const Chances& chances) const;

  LaserScannerOptions options_;
  uint64_t seed_;
  renderer::HitNormals normals_;
  // Mean reflectance of each surface; then of each body's.
  std::vector<float> reflectances_;
  std::vector<std::vector<float>> body_reflectances_;
  // Of each beam, in the scanner's frame (z is 0).
  std::vector<worlds::Float3> directions_;
};

}  // namespace treeline::sensors

#endif  // SIMULATION_SENSORS_LASER_SCANNER_H_

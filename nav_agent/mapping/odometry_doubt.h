// How far odometry may be trusted: told, or learned from how scans match.
#ifndef NAV_AGENT_MAPPING_ODOMETRY_DOUBT_H_
#define NAV_AGENT_MAPPING_ODOMETRY_DOUBT_H_

#include <cstddef>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/odometry_noise.h"

namespace treeline::mapping {

// How wrong odometry may be, one standard deviation: at rest, per metre and
// per radian; what matching searches is search_sigmas of it, but at least
// min_search, and at most what LaserSlamOptions say. Defaults suit wheels alone
// that tell their turns too.
struct OdometryNoise {
  double m = 0.02;
  double m_per_m = 0.10;
  double m_per_rad = 0.03;
  double rad = 0.01;
  double rad_per_rad = 0.15;
  double rad_per_m = 0.05;
  double min_search_m = 0;
  double min_search_rad = 0;
  // Whether all of it is scaled by what is learned from the matches, and by
  // how much as long as nothing is known (1 or more). Never below 1: what is
  // given is the least.
  bool is_estimated = true;
  double initial_scale = 3;

  // Of wheels with a gyroscope, read every few centimetres. More noise does
  // harm: between parallel walls a scan fits best a little behind of where it
  // was taken, since ahead it shows what the window has not seen.
  static OdometryNoise WithGyroscope() {
    return {.m = 0.003,
            .m_per_m = 0.02,
            .m_per_rad = 0.004,
            .rad = 0.002,
            .rad_per_rad = 0.02,
            .rad_per_m = 0.01,
            .min_search_m = 0.08,
            .min_search_rad = 0.02,
            .is_estimated = false,
            .initial_scale = 1};
  }

  // `usual`, and for a way and a turn at least kNoiseMargin of what was
  // measured of this robot: one whose wheels slip more is believed less. Not
  // less than usual, as then matching would decide nothing.
  static OdometryNoise AtLeast(const OdometryNoise& usual,
                               const core::MeasuredOdometryNoise& measured);
};

// Learns the scale of OdometryNoise from innovations: what matching a scan adds
// to odometry's prediction, in standard deviations of the noise as given. The
// scale is such that the middle two thirds of the recent ones are within one
// standard deviation, and all but a few per cent within what is searched;
// single ones, wheels that slipped or matches that were wrong, change little.
class OdometryDoubt {
 public:
  OdometryDoubt(const OdometryNoise& noise, double search_sigmas);

  struct Sigma {
    double m = 0;
    double rad = 0;
  };
  // Of a motion by odometry: what is assumed, and how far is to be searched.
  Sigma SigmaOf(const geometry::Rigid2& motion) const;
  Sigma SearchOf(const geometry::Rigid2& motion) const;

  // A scan has matched after `motion` at `innovation` from the prediction.
  void Learn(const geometry::Rigid2& motion,
             const geometry::Rigid2& innovation);

  // Of the noise as given.
  double scale_m() const { return m_.scale; }
  double scale_rad() const { return rad_.scale; }

 private:
  // Of one kind of error.
  struct Channel {
    std::vector<double> recent;  // |innovation| / sigma as given, a ring
    size_t next = 0;
    double scale = 1;
    double search = 3;  // in sigmas as given

    void Update(double search_sigmas);
  };
  Sigma AsGiven(const geometry::Rigid2& motion) const;

  OdometryNoise noise_;
  double search_sigmas_;
  Channel m_;
  Channel rad_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_ODOMETRY_DOUBT_H_

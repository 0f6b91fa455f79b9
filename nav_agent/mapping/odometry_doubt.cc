#include "nav_agent/mapping/odometry_doubt.h"

#include <algorithm>
#include <cmath>

#include "common/base/sample_statistics.h"

namespace treeline::mapping {
namespace {

// Innovations that are remembered. At first they are all as initial_scale says.
constexpr size_t kRemembered = 100;
// Within one standard deviation of a Gaussian; in what is searched.
constexpr double kOneSigma = 0.68;
constexpr double kSearched = 0.96;
// What lies beyond the quantile of what is searched.
constexpr double kSearchMargin = 1.5;
// Odometry that is worse than this says nothing (times the noise as given).
constexpr double kMaxScale = 12;

// Stretches of the measurement are longer than what lies between two matches,
// and those on which wheels slipped were left out.
constexpr double kNoiseMargin = 2;

}  // namespace

OdometryNoise OdometryNoise::AtLeast(
    const OdometryNoise& usual, const core::MeasuredOdometryNoise& measured) {
  const auto larger = [](double share, double measured_share) {
    return std::max(share, kNoiseMargin * measured_share);
  };
  OdometryNoise noise = usual;
  noise.m_per_m = larger(usual.m_per_m, measured.drive_from_drive);
  noise.m_per_rad = larger(usual.m_per_rad, measured.drive_from_turn);
  noise.rad_per_rad = larger(usual.rad_per_rad, measured.turn_from_turn);
  noise.rad_per_m = larger(usual.rad_per_m, measured.turn_from_drive);
  return noise;
}

OdometryDoubt::OdometryDoubt(const OdometryNoise& noise, double search_sigmas)
    : noise_(noise), search_sigmas_(search_sigmas) {
  for (Channel* channel : {&m_, &rad_}) {
    // Quantiles of a half normal distribution: a first guess that fades.
    for (size_t i = 0; i < kRemembered; ++i) {
      const double part = (static_cast<double>(i) + 0.5) / kRemembered;
      channel->recent.push_back(noise.initial_scale * 1.25 * part *
                                (1 + part * part * part * part));
    }
    channel->Update(search_sigmas);
    if (!noise.is_estimated) {
      channel->scale = 1;
      channel->search = search_sigmas;
    }
  }
}

void OdometryDoubt::Channel::Update(double search_sigmas) {
  scale = std::clamp(base::Quantile(recent, kOneSigma), 1.0, kMaxScale);
  search = std::max(search_sigmas * scale,
                    kSearchMargin * base::Quantile(recent, kSearched));
}

OdometryDoubt::Sigma OdometryDoubt::AsGiven(
    const geometry::Rigid2& motion) const {
  const double moved_m = geometry::Norm(motion.translation);
  const double turned_rad = std::abs(motion.yaw_rad);
  return {
      .m = noise_.m + noise_.m_per_m * moved_m + noise_.m_per_rad * turned_rad,
      .rad = noise_.rad + noise_.rad_per_rad * turned_rad +
             noise_.rad_per_m * moved_m};
}

OdometryDoubt::Sigma OdometryDoubt::SigmaOf(
    const geometry::Rigid2& motion) const {
  const Sigma given = AsGiven(motion);
  return {.m = m_.scale * given.m, .rad = rad_.scale * given.rad};
}

OdometryDoubt::Sigma OdometryDoubt::SearchOf(
    const geometry::Rigid2& motion) const {
  const Sigma given = AsGiven(motion);
  return {.m = std::max(m_.search * given.m, noise_.min_search_m),
          .rad = std::max(rad_.search * given.rad, noise_.min_search_rad)};
}

void OdometryDoubt::Learn(const geometry::Rigid2& motion,
                          const geometry::Rigid2& innovation) {
  if (!noise_.is_estimated) return;
  const Sigma given = AsGiven(motion);
  const auto add = [this](Channel& channel, double ratio) {
    channel.recent[channel.next] = ratio;
    channel.next = (channel.next + 1) % channel.recent.size();
    channel.Update(search_sigmas_);
  };
  add(m_, geometry::Norm(innovation.translation) / given.m);
  add(rad_, std::abs(innovation.yaw_rad) / given.rad);
}

}  // namespace treeline::mapping

#include "nav_agent/drivers/segway/turn_watch.h"

#include <chrono>

namespace treeline::segway {
namespace {

constexpr double kSlowestTurn_radps = 0.1;
constexpr std::chrono::milliseconds kSettled(500);
constexpr double kDecisive_rad = 0.1;

int SignOf(double yaw_rate_radps) {
  if (yaw_rate_radps >= kSlowestTurn_radps) return 1;
  return yaw_rate_radps <= -kSlowestTurn_radps ? -1 : 0;
}

}  // namespace

void TurnWatch::Sent(double yaw_rate_radps, base::MonotonicTime now) {
  const int sign = SignOf(yaw_rate_radps);
  if (sign == sign_) return;
  sign_ = sign;
  since_ = now;
  difference_m_.reset();
}

void TurnWatch::Take(const core::BaseReading& reading,
                     base::MonotonicTime now) {
  if (verdict_ != Verdict::kUndecided || sign_ == 0) return;
  if (now - since_ < kSettled) return;
  const double difference_m = reading.right_wheel_m - reading.left_wheel_m;
  if (!difference_m_) difference_m_ = difference_m;
  const double turned_rad =
      sign_ * (difference_m - *difference_m_) / wheel_track_m_;
  if (turned_rad >= kDecisive_rad) verdict_ = Verdict::kRight;
  if (turned_rad <= -kDecisive_rad) verdict_ = Verdict::kWrong;
}

}  // namespace treeline::segway

// A Segway RMP100 behind the agent's ports.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_BASE_H_
#define NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_BASE_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/drivers/segway/segway_options.h"
#include "nav_agent/drivers/segway/segway_protocol.h"
#include "nav_agent/drivers/stream/backoff.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::segway {

inline constexpr int kSegwayBaud = 460800;

struct SegwayBaseOptions {
  SegwayOptions protocol{};
  // Between attempts to open the port.
  stream::BackoffOptions backoff{};
  uint64_t seed = 0;

  absl::Status Validate() const;
};

// Talks to the base on a thread of its own, and opens its port again whenever
// it is lost. Thread-safe. Errors of SetVelocity: SegwayProtocol.
class SegwayBase final : public core::BaseDriver, public core::Odometry {
 public:
  // Begins to look for the base; whether it is there, Health() tells. `clock`
  // is the steady clock, or another that runs as fast, and outlives the base.
  static absl::StatusOr<std::unique_ptr<SegwayBase>> Create(
      const SegwayBaseOptions& options,
      std::unique_ptr<stream::ByteStreamOpener> opener,
      const base::Clock& clock);
  // Sends a last stop frame.
  ~SegwayBase() override;

  absl::Status SetVelocity(const core::VelocityCommand& command) override;
  void Stop() override;
  // Stop frames at once; commands are refused until it is released.
  void SetEmergencyStop(bool engaged);
  std::vector<core::BaseReading> TakeReadings() override;
  core::DeviceHealth Health() const override;
  SegwayStatistics Statistics() const;

 private:
  SegwayBase(const SegwayBaseOptions& options,
             std::unique_ptr<stream::ByteStreamOpener> opener,
             const base::Clock& clock);

  void Run(const std::stop_token& stop);
  // Until the stream is of no more use, and why.
  absl::Status Converse(stream::ByteStream& stream,
                        const std::stop_token& stop);

  const SegwayBaseOptions options_;
  const std::unique_ptr<stream::ByteStreamOpener> opener_;
  const base::Clock& clock_;
  mutable absl::Mutex mutex_;
  SegwayProtocol protocol_ ABSL_GUARDED_BY(mutex_);
  // Since the port was opened.
  bool was_running_ ABSL_GUARDED_BY(mutex_) = false;
  std::jthread thread_;
};

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_BASE_H_

// A Hokuyo laser scanner (UTM-30LX, UTM-30LX-EW) as the agent knows lasers.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_LASER_H_
#define NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_LASER_H_

#include <deque>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/drivers/hokuyo/hokuyo_options.h"
#include "nav_agent/drivers/hokuyo/hokuyo_protocol.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::hokuyo {

// Owns a thread that opens the sensor, talks to it (HokuyoProtocol), and opens
// it again, with growing pauses, whenever it was lost: unplugged, silent or
// broken. Scans are stamped with the host's monotonic clock; see SensorClock.
//
// The first sensor that answers decides Info(). One that measures something
// else and is plugged in later is refused (FAILED_PRECONDITION in Health()),
// since nobody would notice that the meaning of the scans has changed.
//
// Health().cause says what is wrong; docs/reference/laser-driver.md what to do
// about it.
class HokuyoLaser final : public core::RangeSensor {
 public:
  // INVALID_ARGUMENT for bad options. `clock` must outlive the driver. Returns
  // at once; whether the sensor answers is for Health() to tell.
  static absl::StatusOr<std::unique_ptr<HokuyoLaser>> Start(
      const HokuyoOptions& options,
      std::unique_ptr<stream::ByteStreamOpener> opener,
      const base::Clock& clock);
  // Switches the laser off (QT), and closes the connection.
  ~HokuyoLaser() override;

  core::RangeSensorInfo Info() const override;
  std::vector<core::LaserScan> TakeScans() override;
  core::DeviceHealth Health() const override;

  // What the sensor says of itself; nothing while it has not.
  std::optional<ScipVersion> Version() const;

 private:
  HokuyoLaser(const HokuyoOptions& options,
              std::unique_ptr<stream::ByteStreamOpener> opener,
              const base::Clock& clock);

  // The thread.
  void Run(const std::stop_token& stop);
  // One session, until it fails or stop is requested.
  absl::Status Serve(stream::ByteStream& stream, const std::stop_token& stop);
  absl::Status Exchange(stream::ByteStream& stream, HokuyoProtocol& protocol,
                        const std::stop_token& stop);
  // What the protocol has learned and received since the last time.
  absl::Status Publish(HokuyoProtocol& protocol);
  void SetLost(const absl::Status& cause);

  const HokuyoOptions options_;
  const std::unique_ptr<stream::ByteStreamOpener> opener_;
  const base::Clock& clock_;
  // Of the thread alone.
  stream::Backoff backoff_;
  int64_t corrupt_before_session_ = 0;

  mutable absl::Mutex mutex_;
  core::DeviceHealth health_ ABSL_GUARDED_BY(mutex_);
  std::optional<core::RangeSensorInfo> info_ ABSL_GUARDED_BY(mutex_);
  std::optional<ScipVersion> version_ ABSL_GUARDED_BY(mutex_);
  std::deque<core::LaserScan> waiting_ ABSL_GUARDED_BY(mutex_);

  // Last, so that it ends before what it uses.
  std::jthread thread_;
};

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_LASER_H_

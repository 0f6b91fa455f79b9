// Connects an emulated device with the world, over a pseudo terminal or TCP.
#ifndef SIMULATION_EMULATORS_EMULATOR_SERVER_H_
#define SIMULATION_EMULATORS_EMULATOR_SERVER_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <variant>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/base/listen_address.h"
#include "nav_agent/drivers/stream/byte_stream.h"
#include "nav_agent/drivers/stream/pty.h"
#include "nav_agent/drivers/stream/tcp_stream.h"
#include "simulation/emulators/byte_faults.h"
#include "simulation/emulators/emulated_device.h"
#include "simulation/emulators/fault_plan.h"

namespace treeline::emulators {

// A pseudo terminal; `symlink`, unless empty, leads to it.
struct PtyAddress {
  std::string symlink = {};
};
// Where drivers find a device. TCP: port 0 is any that is free.
using DeviceAddress = std::variant<PtyAddress, base::ListenAddress>;
// "pty", "pty:/tmp/ttyLaser", "tcp:10940" (of 127.0.0.1) or
// "tcp:0.0.0.0:10940". INVALID_ARGUMENT says what is wrong.
absl::StatusOr<DeviceAddress> ParseDeviceAddress(absl::string_view text);

struct EmulatorServerOptions {
  DeviceAddress listen = PtyAddress{};
  DeviceFaultPlan faults;
  uint64_t seed = 1;
};

// Owns a thread in which the device lives, in real time as `clock` tells it.
// One program at a time is connected over TCP; the next waits its turn. Over a
// pseudo terminal, what nobody reads is lost once the system's buffer is full,
// as with the real thing.
class EmulatorServer {
 public:
  // `device` and `clock` must outlive the server; nobody else may touch the
  // device meanwhile. UNAVAILABLE or ALREADY_EXISTS say why the address cannot
  // be used.
  static absl::StatusOr<std::unique_ptr<EmulatorServer>> Start(
      EmulatorServerOptions options, EmulatedDevice& device,
      const base::Clock& clock);
  ~EmulatorServer();

  // What to give a driver (ParseStreamAddress): "/tmp/ttyLaser" or
  // "tcp:127.0.0.1:34567". A pseudo terminal without a symlink has another
  // name after it was replugged.
  std::string address() const;

  // From now on these instead of those that it was started with; their times
  // count from now.
  void SetFaults(DeviceFaultPlan faults);

  // Bytes that have come and gone; for people who look on.
  int64_t received() const { return received_; }
  int64_t sent() const { return sent_; }
  // Why the device cannot be reached; OK while it can.
  absl::Status trouble() const;

 private:
  EmulatorServer(EmulatorServerOptions options, EmulatedDevice& device,
                 const base::Clock& clock);

  absl::Status Plug();
  void Unplug();
  bool plugged() const { return pty_ != nullptr || listener_ != nullptr; }
  void Run(const std::stop_token& stop);
  // Sends and receives once, waiting a little.
  void Step(const ActiveFaults& faults, const std::stop_token& stop);
  // Whom the device speaks to; null while nobody is there.
  stream::ByteStream* Peer(const std::stop_token& stop);
  void Send(stream::ByteStream& peer, const ActiveFaults& faults,
            base::MonotonicTime now);
  // What the device has begun to say, to its end; false: the reader is late.
  bool Finish(stream::ByteStream& peer);
  ActiveFaults Faults(base::MonotonicTime now) const;

  // Of the thread alone, once it runs.
  DeviceAddress listen_;
  EmulatedDevice& device_;
  const base::Clock& clock_;
  ByteFaults byte_faults_;
  std::unique_ptr<stream::Pty> pty_;
  std::unique_ptr<stream::TcpListener> listener_;
  std::unique_ptr<stream::ByteStream> caller_;
  std::string unsent_;

  std::atomic<int64_t> received_ = 0;
  std::atomic<int64_t> sent_ = 0;
  mutable absl::Mutex mutex_;
  DeviceFaultPlan faults_ ABSL_GUARDED_BY(mutex_);
  base::MonotonicTime faults_since_ ABSL_GUARDED_BY(mutex_);
  std::string address_ ABSL_GUARDED_BY(mutex_);
  absl::Status trouble_ ABSL_GUARDED_BY(mutex_);

  // Last, so that it ends before what it uses.
  std::jthread thread_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_EMULATOR_SERVER_H_

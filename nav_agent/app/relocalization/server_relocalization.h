// The port through which a lost robot asks, over a connection to a server.
#ifndef NAV_AGENT_APP_RELOCALIZATION_SERVER_RELOCALIZATION_H_
#define NAV_AGENT_APP_RELOCALIZATION_SERVER_RELOCALIZATION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/relocalizer/connect_options.h"
#include "client/relocalizer/relocalizer.h"
#include "common/base/clock.h"
#include "common/wire/query_frame.h"
#include "nav_agent/app/relocalization/recovery_trace.h"
#include "nav_agent/core/relocalization.h"

namespace treeline::relocalization {

struct ServerRelocalizationOptions {
  // As the server knows it. Empty: the server finds out.
  std::string scene;
  // Of the colour picture, 1 to 100. Depth goes as a PNG, bit for bit.
  int jpeg_quality = 92;
  // Least confidence of an answer, in [0, 1]: a robot has its laser to check
  // what the server is not sure of (FixGateOptions).
  double min_confidence = 0.3;
  // Of the hypotheses that the server draws.
  uint64_t seed = 0;
  // What questions are spans of; null: of nothing. Must outlive the port.
  RecoveryTrace* trace = nullptr;

  absl::Status Validate() const;
};

// A frame as it is sent: JPEG, PNG, and the calibration that it was taken with;
// without one, that of the scene. INVALID_ARGUMENT: it has no picture.
absl::StatusOr<wire::QueryFrame> EncodeFrame(const image::Frame& frame,
                                             int jpeg_quality);

// Asks in a thread of its own; Ask returns at once and drops what was asked
// before, here and on the server. Retries, replicas, TLS and tokens are the
// relocalizer's. Thread-safe.
absl::StatusOr<std::unique_ptr<core::RelocalizationPort>>
MakeServerRelocalization(std::shared_ptr<relocalizer::Relocalizer> relocalizer,
                         const ServerRelocalizationOptions& options,
                         const base::Clock& clock);
// The same over a new connection; the server need not be there yet.
absl::StatusOr<std::unique_ptr<core::RelocalizationPort>>
MakeServerRelocalization(const relocalizer::ConnectOptions& connection,
                         const std::string& scene, const base::Clock& clock,
                         RecoveryTrace* trace = nullptr);

struct SynchronousOptions {
  // What an answer takes in simulated time (s); nullopt: as long as it really
  // took. Fixed, a run's result does not depend on how busy the machine is.
  std::optional<double> latency_s{};
  // What a call may take in real time (s); nullopt: the question's own limit.
  // What takes longer is DEADLINE_EXCEEDED when that limit has passed.
  std::optional<double> real_timeout_s{};
  // So much more is waited, for tests of slow servers (s).
  double extra_s = 0;
};

// For simulated time: Ask waits for the real answer, which is handed over when
// the answer's time has passed on `clock`, so that the robot waits as long as
// it would have. Not thread-safe.
absl::StatusOr<std::unique_ptr<core::RelocalizationPort>>
MakeSynchronousRelocalization(
    std::shared_ptr<relocalizer::Relocalizer> relocalizer,
    const ServerRelocalizationOptions& options, const base::Clock& clock,
    const SynchronousOptions& timing = {});

}  // namespace treeline::relocalization

#endif  // NAV_AGENT_APP_RELOCALIZATION_SERVER_RELOCALIZATION_H_

// Everything that serves, as one thing with a beginning and an end.
#ifndef SERVER_APP_APPLICATION_H_
#define SERVER_APP_APPLICATION_H_

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/log/program_log.h"
#include "server/app/server_config.h"

namespace treeline::server_app {

// In order: Start, any number of ApplyLive, Drain, Stop. Thread-safe but for
// that order.
class Application {
 public:
  // Loads, binds and serves. INVALID_ARGUMENT: the configuration; everything
  // else: what the machine did not allow. `log` and `clock` must outlive it.
  static absl::StatusOr<std::unique_ptr<Application>> Start(
      const ServerConfig& config, logging::ProgramLog& log,
      const base::Clock& clock);
  // Stops at once, if it was not stopped.
  ~Application();

  // For standard output: "listening on 127.0.0.1:50051" first, then "admin on
  // ..." and "http on ..." where there are such.
  const std::vector<std::string>& announcements() const;

  // What has live settings takes them over.
  void ApplyLive(const ServerConfig& config);

  // Says everywhere that it is about to go, and goes on answering.
  void Drain();
  // Closes the ports, waits up to `grace` for calls in flight, cancels the
  // rest.
  void Stop(std::chrono::milliseconds grace);

  // For /metrics: text format 0.0.4.
  std::string MetricsText() const;

 private:
  struct Parts;
  explicit Application(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_APPLICATION_H_

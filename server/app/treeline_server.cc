// treeline-server: answers where a camera is, over gRPC.
#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "common/base/interrupt.h"
#include "common/base/version.h"
#include "common/log/program_log.h"
#include "common/tracing/tracing_options.h"
#include "server/app/application.h"
#include "server/app/command_line.h"
#include "server/app/config_reloader.h"
#include "server/app/hangup.h"
#include "server/app/healthcheck.h"

namespace treeline::server_app {
namespace {

std::chrono::milliseconds Milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<int64_t>(seconds * 1e3));
}

int Fail(const absl::Status& status, bool wrong_usage) {
  std::fprintf(stderr, "treeline-server: %s\n",
               std::string(status.message()).c_str());
  return wrong_usage ? kExitUsage : kExitFailed;
}

// Returns when `stop` is requested.
void WaitForStop(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait(lock, stop, [] { return false; });
}

int RunHealthcheck(const HealthcheckOptions& options) {
  const absl::Status status = CheckHealth(options);
  const std::string what =
      options.scene.empty()
          ? options.server
          : absl::StrCat(options.server, ", scene ", options.scene);
  if (status.ok()) {
    std::printf("healthy: %s is SERVING\n", what.c_str());
    return kExitOk;
  }
  std::printf("unhealthy: %s: %s: %s\n", what.c_str(),
              absl::StatusCodeToString(status.code()).c_str(),
              std::string(status.message()).c_str());
  return kExitFailed;
}

int Serve(const config::ConfigSources& sources,
          const config::EffectiveConfig& effective,
          const std::stop_token& stop) {
  ServerConfig config = ServerConfigTable().Make(effective);
  config.otel =
      tracing::OptionsFromEnvironment(config::EnvironmentWith(environ, "OTEL_"),
                                      "treeline-server", base::Version());
  const base::SteadyClock clock;
  const auto log = logging::LogToStandardError(
      "treeline-server", logging::LogFormatOf(config.log_format));
  log->SetLevel(logging::LogLevelOf(config.log_level));
  log->TakeGrpcMessages();
  for (const std::string& variable :
       config::UnknownVariables(ServerConfigTable().settings(), sources)) {
    log->Say(logging::LogLevel::kWarn,
             absl::StrCat("environment: no setting belongs to ", variable));
  }
  for (const std::string& warning : config.otel.warnings) {
    log->Say(logging::LogLevel::kWarn, absl::StrCat("environment: ", warning));
  }
  const auto application = Application::Start(config, *log, clock);
  if (!application.ok()) {
    return Fail(application.status(),
                absl::IsInvalidArgument(application.status()));
  }
  ConfigReloader reloader(
      sources, effective, *log, [&](const ServerConfig& changed) {
        log->SetLevel(logging::LogLevelOf(changed.log_level));
        (*application)->ApplyLive(changed);
      });
  const HangupListener on_hangup([&] { reloader.Reload(); });
  for (const std::string& line : (*application)->announcements()) {
    std::printf("%s\n", line.c_str());
  }
  std::fflush(stdout);

  WaitForStop(stop);
  const double drain_s = reloader.config().drain_s;
  log->Say(logging::LogLevel::kInfo,
           absl::StrCat("stopping: health is NOT_SERVING, answering for ",
                        drain_s, " s more"));
  (*application)->Drain();
  std::this_thread::sleep_for(Milliseconds(drain_s));
  (*application)->Stop(Milliseconds(reloader.config().grace_s));
  log->Say(logging::LogLevel::kInfo, "stopped");
  return kExitOk;
}

// glibc raises by itself the size from which memory goes back to the system
// when it is freed, up to 32 MiB, and then each of its arenas keeps twice that:
// what a few large requests have taken would never be seen again.
void ReturnLargeBlocks() {
  mallopt(M_MMAP_THRESHOLD, 8 << 20);
  mallopt(M_TRIM_THRESHOLD, 16 << 20);
}

int Run(int argc, char** argv) {
  ReturnLargeBlocks();
  // Before there are threads that would not know of it.
  BlockHangup();
  const CommandLine line = ReadCommandLine(argc, argv, environ);
  if (line.exit_code) return *line.exit_code;
  if (line.task == CommandLine::Task::kHealthcheck) {
    return RunHealthcheck(line.healthcheck);
  }
  const auto effective =
      config::ResolveConfig(ServerConfigTable().settings(), line.sources);
  if (!effective.ok()) return Fail(effective.status(), true);
  if (const absl::Status valid =
          ServerConfigTable().Make(*effective).Validate();
      !valid.ok()) {
    return Fail(valid, true);
  }
  if (line.task == CommandLine::Task::kPrintConfig) {
    std::fputs(
        config::PrintConfig(ServerConfigTable().settings(), *effective).c_str(),
        stdout);
    return std::fflush(stdout) == 0 ? kExitOk : kExitFailed;
  }
  return Serve(line.sources, *effective, base::StopOnInterrupt());
}

}  // namespace
}  // namespace treeline::server_app

int main(int argc, char** argv) {
  return treeline::server_app::Run(argc, argv);
}

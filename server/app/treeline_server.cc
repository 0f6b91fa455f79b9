// treeline-server: answers where a camera is, over gRPC.
#include <grpc/support/log.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/interrupt.h"
#include "common/base/version.h"
#include "server/app/call_log.h"
#include "server/core/localizer/localizer.h"
#include "server/repository/scene_repository.h"
#include "server/service/access_policy.h"
#include "server/service/grpc_server.h"
#include "server/service/service_dispatcher.h"

namespace treeline {
namespace {

// Exit codes, as docs/service.md states them.
constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;

constexpr const char* kDescription =
    "Answers where a camera is: loads the scenes of a folder and serves them "
    "over gRPC.";

constexpr const char* kFooter = R"(
Scenes lie in DIR/<scene>/<version>/model.treeline, as `treeline train` writes
them; names are of A-Z a-z 0-9 . _ - and of two versions the greater number is
the newer. A model that cannot be loaded is reported, and the others serve.

Examples:
  treeline train --dataset 7scenes:office --frames train.txt --method rgbd \
      --output models/office/1/model.treeline
  treeline-server --models models
  treeline-client localize --server 127.0.0.1:50051 --scene office \
      --color query.color.jpg --depth query.depth.png

When it serves, it prints one line on standard output, for scripts to wait for:
  listening on 127.0.0.1:50051
With port 0 that is a port that was free. The log goes to standard error and
never holds images.

SIGTERM and Ctrl-C stop it in order: health turns to NOT_SERVING, calls are
answered for --drain-s more, then the port is closed and calls in flight get
--grace-s to finish. A second signal ends it at once.

Exit codes: 0 stopped as asked, 1 failed, 2 wrong usage.)";

struct Flags {
  std::string models;
  GrpcServerOptions server;
  DispatcherOptions dispatcher;
  double drain_s = 1;
  double grace_s = 10;
  std::string log_level = "info";
};

void AddFlags(CLI::App& app, Flags& flags) {
  GrpcServerOptions& server = flags.server;
  app.add_option("--models", flags.models, "Folder with the scenes")
      ->required()
      ->type_name("DIR");
  app.add_option("--listen", server.listen,
                 "Address and port; port 0 takes a free one")
      ->capture_default_str()
      ->type_name("HOST:PORT");
  app.add_flag("--insecure-any-address", server.insecure_any_address,
               "Allow addresses that other machines reach, although nothing "
               "is encrypted and nobody authenticated");
  app.add_option("--workers", flags.dispatcher.workers,
                 "Queries computed at a time; 0: one per processor")
      ->capture_default_str();
  app.add_option("--queue", flags.dispatcher.queue,
                 "Queries that may wait; more are turned away with UNAVAILABLE "
                 "and a time to retry")
      ->capture_default_str();
  app.add_option("--max-message-mib", server.max_message_mib,
                 "Largest request, MiB")
      ->capture_default_str();
  app.add_option("--drain-s", flags.drain_s,
                 "Seconds to go on answering after a stop was asked for, so "
                 "that balancers notice")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 3600.0));
  app.add_option("--grace-s", flags.grace_s,
                 "Seconds that calls in flight get after that")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 3600.0));
  app.add_option("--log-level", flags.log_level,
                 "debug logs every call, info those that failed")
      ->capture_default_str()
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}));
}

std::chrono::milliseconds Milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<int64_t>(seconds * 1e3));
}

// gRPC's own messages join the log.
void LogFromGrpc(gpr_log_func_args* args) {
  const auto level = args->severity == GPR_LOG_SEVERITY_ERROR
                         ? spdlog::level::err
                         : spdlog::level::debug;
  spdlog::log(level, "grpc: {}", args->message);
}

void StartLog(const std::string& level) {
  auto logger = spdlog::stderr_color_mt("treeline-server");
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v",
                      spdlog::pattern_time_type::utc);
  logger->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(logger);
  gpr_set_log_function(&LogFromGrpc);
}

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "treeline-server: %s\n",
               std::string(status.message()).c_str());
  return status.code() == absl::StatusCode::kInvalidArgument ? kUsage : kFailed;
}

void LogScenes(const SceneRepository& repository, const std::string& models) {
  const std::vector<SceneStatus> scenes = repository.List();
  for (const SceneStatus& scene : scenes) {
    for (const VersionStatus& version : scene.versions) {
      if (version.state == SceneState::kReady) {
        spdlog::info("scene={} version={} state=READY", scene.name,
                     version.version);
      } else {
        spdlog::warn("scene={} version={} state=FAILED reason=\"{}\"",
                     scene.name, version.version, version.failure.ToString());
      }
    }
  }
  if (scenes.empty()) {
    spdlog::warn(
        "no scenes: nothing matches {}/<scene>/<version>/"
        "model.treeline",
        models);
  }
}

// Returns when `stop` is requested.
void WaitForStop(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait(lock, stop, [] { return false; });
}

int Serve(const Flags& flags, const std::stop_token& stop) {
  StartLog(flags.log_level);
  const SteadyClock clock;
  // Before the models are read: they may take a while.
  for (const absl::Status& valid :
       {flags.server.Validate(), flags.dispatcher.Validate()}) {
    if (!valid.ok()) return Fail(valid);
  }
  const auto repository = SceneRepository::Open(
      flags.models,
      [](const std::string& path) { return OpenLocalizer(path); });
  if (!repository.ok()) {
    std::fprintf(stderr, "treeline-server: --models: %s\n",
                 std::string(repository.status().message()).c_str());
    return kFailed;
  }
  LogScenes(**repository, flags.models);
  CallLog call_log(spdlog::default_logger(), clock);
  OpenAccess access;
  ServiceDispatcher dispatcher(**repository, access, call_log, clock,
                               flags.dispatcher);
  const auto server =
      GrpcServer::Start(dispatcher, **repository, flags.server, clock);
  if (!server.ok()) return Fail(server.status());
  std::printf("listening on %s\n", (*server)->address().c_str());
  std::fflush(stdout);

  WaitForStop(stop);
  spdlog::info("stopping: health is NOT_SERVING, answering for {} s more",
               flags.drain_s);
  (*server)->AnnounceStop();
  std::this_thread::sleep_for(Milliseconds(flags.drain_s));
  (*server)->Stop(Milliseconds(flags.grace_s));
  spdlog::info("stopped");
  return kOk;
}

int Run(int argc, char** argv) {
  const std::stop_token stop = StopOnInterrupt();
  CLI::App app(kDescription, "treeline-server");
  app.footer(kFooter);
  app.set_version_flag("--version",
                       std::string("treeline-server ") + Version());
  Flags flags;
  AddFlags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // 0 for --help and --version.
    return app.exit(error) == 0 ? kOk : kUsage;
  }
  return Serve(flags, stop);
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) { return treeline::Run(argc, argv); }

#include "server/app/application.h"

#include <atomic>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "server/app/call_log.h"
#include "server/app/process_metrics.h"
#include "server/app/service_metrics.h"
#include "server/core/localizer/localizer.h"
#include "server/metrics/registry.h"
#include "server/repository/scene_repository.h"
#include "server/service/grpc_server.h"

namespace treeline {
namespace {

void LogScenes(const SceneRepository& repository, const std::string& models,
               ServerLog& log) {
  const std::vector<SceneStatus> scenes = repository.List();
  for (const SceneStatus& scene : scenes) {
    for (const VersionStatus& version : scene.versions) {
      LogEvent event = log.Event();
      event.Word("scene", scene.name).Word("version", version.version);
      if (version.state == SceneState::kReady) {
        log.Write(LogLevel::kInfo, event.Word("state", "READY"));
      } else {
        log.Write(LogLevel::kWarn,
                  event.Word("state", "FAILED")
                      .Text("reason", version.failure.ToString()));
      }
    }
  }
  if (scenes.empty()) {
    log.Say(LogLevel::kWarn,
            absl::StrCat("no scenes: nothing matches ", RedactAddress(models),
                         "/<scene>/<version>/model.treeline"));
  }
}

}  // namespace

// Destroyed from the last to the first: what calls before what it calls.
struct Application::Parts {
  Parts(ServerLog& log, const Clock& clock)
      : metrics(registry), call_log(log, clock) {}

  Registry registry;
  ServiceMetrics metrics;
  CallLog call_log;
  CallObservers observers{{&metrics, &call_log}};
  std::unique_ptr<SceneRepository> repository;
  std::unique_ptr<GrpcServer> grpc;
  std::vector<std::string> announcements;
  std::atomic<bool> draining = false;
};

void Application::AddMetrics(Parts& parts) {
  AddBuildInfo(parts.registry, Version());
  AddProcessMetrics(parts.registry);
  const SceneRepository& repository = *parts.repository;
  AddSceneMetrics(parts.registry, [&repository] {
    RepositoryFigures figures;
    for (const SceneStatus& status : repository.List()) {
      figures.scenes.push_back({.scene = status.name, .state = status.state});
    }
    return figures;
  });
}

Application::Application(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

Application::~Application() = default;

absl::StatusOr<std::unique_ptr<Application>> Application::Start(
    const ServerConfig& config, ServerLog& log, const Clock& clock) {
  // Before the models are read: they may take a while.
  TL_RETURN_IF_ERROR(config.Validate());
  auto parts = std::make_unique<Parts>(log, clock);
  auto repository = SceneRepository::Open(
      config.models,
      [](const std::string& path) { return OpenLocalizer(path); });
  if (!repository.ok()) return Annotate(repository.status(), "--models");
  parts->repository = *std::move(repository);
  LogScenes(*parts->repository, config.models, log);
  TL_ASSIGN_OR_RETURN(
      parts->grpc, GrpcServer::Start(*parts->repository, GrpcOptionsOf(config),
                                     parts->observers, clock));
  AddMetrics(*parts);
  parts->announcements.push_back(
      absl::StrCat("listening on ", parts->grpc->address()));
  return std::unique_ptr<Application>(new Application(std::move(parts)));
}

const std::vector<std::string>& Application::announcements() const {
  return parts_->announcements;
}

void Application::ApplyLive(const ServerConfig&) {}

void Application::Drain() {
  parts_->draining = true;
  parts_->grpc->AnnounceStop();
}

void Application::Stop(std::chrono::milliseconds grace) {
  parts_->draining = true;
  parts_->grpc->Stop(grace);
}

ProbeAnswer Application::Liveness() const { return {true, "alive\n"}; }

ProbeAnswer Application::Readiness() const {
  if (parts_->draining) return {false, "draining\n"};
  return {true, "ready\n"};
}

std::string Application::MetricsText() const {
  return parts_->registry.Expose();
}

}  // namespace treeline

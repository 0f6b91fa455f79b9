#include "server/app/model_supply.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/app/watched_folder.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"
#include "server/repository/http_model_source.h"

namespace treeline::server_app {
namespace {

constexpr size_t kMaxKeysBytes = 1 << 20;

absl::StatusOr<std::shared_ptr<const repository::IndexKeys>> ReadIndexKeys(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string pem,
                      base::ReadFile(path, kMaxKeysBytes));
  auto keys = repository::IndexKeys::FromPem(pem);
  if (!keys.ok()) {
    return base::Annotate(keys.status(), absl::StrCat("--models-keys ", path));
  }
  return std::make_shared<const repository::IndexKeys>(*std::move(keys));
}

// A model that somebody put where it is not looked for.
void LogMisplaced(const std::string& path, logging::ProgramLog& log) {
  log.Write(
      logging::LogLevel::kWarn,
      log.Event()
          .Text("path", path)
          .Message("passed over: a model is <scene>/<version>/model.treeline, "
                   "with names of A-Z a-z 0-9 . _ -"));
}

absl::StatusOr<std::unique_ptr<repository::ModelSource>> OpenSource(
    const ServerConfig& config, const std::stop_token& stop,
    logging::ProgramLog& log, const base::Clock& clock) {
  if (!repository::IsModelUrl(config.models)) {
    return std::make_unique<WatchedFolder>(
        config.models,
        [&log](const std::string& path) { LogMisplaced(path, log); });
  }
  repository::HttpModelSourceOptions options;
  options.url = config.models;
  options.cache.folder = config.cache;
  options.cache.limit_bytes = static_cast<uint64_t>(config.cache_mib) << 20;
  options.http.ca_file = config.models_ca;
  options.http.allow_plain_http = config.insecure_any_address;
  if (!config.models_keys.empty()) {
    TL_ASSIGN_OR_RETURN(options.keys, ReadIndexKeys(config.models_keys));
  }
  options.stop = stop;
  options.warn = [&log](absl::string_view message) {
    log.Say(logging::LogLevel::kWarn, message);
  };
  return repository::HttpModelSource::Open(std::move(options), clock);
}

// What happens to scenes after the start, too.
void LogEventOf(const repository::RepositoryEvent& event,
                logging::ProgramLog& log) {
  const bool bad = !event.status.ok();
  logging::LogLine line = log.Event();
  line.Word("event", repository::EventName(event.kind));
  if (!event.scene.empty()) line.Word("scene", event.scene);
  if (!event.version.empty()) line.Word("version", event.version);
  if (bad) line.Text("reason", event.status.ToString());
  log.Write(bad ? logging::LogLevel::kWarn : logging::LogLevel::kInfo, line);
}

void LogScenes(const repository::SceneRepository& repository,
               const std::string& models, logging::ProgramLog& log) {
  const std::vector<repository::SceneStatus> scenes = repository.List();
  for (const repository::SceneStatus& scene : scenes) {
    for (const repository::VersionStatus& version : scene.versions) {
      logging::LogLine event = log.Event();
      event.Word("scene", scene.name).Word("version", version.version);
      if (version.state == repository::SceneState::kFailed) {
        log.Write(logging::LogLevel::kWarn,
                  event.Word("state", "FAILED")
                      .Text("reason", version.failure.ToString()));
        continue;
      }
      const bool ready = version.state == repository::SceneState::kReady;
      log.Write(logging::LogLevel::kInfo,
                event.Word("state", ready ? "READY" : "UNLOADED"));
    }
  }
  if (scenes.empty()) {
    log.Say(logging::LogLevel::kWarn,
            absl::StrCat("no scenes: nothing matches ",
                         config::RedactAddress(models),
                         "/<scene>/<version>/model.treeline"));
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<repository::SceneRepository>> OpenRepository(
    const ServerConfig& config, const std::stop_token& stop,
    logging::ProgramLog& log, const base::Clock& clock) {
  auto source = OpenSource(config, stop, log, clock);
  if (!source.ok()) return base::Annotate(source.status(), "--models");
  repository::RepositoryOptions options;
  options.memory_budget_bytes = static_cast<uint64_t>(config.memory_budget_mib)
                                << 20;
  options.read_memory_bytes = &forest::ReadModelMemoryBytes;
  options.poll_interval =
      std::chrono::milliseconds(static_cast<int64_t>(config.poll_s * 1e3));
  options.load_all_at_start = config.load_all;
  options.on_event = [&log](const repository::RepositoryEvent& event) {
    LogEventOf(event, log);
  };
  auto repository = repository::SceneRepository::Open(
      *std::move(source),
      [](const std::string& path) { return localizer::OpenLocalizer(path); },
      options, clock);
  if (!repository.ok()) return base::Annotate(repository.status(), "--models");
  if (config.load_all) {
    TL_RETURN_IF_ERROR((*repository)->WaitForLoads(stop));
  }
  LogScenes(**repository, config.models, log);
  return repository;
}

}  // namespace treeline::server_app

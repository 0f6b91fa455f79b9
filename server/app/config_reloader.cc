#include "server/app/config_reloader.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"

namespace treeline::server_app {
namespace {

absl::StatusOr<config::EffectiveConfig> ResolveAll(
    const config::ConfigSources& sources) {
  const auto& table = ServerConfigTable();
  TL_ASSIGN_OR_RETURN(config::EffectiveConfig config,
                      config::ResolveConfig(table.settings(), sources));
  TL_RETURN_IF_ERROR(table.Make(config).Validate());
  return config;
}

}  // namespace

ConfigReloader::ConfigReloader(config::ConfigSources sources,
                               config::EffectiveConfig initial,
                               logging::ProgramLog& log,
                               std::function<void(const ServerConfig&)> apply)
    : sources_(std::move(sources)),
      log_(log),
      apply_(std::move(apply)),
      in_force_(std::move(initial)) {}

void ConfigReloader::Reload() {
  const auto& settings = ServerConfigTable().settings();
  const auto read = ResolveAll(sources_);
  if (!read.ok()) {
    log_.Say(logging::LogLevel::kError,
             absl::StrCat("configuration not reloaded, the old one stays: ",
                          read.status().message()));
    return;
  }
  std::vector<std::string> applied;
  std::vector<std::string> needs_restart;
  {
    absl::MutexLock lock(&mutex_);
    for (const std::string& name :
         config::ChangedSettings(settings, in_force_, *read)) {
      if (config::FindSetting(settings, name)->live) {
        in_force_[name] = read->at(name);
        applied.push_back(name);
      } else {
        needs_restart.push_back(name);
      }
    }
  }
  apply_(config());
  log_.Say(
      logging::LogLevel::kInfo,
      absl::StrCat("configuration reloaded; changed: ",
                   applied.empty() ? "nothing" : absl::StrJoin(applied, ", ")));
  if (!needs_restart.empty()) {
    log_.Say(logging::LogLevel::kWarn,
             absl::StrCat("changed, but needs a restart: ",
                          absl::StrJoin(needs_restart, ", ")));
  }
}

ServerConfig ConfigReloader::config() const {
  absl::MutexLock lock(&mutex_);
  return ServerConfigTable().Make(in_force_);
}

}  // namespace treeline::server_app

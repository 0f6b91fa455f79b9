// The configuration in force while the server runs.
#ifndef SERVER_APP_CONFIG_RELOADER_H_
#define SERVER_APP_CONFIG_RELOADER_H_

#include <functional>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/config/effective_config.h"
#include "common/log/program_log.h"
#include "server/app/server_config.h"

namespace treeline::server_app {

// Reads the sources again when asked to. Reload() is for one thread at a time;
// config() for any.
class ConfigReloader {
 public:
  // `initial` is what `sources` gave at the start. `apply` gets the
  // configuration in force after each Reload() that succeeded, without a lock
  // held, whether or not anything changed.
  ConfigReloader(config::ConfigSources sources, config::EffectiveConfig initial,
                 logging::ProgramLog& log,
                 std::function<void(const ServerConfig&)> apply);

  // What can be changed live comes into force; what cannot keeps its value, and
  // the log says that it needs a restart. If anything is wrong, everything
  // stays as it was, and the log says why.
  void Reload();

  ServerConfig config() const;

 private:
  const config::ConfigSources sources_;
  logging::ProgramLog& log_;
  const std::function<void(const ServerConfig&)> apply_;
  mutable absl::Mutex mutex_;
  config::EffectiveConfig in_force_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_CONFIG_RELOADER_H_

// The relocalization server that kidnapped robots ask: a process of its own,
// with what can go wrong with it.
#ifndef EVALUATION_KIDNAPS_KIDNAP_SERVER_H_
#define EVALUATION_KIDNAPS_KIDNAP_SERVER_H_

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/child_process.h"

namespace treeline::kidnaps {

enum class ServerFault {
  kNone,
  kKilled,     // it dies before the first kidnap
  kSlow,       // it takes connections and answers none: it is stopped (SIGSTOP)
  kWrongScene  // under each scene's name it serves another scene's model
};
absl::StatusOr<ServerFault> ParseServerFault(const std::string& name);

class KidnapServer {
 public:
  // The program `treeline-server` beside this one, on a free port of this
  // machine, with all models of the repository loaded.
  static absl::StatusOr<std::unique_ptr<KidnapServer>> Spawn(
      const std::string& models, const std::string& log,
      const std::stop_token& stop);

  // "127.0.0.1:12345".
  const std::string& address() const { return address_; }
  void Break(ServerFault fault);

 private:
  explicit KidnapServer(std::unique_ptr<base::ChildProcess> process)
      : process_(std::move(process)) {}

  std::unique_ptr<base::ChildProcess> process_;
  std::string address_;
};

// A repository in which each of the scenes has the next one's model. At least
// two scenes, all of them in `models`.
absl::Status MakeWrongModels(const std::string& models,
                             const std::vector<std::string>& scenes,
                             const std::string& wrong_models);

}  // namespace treeline::kidnaps

#endif  // EVALUATION_KIDNAPS_KIDNAP_SERVER_H_

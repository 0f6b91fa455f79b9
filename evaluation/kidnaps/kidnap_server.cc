#include "evaluation/kidnaps/kidnap_server.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::kidnaps {
namespace {

namespace fs = std::filesystem;

constexpr auto kLook = std::chrono::milliseconds(50);
constexpr auto kPatience = std::chrono::seconds(120);
constexpr const char* kListening = "listening on 127.0.0.1:";

// What a log says of the server's address; empty: nothing yet.
std::string AddressIn(const std::string& log) {
  const size_t at = log.find(kListening);
  if (at == std::string::npos) return {};
  const size_t begin = at + std::string("listening on ").size();
  size_t end = begin + std::string("127.0.0.1:").size();
  const size_t digits = end;
  while (end < log.size() &&
         absl::ascii_isdigit(static_cast<unsigned char>(log[end]))) {
    ++end;
  }
  // The line must be complete.
  if (end == digits || end == log.size()) return {};
  return log.substr(begin, end - begin);
}

}  // namespace

absl::StatusOr<ServerFault> ParseServerFault(const std::string& name) {
  if (name.empty() || name == "none") return ServerFault::kNone;
  if (name == "killed") return ServerFault::kKilled;
  if (name == "slow") return ServerFault::kSlow;
  if (name == "wrong-scene") return ServerFault::kWrongScene;
  return absl::InvalidArgumentError(
      absl::StrCat("--server-fault is '", name,
                   "'; it must be killed, slow or wrong-scene"));
}

absl::StatusOr<std::unique_ptr<KidnapServer>> KidnapServer::Spawn(
    const std::string& models, const std::string& log,
    const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::string program,
                      base::SiblingProgram("treeline-server"));
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<base::ChildProcess> process,
      base::ChildProcess::Start(
          {program, "--models", models, "--load-all", "--listen", "127.0.0.1:0",
           "--admin-listen", "", "--http-listen", ""},
          log));
  std::unique_ptr<KidnapServer> server(new KidnapServer(std::move(process)));
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (server->address_.empty()) {
    server->address_ = AddressIn(server->process_->Log());
    if (!server->address_.empty()) break;
    if (server->process_->ExitCode().has_value() ||
        std::chrono::steady_clock::now() > until) {
      return absl::UnavailableError(absl::StrCat(
          "treeline-server did not start; what it said is in ", log));
    }
    if (stop.stop_requested()) return absl::CancelledError("interrupted");
    std::this_thread::sleep_for(kLook);
  }
  return server;
}

void KidnapServer::Break(ServerFault fault) {
  if (fault == ServerFault::kKilled) {
    process_->Signal(SIGKILL);
    while (!process_->ExitCode().has_value())
      std::this_thread::sleep_for(kLook);
  } else if (fault == ServerFault::kSlow) {
    process_->Signal(SIGSTOP);
  }
}

absl::Status MakeWrongModels(const std::string& models,
                             const std::vector<std::string>& scenes,
                             const std::string& wrong_models) {
  if (scenes.size() < 2) {
    return absl::InvalidArgumentError(
        "--server-fault wrong-scene needs two worlds at least: one has the "
        "other's model");
  }
  std::error_code error;
  fs::remove_all(wrong_models, error);
  for (size_t i = 0; i < scenes.size(); ++i) {
    const fs::path from = fs::path(models) / scenes[(i + 1) % scenes.size()];
    const fs::path to = fs::path(wrong_models) / scenes[i];
    fs::create_directories(to.parent_path(), error);
    fs::copy(from, to, fs::copy_options::recursive, error);
    if (error) {
      return absl::UnavailableError(absl::StrCat("copying ", from.string(),
                                                 " to ", to.string(), ": ",
                                                 error.message()));
    }
  }
  return absl::OkStatus();
}

}  // namespace treeline::kidnaps

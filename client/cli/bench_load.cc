#include "client/cli/bench_load.h"

#include <fstream>
#include <iostream>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_split.h"
#include "client/bench/answer_checker.h"
#include "client/bench/http_transport.h"
#include "client/bench/workload.h"
#include "client/cli/client_command.h"
#include "client/relocalizer/channel.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// A GeoPose is of the Earth, not of the world that the true poses are of.
std::vector<std::optional<geometry::Rigid3>> Truths(
    bench::Target target, const std::vector<bench::WorkItem>& items) {
  std::vector<std::optional<geometry::Rigid3>> truths;
  truths.reserve(items.size());
  for (const bench::WorkItem& item : items) {
    truths.push_back(target == bench::Target::kGeoPose
                         ? std::nullopt
                         : item.world_from_camera);
  }
  return truths;
}

absl::StatusOr<std::unique_ptr<bench::LoadGenerator>> MakeGenerator(
    const BenchFlags& flags, const std::vector<bench::WorkItem>& items,
    bench::AnswerChecker& checker) {
  relocalizer::ConnectOptions options = ConnectOptionsOf(flags.connection);
  if (flags.target != bench::Target::kGrpc) {
    TL_ASSIGN_OR_RETURN(std::unique_ptr<bench::Transport> transport,
                        bench::MakeHttpTransport(flags.target, options,
                                                 flags.connections, items));
    return std::make_unique<bench::LoadGenerator>(std::move(transport), items,
                                                  checker);
  }
  options.max_attempts = flags.attempts;
  options.own_connections = true;
  std::vector<relocalizer::Connection> connections;
  for (int i = 0; i < flags.connections; ++i) {
    TL_ASSIGN_OR_RETURN(relocalizer::Connection connection,
                        relocalizer::Connection::Open(options));
    connections.push_back(std::move(connection));
  }
  return std::make_unique<bench::LoadGenerator>(connections, items, checker);
}

class OwnLoad final : public BenchLoad {
 public:
  OwnLoad(const BenchFlags& flags, const std::vector<bench::WorkItem>& items)
      : flags_(flags),
        checker_(Truths(flags.target, items),
                 {.position_m = flags.tolerance_m,
                  .rotation_rad = flags.tolerance_deg * kRadiansPerDegree}) {}

  absl::Status Connect(const std::vector<bench::WorkItem>& items) {
    TL_ASSIGN_OR_RETURN(generator_, MakeGenerator(flags_, items, checker_));
    return absl::OkStatus();
  }

  absl::Status Prepare(const std::stop_token& stop) override {
    if (!flags_.no_reference) {
      TL_RETURN_IF_ERROR(generator_->AskOnce(1, flags_.load.deadline_ms, stop));
    }
    checker_.LoadBegins();
    return absl::OkStatus();
  }

  absl::StatusOr<bench::LoadRun> Run(
      const bench::LoadStep& step, const std::stop_token& stop,
      const bench::LoadGenerator::Watch& watch) override {
    bench::LoadOptions options = flags_.load;
    options.rate_per_s = step.rate_per_s;
    options.concurrency = step.concurrency;
    options.seed = step.seed;
    return generator_->Run(options, stop, watch);
  }

  std::map<bench::OutcomeKey, int64_t> AllCalls() const override {
    return generator_->AllCalls();
  }

 private:
  const BenchFlags& flags_;
  bench::AnswerChecker checker_;
  std::unique_ptr<bench::LoadGenerator> generator_;
};

// This program's own arguments, with which it can be started again.
absl::StatusOr<std::vector<std::string>> OwnCommand() {
  // It has no size that could be asked for.
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  if (bytes.empty()) {
    return absl::InternalError("/proc/self/cmdline cannot be read");
  }
  bytes.pop_back();  // the last one's end
  std::vector<std::string> command = absl::StrSplit(bytes, '\0');
  command[0] = "/proc/self/exe";
  return command;
}

class LoadOfProcesses final : public BenchLoad {
 public:
  explicit LoadOfProcesses(const BenchFlags& flags) : flags_(flags) {}

  absl::Status Prepare(const std::stop_token& stop) override {
    TL_ASSIGN_OR_RETURN(std::vector<std::string> command, OwnCommand());
    command.emplace_back("--worker");
    TL_ASSIGN_OR_RETURN(processes_, bench::WorkerProcesses::Start(
                                        command, flags_.processes, stop));
    return absl::OkStatus();
  }

  absl::StatusOr<bench::LoadRun> Run(
      const bench::LoadStep& step, const std::stop_token& stop,
      const bench::LoadGenerator::Watch&) override {
    return processes_->Run(step, stop);
  }

  std::map<bench::OutcomeKey, int64_t> AllCalls() const override {
    return processes_->all_calls();
  }

 private:
  const BenchFlags& flags_;
  std::unique_ptr<bench::WorkerProcesses> processes_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<BenchLoad>> MakeOwnLoad(
    const BenchFlags& flags, const std::vector<bench::WorkItem>& items) {
  auto load = std::make_unique<OwnLoad>(flags, items);
  TL_RETURN_IF_ERROR(load->Connect(items));
  return load;
}

std::unique_ptr<BenchLoad> MakeLoadOfProcesses(const BenchFlags& flags) {
  return std::make_unique<LoadOfProcesses>(flags);
}

int RunBenchWorker(const BenchFlags& flags, const std::stop_token& stop) {
  std::vector<bench::WorkItem> items;
  std::unique_ptr<BenchLoad> load;
  const bool served = bench::ServeSteps(
      std::cin, std::cout,
      [&]() -> absl::Status {
        TL_ASSIGN_OR_RETURN(items, bench::LoadWorkload(flags.workload));
        TL_ASSIGN_OR_RETURN(load, MakeOwnLoad(flags, items));
        return load->Prepare(stop);
      },
      [&](const bench::LoadStep& step) -> absl::StatusOr<bench::RunRecord> {
        TL_ASSIGN_OR_RETURN(
            bench::LoadRun run,
            load->Run(step, stop, [](const bench::Glance&, double) {}));
        return bench::RunRecord{.run = std::move(run),
                                .all_calls = load->AllCalls()};
      });
  return served ? kExitLocalized : kExitFailed;
}

}  // namespace treeline::client_cli

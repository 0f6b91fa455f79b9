#include "client/cli/bench_command.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/bench/answer_checker.h"
#include "client/bench/bench_report.h"
#include "client/bench/load_generator.h"
#include "client/bench/workload.h"
#include "client/cli/connection_flags.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {
namespace {

constexpr const char* kFooter = R"(
--scene NAME=ROOT or NAME=ROOT,LIST: the frames of LIST (ROOT/test.txt), as
`localize --list` reads them, are asked for in scene NAME. They are read and
encoded before anything is sent. Several scenes and encodings are mixed.

Closed loop, the default: --concurrency clients, each of which asks again when
it has its answer. Open loop, --rate: so many calls a second at random times,
answered or not, each timed from the moment that it was to be sent. --sweep
measures the capacity with the closed loop and then offers 10 % to 120 % of it.

Before the load every query is asked once; under load every answer must be the
same, bit for bit. Where a frame has its true pose beside it (STEM.pose.txt),
the answer is compared with that too.

Examples:
  treeline-client bench --server 127.0.0.1:50051 --scene room=recording \
      --concurrency 8 --duration 30
  treeline-client bench --server 127.0.0.1:50051 --scene room=recording \
      --rate 100 --deadline-ms 250 --json > run.json
  treeline-client bench --server 127.0.0.1:50051 --scene room=recording \
      --scene lab=lab,lab/query.txt --encoding jpeg --encoding raw+raw --sweep

Exit codes: 0 done, 1 failed (also: an answer differed, or there was none), 2
wrong usage, 130 interrupted, after what was measured so far.)";

constexpr double kRadiansPerDegree = std::numbers::pi / 180;
constexpr std::chrono::seconds kLogEvery(10);

struct BenchFlags {
  ConnectionFlags connection;
  std::vector<std::string> scenes;
  std::vector<std::string> encodings = {"file"};
  bench::WorkloadOptions workload;
  bench::LoadOptions load;
  int attempts = 1;
  int connections = 1;
  bool sweep = false;
  bool no_reference = false;
  double tolerance_m = 0.05;
  double tolerance_deg = 5;
  bool json = false;
};

// Shows the state of a run on standard error: in place on a terminal, a line
// every ten seconds elsewhere.
class LiveDisplay {
 public:
  LiveDisplay() : terminal_(isatty(STDERR_FILENO) == 1) {}
  ~LiveDisplay() { Clear(); }
  LiveDisplay(const LiveDisplay&) = delete;
  LiveDisplay& operator=(const LiveDisplay&) = delete;

  void Show(const std::string& line) {
    if (terminal_) {
      std::fprintf(stderr, "\r\x1b[K%s", line.c_str());
      shown_ = true;
      return;
    }
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + kLogEvery;
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  void Clear() {
    if (std::exchange(shown_, false)) std::fputs("\r\x1b[K", stderr);
  }

 private:
  const bool terminal_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point next_ =
      std::chrono::steady_clock::now() + kLogEvery;
};

class Bench {
 public:
  Bench(const BenchFlags& flags,
        std::vector<relocalizer::Connection> connections,
        std::vector<bench::WorkItem> items)
      : flags_(flags),
        items_(std::move(items)),
        checker_(Truths(items_),
                 {.position_m = flags.tolerance_m,
                  .rotation_rad = flags.tolerance_deg * kRadiansPerDegree}),
        generator_(std::move(connections), items_, checker_) {
    report_.server = flags.connection.server;
    report_.machine = bench::DescribeMachine();
    report_.load_before = bench::LoadAverage();
    report_.workload = bench::Summarize(items_);
  }

  absl::Status Run(const std::stop_token& stop) {
    if (!flags_.no_reference) {
      TL_RETURN_IF_ERROR(generator_.AskOnce(1, flags_.load.deadline_ms, stop));
      report_.reference_answers = static_cast<int>(items_.size());
    }
    checker_.LoadBegins();
    if (flags_.sweep) {
      Sweep(stop);
    } else {
      RunOnce(flags_.load, stop);
    }
    report_.load_after = bench::LoadAverage();
    report_.all_calls = generator_.AllCalls();
    return absl::OkStatus();
  }

  const bench::BenchReport& report() const { return report_; }

  // Whether there were answers, and none of them was another than before.
  bool Passed() const {
    return std::all_of(report_.runs.begin(), report_.runs.end(),
                       [](const bench::LoadRun& run) {
                         return run.tally.counts[0] > 0 &&
                                run.tally.checks.different == 0;
                       });
  }

 private:
  static std::vector<std::optional<geometry::Rigid3>> Truths(
      const std::vector<bench::WorkItem>& items) {
    std::vector<std::optional<geometry::Rigid3>> truths;
    truths.reserve(items.size());
    for (const bench::WorkItem& item : items) {
      truths.push_back(item.world_from_camera);
    }
    return truths;
  }

  void RunOnce(const bench::LoadOptions& options, const std::stop_token& stop) {
    LiveDisplay display;
    report_.runs.push_back(generator_.Run(
        options, stop, [&](const bench::Glance& glance, double at_s) {
          display.Show(bench::LiveLine(glance, at_s));
        }));
  }

  void Sweep(const std::stop_token& stop) {
    bench::LoadOptions options = flags_.load;
    options.rate_per_s = 0;
    RunOnce(options, stop);
    report_.capacity_per_s = bench::Goodput_per_s(report_.runs.back());
    if (report_.capacity_per_s == 0) return;
    for (int percent = 10; percent <= 120; percent += 10) {
      if (stop.stop_requested()) return;
      options.rate_per_s = report_.capacity_per_s * percent / 100;
      RunOnce(options, stop);
    }
  }

  const BenchFlags& flags_;
  const std::vector<bench::WorkItem> items_;
  bench::AnswerChecker checker_;
  bench::LoadGenerator generator_;
  bench::BenchReport report_;
};

// What the flags say in text.
absl::Status Parse(BenchFlags& flags) {
  for (const std::string& scene : flags.scenes) {
    TL_ASSIGN_OR_RETURN(bench::SceneFrames frames,
                        bench::SceneFrames::Parse(scene));
    flags.workload.scenes.push_back(std::move(frames));
  }
  flags.workload.encodings.clear();
  for (const std::string& encoding : flags.encodings) {
    TL_ASSIGN_OR_RETURN(const bench::FrameEncoding parsed,
                        bench::FrameEncoding::Parse(encoding));
    flags.workload.encodings.push_back(parsed);
  }
  if (flags.sweep && flags.load.rate_per_s > 0) {
    return absl::InvalidArgumentError("--sweep finds the rates itself");
  }
  return flags.load.Validate();
}

absl::StatusOr<std::vector<relocalizer::Connection>> Connect(
    const BenchFlags& flags) {
  relocalizer::ConnectOptions options = ConnectOptionsOf(flags.connection);
  options.max_attempts = flags.attempts;
  options.own_connections = true;
  std::vector<relocalizer::Connection> connections;
  for (int i = 0; i < flags.connections; ++i) {
    TL_ASSIGN_OR_RETURN(relocalizer::Connection connection,
                        relocalizer::Connection::Open(options));
    connections.push_back(std::move(connection));
  }
  return connections;
}

int RunBench(BenchFlags flags, const std::stop_token& stop) {
  if (const absl::Status parsed = Parse(flags); !parsed.ok()) {
    ReportLocalFailure(parsed);
    return kExitUsage;
  }
  flags.load.seed = flags.workload.seed;
  auto connections = Connect(flags);
  if (!connections.ok()) return ReportLocalFailure(connections.status());
  auto items = bench::LoadWorkload(flags.workload);
  if (!items.ok()) return ReportLocalFailure(items.status());
  Bench bench(flags, *std::move(connections), *std::move(items));
  if (const absl::Status run = bench.Run(stop); !run.ok()) {
    return ReportFailure(run, flags.connection, stop);
  }
  std::fputs(flags.json ? (bench::BenchJson(bench.report()) + "\n").c_str()
                        : bench::BenchText(bench.report()).c_str(),
             stdout);
  if (!FlushOutput()) return kExitFailed;
  if (stop.stop_requested()) return kExitInterrupted;
  return bench.Passed() ? kExitLocalized : kExitFailed;
}

void AddWorkloadFlags(CLI::App& app, BenchFlags& flags) {
  app.add_option("--scene", flags.scenes, "Frames to ask for; may be repeated")
      ->required()
      ->type_name("NAME=ROOT[,LIST]");
  app.add_option("--encoding", flags.encodings,
                 "How frames are sent: file, jpeg, png or raw, and for depth "
                 "+png, +raw or +none; may be repeated")
      ->capture_default_str()
      ->type_name("COLOUR[+DEPTH]");
  app.add_option("--max-frames", flags.workload.max_frames,
                 "Most frames of one scene, spread over its list")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  app.add_option("--depth-unit", flags.workload.frames.depth_unit_m,
                 "Metres per unit of depth")
      ->capture_default_str()
      ->type_name("M");
  app.add_flag("--registered", flags.workload.frames.depth_is_registered,
               "Depth pixel (x, y) sees what colour pixel (x, y) sees");
  app.add_option("--camera", flags.workload.frames.camera,
                 "Intrinsics of the colour images; without: the scene's")
      ->type_name("MODEL,PARAMS");
  app.add_option("--seed", flags.workload.seed,
                 "Of the queries, their order and their times")
      ->capture_default_str();
  app.add_option("--tolerance-m", flags.tolerance_m,
                 "How far from the true position an answer may be")
      ->capture_default_str();
  app.add_option("--tolerance-deg", flags.tolerance_deg,
                 "How far from the true rotation")
      ->capture_default_str();
}

void AddLoadFlags(CLI::App& app, BenchFlags& flags) {
  bench::LoadOptions& load = flags.load;
  app.add_option("--concurrency", load.concurrency, "Clients of a closed loop")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  app.add_option("--stream", load.stream_window,
                 "Each of them asks with one stream, this many frames in "
                 "flight")
      ->check(CLI::Range(1, 1000))
      ->type_name("FRAMES");
  app.add_option("--rate", load.rate_per_s, "Open loop: calls per second")
      ->check(CLI::PositiveNumber);
  app.add_flag("--sweep", flags.sweep,
               "Measure the capacity, then offer 10 % to 120 % of it");
  app.add_option("--duration", load.duration_s, "Seconds to measure (each run)")
      ->capture_default_str();
  app.add_option("--warm-up", load.warm_up_s, "Seconds before that")
      ->capture_default_str();
  app.add_option("--deadline-ms", load.deadline_ms,
                 "Of each call, retries included")
      ->capture_default_str();
  app.add_option("--attempts", flags.attempts,
                 "How often a call is tried while the answer is UNAVAILABLE; "
                 "`localize` tries 4 times")
      ->capture_default_str()
      ->check(CLI::Range(1, 5));
  app.add_option("--connections", flags.connections,
                 "Connections to each server, used in turn")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  app.add_option("--cancel-share", load.cancel_share,
                 "Share of the calls that are cancelled")
      ->capture_default_str();
  app.add_option("--cancel-after-ms", load.cancel_after_ms,
                 "They are cancelled after 0 to this time")
      ->capture_default_str();
  app.add_option("--interval-s", load.interval_s,
                 "Length of the intervals in the JSON")
      ->capture_default_str();
  app.add_flag("--no-reference", flags.no_reference,
               "Do not ask for every answer before the load");
  app.add_flag("--json", flags.json, "One JSON object");
}

}  // namespace

ClientCommand AddBenchCommand(CLI::App& app) {
  auto flags = std::make_shared<BenchFlags>();
  CLI::App* command = app.add_subcommand(
      "bench", "Put a server under load and check its answers");
  command->footer(kFooter);
  AddServerFlags(*command, flags->connection);
  AddWorkloadFlags(*command, *flags);
  AddLoadFlags(*command, *flags);
  return {command, [flags](const std::stop_token& stop) {
            return RunBench(*flags, stop);
          }};
}

}  // namespace treeline::client_cli

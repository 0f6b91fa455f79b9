#include "client/cli/bench_command.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/bench/bench_report.h"
#include "client/bench/server_course.h"
#include "client/cli/bench_flags.h"
#include "client/cli/bench_load.h"
#include "client/cli/metrics_source.h"
#include "common/base/installed_file.h"
#include "common/base/live_display.h"
#include "common/base/status_macros.h"
#include "common/page/page_template.h"

namespace treeline::client_cli {
namespace {

constexpr const char* kFooter = R"(
--scene NAME=ROOT or NAME=ROOT,LIST: the frames of LIST (ROOT/test.txt), as
`localize --list` reads them, are asked for in scene NAME. They are read and
encoded before anything is sent. Several scenes and encodings are mixed.

Closed loop, the default: --concurrency clients, each of which asks again when
it has its answer. Open loop, --rate: so many calls a second at random times,
answered or not, each timed from the moment that it was to be sent. --sweep
measures the capacity with the closed loop and then offers 10 % to 120 % of it;
--ramp-rate and --ramp-concurrency go up in steps of your own.

Before the load every query is asked once; under load every answer must be the
same, bit for bit. Where a frame has its true pose beside it (STEM.pose.txt),
the answer is compared with that too.

Examples:
  treeline-client bench --server 127.0.0.1:50051 --scene room=recording \
      --concurrency 8 --duration 30
  treeline-client bench --server 127.0.0.1:50051 --scene room=recording \
      --rate 100 --deadline-ms 250 --fail-if 'p99>50ms,wrong>0' --json
  treeline-client bench --server 127.0.0.1:8080 --target connect \
      --scene room=recording --ramp-rate 10:100:+10 \
      --metrics http://127.0.0.1:8080/metrics --report bench.html
  treeline-client bench --server 127.0.0.1:50051 --scene room=recording \
      --scene lab=lab,lab/query.txt --encoding jpeg --encoding raw+raw --sweep

Exit codes: 0 done, 1 failed (also: an answer differed, or there was none), 2
wrong usage, 4 a condition of --fail-if holds, 130 interrupted, after what was
measured so far.

Figures of --fail-if, and their units:
)";

constexpr double kMetricsEvery_s = 1;

class Bench {
 public:
  Bench(const BenchFlags& flags, const std::vector<bench::WorkItem>& items,
        BenchLoad& load)
      : flags_(flags), load_(load) {
    report_.server = flags.connection.server;
    report_.target = flags.target_name;
    report_.processes = flags.processes;
    report_.conditions = flags.conditions;
    report_.metrics_url = flags.metrics_url;
    report_.machine = bench::DescribeMachine();
    report_.load_before = bench::LoadAverage();
    report_.workload = bench::Summarize(items);
    if (!flags.no_reference) {
      report_.reference_answers = static_cast<int>(items.size());
    }
  }

  absl::Status Run(const std::stop_token& stop) {
    TL_RETURN_IF_ERROR(load_.Prepare(stop));
    const absl::Status run = flags_.sweep ? Sweep(stop) : RunSteps(stop);
    report_.load_after = bench::LoadAverage();
    report_.all_calls = load_.AllCalls();
    return run;
  }

  void SetCourse(bench::Course course) { report_.course = std::move(course); }
  const bench::BenchReport& report() const { return report_; }

  // Whether there were answers, and none of them was another than before.
  bool Passed() const {
    return std::all_of(report_.runs.begin(), report_.runs.end(),
                       [](const bench::LoadRun& run) {
                         return run.tally.counts[0] > 0 &&
                                run.tally.checks.different == 0;
                       });
  }
  // Whether what --fail-if names was seen.
  bool ConditionHolds() const {
    return std::any_of(
        report_.runs.begin(), report_.runs.end(),
        [&](const bench::LoadRun& run) {
          return !bench::Failures(report_.conditions, run).empty();
        });
  }

 private:
  absl::Status RunOnce(const bench::LoadStep& step,
                       const std::stop_token& stop) {
    base::LiveDisplay display;
    if (flags_.processes > 1) {
      display.Show(absl::StrCat(flags_.processes, " processes, run ",
                                report_.runs.size() + 1));
    }
    TL_ASSIGN_OR_RETURN(
        bench::LoadRun run,
        load_.Run(step, stop, [&](const bench::Glance& glance, double at_s) {
          display.Show(bench::LiveLine(glance, at_s));
        }));
    report_.runs.push_back(std::move(run));
    return absl::OkStatus();
  }

  absl::Status RunSteps(const std::stop_token& stop) {
    for (const bench::LoadStep& step : flags_.steps) {
      if (stop.stop_requested()) break;
      TL_RETURN_IF_ERROR(RunOnce(step, stop));
    }
    return absl::OkStatus();
  }

  absl::Status Sweep(const std::stop_token& stop) {
    bench::LoadStep step = {.concurrency = flags_.load.concurrency,
                            .seed = flags_.load.seed};
    TL_RETURN_IF_ERROR(RunOnce(step, stop));
    report_.capacity_per_s = bench::Goodput_per_s(report_.runs.back());
    if (report_.capacity_per_s == 0) return absl::OkStatus();
    for (int percent = 10; percent <= 120; percent += 10) {
      if (stop.stop_requested()) break;
      step.rate_per_s = report_.capacity_per_s * percent / 100;
      TL_RETURN_IF_ERROR(RunOnce(step, stop));
    }
    return absl::OkStatus();
  }

  const BenchFlags& flags_;
  BenchLoad& load_;
  bench::BenchReport report_;
};

absl::Status WritePage(const BenchFlags& flags,
                       const bench::BenchReport& report) {
  if (flags.report_path.empty()) return absl::OkStatus();
  const std::string page_template = base::FindInstalledFile(
      "bench-report.html", TREELINE_SOURCE_BENCH_REPORT);
  if (page_template.empty()) {
    std::fputs(page::NoPageTemplateNotice(flags.report_path,
                                          "scripts/build-bench-report")
                   .c_str(),
               stderr);
  }
  return page::WritePage(flags.report_path, bench::BenchJson(report),
                         page_template);
}

int Finish(const BenchFlags& flags, const Bench& bench,
           const std::stop_token& stop) {
  std::fputs(flags.json ? (bench::BenchJson(bench.report()) + "\n").c_str()
                        : bench::BenchText(bench.report()).c_str(),
             stdout);
  if (!FlushOutput()) return kExitFailed;
  if (const absl::Status written = WritePage(flags, bench.report());
      !written.ok()) {
    return ReportLocalFailure(written);
  }
  if (stop.stop_requested()) return kExitInterrupted;
  if (!bench.Passed()) return kExitFailed;
  return bench.ConditionHolds() ? kExitConditionHolds : kExitLocalized;
}

int RunBench(BenchFlags flags, const std::stop_token& stop) {
  if (const absl::Status parsed = ParseBenchFlags(flags); !parsed.ok()) {
    ReportLocalFailure(parsed);
    return kExitUsage;
  }
  if (flags.worker >= 0) return RunBenchWorker(flags, stop);
  const auto items = bench::LoadWorkload(flags.workload);
  if (!items.ok()) return ReportLocalFailure(items.status());
  std::unique_ptr<BenchLoad> load;
  if (flags.processes > 1) {
    load = MakeLoadOfProcesses(flags);
  } else {
    auto own = MakeOwnLoad(flags, *items);
    if (!own.ok()) return ReportLocalFailure(own.status());
    load = *std::move(own);
  }
  std::optional<bench::ServerCourse> course;
  if (!flags.metrics_url.empty()) {
    auto source = MetricsSource::Open(flags.metrics_url,
                                      ConnectOptionsOf(flags.connection));
    if (!source.ok()) return ReportLocalFailure(source.status());
    // A wrong address is told before the load, not after it.
    if (const auto first = source->Fetch(); !first.ok()) {
      return ReportLocalFailure(first.status());
    }
    course.emplace([source = *std::move(source)] { return source.Fetch(); },
                   kMetricsEvery_s);
  }
  Bench bench(flags, *items, *load);
  const absl::Status run = bench.Run(stop);
  if (course) bench.SetCourse(course->Finish());
  if (!run.ok()) return ReportFailure(run, flags.connection, stop);
  return Finish(flags, bench, stop);
}

}  // namespace

ClientCommand AddBenchCommand(CLI::App& app) {
  auto flags = std::make_shared<BenchFlags>();
  CLI::App* command = app.add_subcommand(
      "bench", "Put a server under load and check its answers");
  command->footer(kFooter + bench::FigureHelp());
  AddBenchFlags(*command, *flags);
  return {command, [flags](const std::stop_token& stop) {
            return RunBench(*flags, stop);
          }};
}

}  // namespace treeline::client_cli

#include "client/cli/bench_flags.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "CLI/CLI.hpp"
#include "client/bench/ramp.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {
namespace {

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
  CLI::Option* rate =
      app.add_option("--rate", load.rate_per_s, "Open loop: calls per second")
          ->check(CLI::PositiveNumber);
  CLI::Option* sweep =
      app.add_flag("--sweep", flags.sweep,
                   "Measure the capacity, then offer 10 % to 120 % of it");
  CLI::Option* ramp_rate =
      app.add_option("--ramp-rate", flags.ramp_rate,
                     "Open loops, step by step: FROM:TO:+STEP, FROM:TO:xFACTOR "
                     "or A,B,C calls per second")
          ->type_name("RAMP");
  CLI::Option* ramp_concurrency =
      app.add_option("--ramp-concurrency", flags.ramp_concurrency,
                     "Closed loops of so many clients, step by step")
          ->type_name("RAMP");
  ramp_rate->excludes(rate)->excludes(sweep);
  ramp_concurrency->excludes(rate)->excludes(sweep)->excludes(ramp_rate);
  sweep->excludes(rate);
  app.add_option("--duration", load.duration_s, "Seconds to measure (each run)")
      ->capture_default_str();
  app.add_option("--warm-up", load.warm_up_s, "Seconds before that")
      ->capture_default_str();
  app.add_option("--deadline-ms", load.deadline_ms,
                 "Of each call, retries included")
      ->capture_default_str();
  app.add_option("--attempts", flags.attempts,
                 "How often a call is tried while the answer is UNAVAILABLE; "
                 "`localize` tries 4 times. gRPC alone")
      ->capture_default_str()
      ->check(CLI::Range(1, 5));
  app.add_option("--connections", flags.connections,
                 "Connections to each server, used in turn; 1 over gRPC. Over "
                 "HTTP the most at a time, 100")
      ->check(CLI::Range(1, 10000));
  app.add_option("--processes", flags.processes,
                 "Processes that generate the load together")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  app.add_option("--worker", flags.worker)->group("");  // not for people
  app.add_option("--cancel-share", load.cancel_share,
                 "Share of the calls that are cancelled")
      ->capture_default_str();
  app.add_option("--cancel-after-ms", load.cancel_after_ms,
                 "They are cancelled after 0 to this time")
      ->capture_default_str();
}

void AddResultFlags(CLI::App& app, BenchFlags& flags) {
  app.add_option("--interval-s", flags.load.interval_s,
                 "Length of the intervals in the results")
      ->capture_default_str();
  app.add_flag("--no-reference", flags.no_reference,
               "Do not ask for every answer before the load");
  app.add_option("--fail-if", flags.fail_if,
                 "Exit with 4 if any of these holds of any run: "
                 "'p99>50ms,wrong>0'")
      ->type_name("CONDITIONS");
  app.add_option("--metrics", flags.metrics_url,
                 "The server's own metrics, looked at every second: "
                 "http://HOST:PORT/metrics")
      ->type_name("URL");
  app.add_option("--report", flags.report_path,
                 "Write a page with charts: latency by throughput, the course "
                 "of every run, what the server says")
      ->type_name("FILE.html");
  app.add_flag("--json", flags.json, "One JSON object");
}

absl::Status ParseSteps(BenchFlags& flags) {
  const bench::LoadStep only = {.rate_per_s = flags.load.rate_per_s,
                                .concurrency = flags.load.concurrency,
                                .seed = flags.workload.seed};
  if (!flags.ramp_rate.empty()) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> ramp,
                        bench::ParseRamp(flags.ramp_rate));
    for (const double rate_per_s : ramp) {
      flags.steps.push_back(only);
      flags.steps.back().rate_per_s = rate_per_s;
    }
  } else if (!flags.ramp_concurrency.empty()) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> ramp,
                        bench::ParseRamp(flags.ramp_concurrency));
    for (const double clients : ramp) {
      flags.steps.push_back(only);
      flags.steps.back().concurrency =
          static_cast<int>(std::lround(std::min(clients, 1e5)));
      if (clients < 1) {
        return absl::InvalidArgumentError(
            "--ramp-concurrency begins with less than one client");
      }
    }
  } else if (!flags.sweep) {
    flags.steps.push_back(only);
  }
  for (const bench::LoadStep& step : flags.steps) {
    if (step.rate_per_s == 0 && step.concurrency < flags.processes) {
      return absl::InvalidArgumentError(
          "a closed loop needs a client for each of the --processes");
    }
  }
  return absl::OkStatus();
}

}  // namespace

void AddBenchFlags(CLI::App& app, BenchFlags& flags) {
  AddServerFlags(app, flags.connection);
  app.add_option("--target", flags.target_name,
                 "How the server is asked: grpc; connect or connect-json (the "
                 "Connect protocol over HTTP), geopose (the GeoPose Protocol); "
                 "with these --server is the HTTP listener")
      ->capture_default_str()
      ->type_name("TARGET");
  AddWorkloadFlags(app, flags);
  AddLoadFlags(app, flags);
  AddResultFlags(app, flags);
}

absl::Status ParseBenchFlags(BenchFlags& flags) {
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
  TL_ASSIGN_OR_RETURN(flags.target, bench::ParseTarget(flags.target_name));
  const bool http = flags.target != bench::Target::kGrpc;
  if (http && flags.load.stream_window > 0) {
    return absl::InvalidArgumentError("--stream needs --target grpc");
  }
  if (http && flags.attempts > 1) {
    return absl::InvalidArgumentError("--attempts needs --target grpc");
  }
  if (flags.connections == 0) flags.connections = http ? 100 : 1;
  if (!flags.fail_if.empty()) {
    TL_ASSIGN_OR_RETURN(flags.conditions,
                        bench::ParseFailConditions(flags.fail_if));
  }
  flags.load.seed = flags.workload.seed;
  TL_RETURN_IF_ERROR(flags.load.Validate());
  return ParseSteps(flags);
}

}  // namespace treeline::client_cli

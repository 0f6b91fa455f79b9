// A suite from beginning to end: places, runs, summary, JSON, pictures.
#ifndef EVALUATION_SUITES_SUITE_RUNNER_H_
#define EVALUATION_SUITES_SUITE_RUNNER_H_

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "evaluation/suites/suite_jobs.h"
#include "evaluation/suites/suite_options.h"
#include "evaluation/suites/suite_report.h"

namespace treeline::suites {

// One run.
struct SuiteJob {
  std::string world;
  uint64_t seed = 0;
  // A named one of the suite; empty: what the seed draws.
  std::string scene = {};
};

// Each world with each seed.
std::vector<SuiteJob> JobsOf(const std::vector<std::string>& worlds,
                             const std::vector<uint64_t>& seeds,
                             const std::string& scene = {});

// By the names of the jobs' worlds.
using SuitePlaces = std::map<std::string, std::shared_ptr<const SuitePlace>>;

// Checks that the suite's file can be written, then maps what the jobs need.
absl::StatusOr<SuitePlaces> PrepareSuite(
    const std::vector<SuiteJob>& jobs, const SuiteOptions& options,
    const std::function<SuiteMapOptions(const std::string& world)>& map_options,
    const std::stop_token& stop);

// Of one run, without a folder: "cafe-17".
struct RunPictureText {
  std::string stem;
  std::string title;
};

// Run derives from SuiteRun and says whether it IsGood().
template <typename Run>
struct Suite {
  // "missions"
  std::string name;
  std::vector<SuiteJob> jobs;
  std::function<absl::StatusOr<Run>(const SuiteJob&, const SuitePlace&)> run;
  // Of the runs that were done.
  std::function<std::string(const std::vector<Run>&)> summary;
  std::function<std::string(const std::vector<Run>&)> json;
  std::function<RunPictureText(const Run&)> picture;
};

// Pictures of the runs of which the options want some. Errors of writing.
template <typename Run>
absl::Status WritePictures(const Suite<Run>& suite, const SuitePlaces& places,
                           const SuiteOptions& options,
                           const std::vector<Run>& runs) {
  int written = 0;
  for (const Run& run : runs) {
    if (!options.WantsPicture(run.IsGood())) continue;
    const auto place = std::ranges::find_if(places, [&run](const auto& entry) {
      return entry.second->world().name == run.world;
    });
    if (place == places.end()) continue;
    const RunPictureText text = suite.picture(run);
    TL_RETURN_IF_ERROR(
        WriteRunPicture(absl::StrCat(options.folder, "/", text.stem),
                        place->second->world(), run, text.title));
    ++written;
  }
  if (written > 0) {
    std::printf("%d pictures and logs are in %s\n", written,
                options.folder.c_str());
  }
  return absl::OkStatus();
}

// Runs all jobs, prints the summary, writes what the options want. Interrupted,
// it does so with what it has. SuiteStatus, or errors of writing.
template <typename Run>
absl::Status RunSuite(const Suite<Run>& suite, const SuitePlaces& places,
                      const SuiteOptions& options,
                      const std::stop_token& stop) {
  const JobResults<Run> results = RunJobs<Run>(
      suite.jobs.size(), options.threads, suite.name, options.quiet, stop,
      [&](size_t i) -> absl::StatusOr<Run> {
        const SuiteJob& job = suite.jobs[i];
        absl::StatusOr<Run> run = suite.run(job, *places.at(job.world));
        if (run.ok()) return run;
        return base::Annotate(run.status(),
                              absl::StrCat(job.world, ", seed ", job.seed));
      });
  std::printf("%s", suite.summary(results.done).c_str());
  if (!options.json.empty()) {
    TL_RETURN_IF_ERROR(
        base::WriteFileAtomically(options.json, suite.json(results.done)));
  }
  TL_RETURN_IF_ERROR(WritePictures(suite, places, options, results.done));
  return SuiteStatus(results.done.size(), suite.jobs.size(),
                     GoodShare(results.done), options.require, results.errors,
                     results.first_error, stop);
}

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_RUNNER_H_

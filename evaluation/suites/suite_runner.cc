#include "evaluation/suites/suite_runner.h"

namespace treeline::suites {

std::vector<SuiteJob> JobsOf(const std::vector<std::string>& worlds,
                             const std::vector<uint64_t>& seeds,
                             const std::string& scene) {
  std::vector<SuiteJob> jobs;
  for (const std::string& world : worlds) {
    for (const uint64_t seed : seeds) jobs.push_back({world, seed, scene});
  }
  return jobs;
}

absl::StatusOr<SuitePlaces> PrepareSuite(
    const std::vector<SuiteJob>& jobs, const SuiteOptions& options,
    const std::function<SuiteMapOptions(const std::string& world)>& map_options,
    const std::stop_token& stop) {
  if (!options.json.empty()) {
    TL_RETURN_IF_ERROR(base::CheckWritable(options.json));
  }
  SuitePlaces places;
  for (const SuiteJob& job : jobs) {
    auto& place = places[job.world];
    if (place != nullptr) continue;
    TL_ASSIGN_OR_RETURN(place, PlaceForSuite(map_options(job.world), stop));
  }
  return places;
}

}  // namespace treeline::suites

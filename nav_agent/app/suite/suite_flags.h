// What suites of missions and of kidnaps are both asked with.
#ifndef NAV_AGENT_APP_SUITE_SUITE_FLAGS_H_
#define NAV_AGENT_APP_SUITE_SUITE_FLAGS_H_

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "evaluation/suites/suite_maps.h"

namespace treeline::suite_app {

struct SuiteFlags {
  std::vector<std::string> worlds;
  // For ParseSeedList.
  std::string seeds;
  bool people = false;
  // "perfect" or "driven".
  std::string maps;
  std::string cache = "out/suite";
  bool no_rear_laser = false;
  int threads = 0;
  // Share of good runs (0 to 1) below which the suite fails.
  double require = 0;
  std::string json = {};
  std::string folder;
  // "none", "failed" or "all".
  std::string pictures = "failed";
  bool quiet = false;

  bool WantsPicture(bool is_good) const {
    return pictures == "all" || (pictures == "failed" && !is_good);
  }
  suites::SuiteMapOptions MapOptions(const std::string& world) const;
};

// `run` is what one world and seed are called: "mission". Defaults are those
// that `flags` hold, which must outlive the command.
void AddSuiteFlags(CLI::App& command, const std::string& run,
                   SuiteFlags& flags);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_SUITE_FLAGS_H_

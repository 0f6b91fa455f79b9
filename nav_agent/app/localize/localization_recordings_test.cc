// AMCL from nothing on the real logs of Wean Hall.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "gtest/gtest.h"
#include "nav_agent/app/localize/localization_run.h"
#include "nav_agent/recording/wean_map.h"

namespace treeline::localize_app {
namespace {

std::string Folder() {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string folder =
      std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) +
      "/laser-wean";
  return std::filesystem::exists(folder) ? folder : "";
}

// Where a drive must end, as it does with every seed that was tried, and how
// well its scans fit from where the estimate converged.
struct WeanDrive {
  const char* log;
  geometry::Vec2 end;
  double agreement;
};

class WeanHall : public testing::TestWithParam<WeanDrive> {};

TEST_P(WeanHall, ConvergesFromNothing) {
  const std::string folder = Folder();
  if (folder.empty()) GTEST_SKIP() << "no laser-wean in TREELINE_DATA";
  LocalizationMap map;
  map.grids.push_back(*recording::ReadWeanMap(folder + "/wean.dat.gz"));
  const auto drive = ReadDrive(folder + "/" + GetParam().log);
  ASSERT_TRUE(drive.ok()) << drive.status();
  LocalizationRunOptions options;
  options.seed = 3;
  const auto result = LocalizeDrive(map, *drive, options, {}, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->converged_after_m.has_value());
  EXPECT_GT(result->agreement, GetParam().agreement);
  EXPECT_LT(
      geometry::Norm(result->scans.back().estimate.map_from_base.translation -
                     GetParam().end),
      0.5);
}

INSTANTIATE_TEST_SUITE_P(
    Logs, WeanHall,
    testing::Values(WeanDrive{"robotdata1.log.gz", {39.9, 41.5}, 0.8},
                    WeanDrive{"robotdata2.log.gz", {40.2, 42.4}, 0.8},
                    WeanDrive{"robotdata3.log.gz", {39.9, 40.0}, 0.85}));

}  // namespace
}  // namespace treeline::localize_app

#include "client/bench/machine.h"

#include <grpcpp/grpcpp.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <fstream>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/version.h"

namespace treeline::bench {
namespace {

std::string CpuModel() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const size_t colon = line.find(':');
    if (colon != std::string::npos && absl::StartsWith(line, "model name")) {
      const absl::string_view model =
          absl::StripAsciiWhitespace(absl::string_view(line).substr(colon + 1));
      return {model.data(), model.size()};
    }
  }
  return "";
}

}  // namespace

MachineFacts DescribeMachine() {
  MachineFacts facts{.cpu_model = CpuModel(),
                     .cores = base::HardwareThreads(),
                     .system = {},
                     .client_version = base::Version(),
                     .grpc_version = grpc::Version()};
  utsname system = {};
  if (uname(&system) == 0) {
    facts.system =
        absl::StrCat(system.sysname, " ", system.release, " ", system.machine);
  }
  return facts;
}

std::array<double, 3> LoadAverage() {
  std::array<double, 3> averages{};
  if (getloadavg(averages.data(), 3) != 3) averages.fill(0);
  return averages;
}

}  // namespace treeline::bench

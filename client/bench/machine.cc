#include "client/bench/machine.h"

#include <grpcpp/grpcpp.h>
#include <sys/utsname.h>

#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/processor_name.h"
#include "common/base/version.h"

namespace treeline::bench {

MachineFacts DescribeMachine() {
  MachineFacts facts{.cpu_model = base::ProcessorName(),
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

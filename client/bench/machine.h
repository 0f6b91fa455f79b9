// Where a measurement was made.
#ifndef CLIENT_BENCH_MACHINE_H_
#define CLIENT_BENCH_MACHINE_H_

#include <array>
#include <string>

namespace treeline::bench {

struct MachineFacts {
  std::string cpu_model;  // empty: not known
  int cores = 0;          // that this process may use
  std::string system;     // "Linux 6.1.0-18-amd64 x86_64"
  std::string client_version;
  std::string grpc_version;
};
MachineFacts DescribeMachine();

// Over 1, 5 and 15 minutes; zeros if it is not known.
std::array<double, 3> LoadAverage();

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_MACHINE_H_

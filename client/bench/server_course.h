// What a server's own metrics say while it is under load.
#ifndef CLIENT_BENCH_SERVER_COURSE_H_
#define CLIENT_BENCH_SERVER_COURSE_H_

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/scrape/server_figures.h"

namespace treeline::bench {

struct CoursePoint {
  double at_unix_s = 0;
  scrape::ServerFigures figures;
};

struct Course {
  std::vector<CoursePoint> points;
  // Looks that failed, and why the last of them did.
  int missed = 0;
  std::string last_error;
};

// Looks every `every_s` seconds, on a thread of its own, from its construction
// to Finish.
class ServerCourse {
 public:
  // The text of /metrics; called on that thread.
  using Fetch = std::function<absl::StatusOr<std::string>()>;
  ServerCourse(Fetch fetch, double every_s);

  // Ends it. To be called once.
  Course Finish();

 private:
  void Run(const std::stop_token& stop);
  void Look();

  const Fetch fetch_;
  const double every_s_;
  // Of the thread until it has ended.
  std::optional<scrape::MetricsSnapshot> last_;
  double last_unix_s_ = 0;
  Course course_;
  std::jthread thread_;  // the last: it uses the others
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_SERVER_COURSE_H_

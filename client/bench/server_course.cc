#include "client/bench/server_course.h"

#include <chrono>
#include <condition_variable>
#include <utility>

#include "client/scrape/metrics_text.h"

namespace treeline::bench {
namespace {

double UnixNow_s() {
  return std::chrono::duration<double>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

ServerCourse::ServerCourse(Fetch fetch, double every_s)
    : fetch_(std::move(fetch)),
      every_s_(every_s),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

Course ServerCourse::Finish() {
  thread_.request_stop();
  thread_.join();
  Look();
  return std::move(course_);
}

void ServerCourse::Run(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  const auto every = std::chrono::duration<double>(every_s_);
  do {
    Look();
  } while (!never.wait_for(lock, stop, every,
                           [&] { return stop.stop_requested(); }));
}

void ServerCourse::Look() {
  const absl::StatusOr<std::string> text = fetch_();
  absl::StatusOr<scrape::MetricsSnapshot> snapshot =
      text.ok() ? scrape::MetricsSnapshot::Parse(*text)
                : absl::StatusOr<scrape::MetricsSnapshot>(text.status());
  const double now_s = UnixNow_s();
  if (!snapshot.ok()) {
    ++course_.missed;
    course_.last_error = std::string(snapshot.status().message());
    return;
  }
  if (last_ && now_s > last_unix_s_) {
    course_.points.push_back(
        {.at_unix_s = now_s,
         .figures = scrape::FiguresBetween(*last_, *snapshot,
                                           now_s - last_unix_s_, now_s)});
  }
  last_ = *std::move(snapshot);
  last_unix_s_ = now_s;
}

}  // namespace treeline::bench

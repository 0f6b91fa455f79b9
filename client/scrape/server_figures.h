// How a server does, from two looks at its metrics.
#ifndef CLIENT_SCRAPE_SERVER_FIGURES_H_
#define CLIENT_SCRAPE_SERVER_FIGURES_H_

#include <map>
#include <string>

#include "client/scrape/metrics_text.h"

namespace treeline::scrape {

// Between two looks, and at the later one. NaN: nothing to say, for there was
// no query.
struct ServerFigures {
  // Queries answered, localized or not; calls of Localize turned away for too
  // much load, and those that ended with another error.
  double answers_per_s = 0;
  double shed_per_s = 0;
  double failed_per_s = 0;
  // Of the answers.
  double localized_share = 0;
  // From the arrival of the whole query to its answer, as far as the buckets
  // of the histogram tell.
  double p50_ms = 0;
  double p99_ms = 0;
  // Means by stage: queue, decode, sample, forest, pose.
  std::map<std::string, double> stage_ms;
  // At the later look.
  double queue_depth = 0;
  double queue_capacity = 0;
  double in_flight = 0;
  double workers = 0;
  double resident_bytes = 0;
  // Processor time, in processors.
  double processors = 0;
  // Scenes by state, and the answers of each scene per second.
  std::map<std::string, double> scenes;
  std::map<std::string, double> answers_per_s_by_scene;
  std::string version;
  double up_s = 0;
};

// Whether these are the metrics of a treeline-server.
bool IsServer(const MetricsSnapshot& metrics);

// A server that was started between the two counts from 0. `between_s` is
// positive; `now_unix_s` is the time of the later look.
ServerFigures FiguresBetween(const MetricsSnapshot& before,
                             const MetricsSnapshot& after, double between_s,
                             double now_unix_s);

}  // namespace treeline::scrape

#endif  // CLIENT_SCRAPE_SERVER_FIGURES_H_

// What an agent counts, for Prometheus. docs/reference/agent.md lists the
// figures.
#ifndef NAV_AGENT_SERVICE_AGENT_METRICS_H_
#define NAV_AGENT_SERVICE_AGENT_METRICS_H_

#include <cstdint>
#include <optional>
#include <string>

#include "common/metrics/registry.h"
#include "nav_agent/service/agent_hub.h"

namespace treeline::agent_service {

// Observe... by the stepping thread; the rest is thread-safe.
class AgentMetrics {
 public:
  AgentMetrics();

  // One control step: since the one before it began, and how long it took (s).
  void ObserveStep(std::optional<double> period_s, double step_s);
  void CountMissedDeadline() { missed_->Add(); }
  // Every event of the navigator.
  void CountEvent(const std::string& kind) { events_->With({kind}).Add(); }
  // What changed since the state that was observed before: goals and routes
  // that ended, waypoints, recoveries, times lost, fixes.
  void ObserveState(const AgentState& state);

  std::string Expose() const { return registry_.Expose(); }
  metrics::Registry& registry() { return registry_; }

 private:
  void ObserveGoal(const std::optional<behavior::GoalStatus>& goal);
  void ObserveFix(const behavior::NavigatorSnapshot& snapshot);
  void ObserveRoute(const std::optional<routes::RouteStatus>& route);
  void ObserveDocks(const DockReport& docks);

  metrics::Registry registry_;
  metrics::MetricFamily<metrics::Counter>* goals_;
  metrics::MetricFamily<metrics::Counter>* events_;
  metrics::MetricFamily<metrics::Counter>* fixes_;
  metrics::MetricFamily<metrics::Gauge>* devices_;
  metrics::MetricFamily<metrics::Gauge>* modes_;
  // Of a battery that tells, alone.
  metrics::MetricFamily<metrics::Gauge>* battery_volts_;
  metrics::MetricFamily<metrics::Gauge>* battery_charge_;
  metrics::MetricFamily<metrics::Counter>* dockings_;
  metrics::Counter* charge_trips_;
  metrics::Gauge* docked_;
  metrics::MetricFamily<metrics::Counter>* routes_;
  metrics::MetricFamily<metrics::Counter>* waypoints_;
  metrics::Counter* recoveries_;
  metrics::Counter* replans_;
  metrics::Counter* lost_;
  metrics::Counter* missed_;
  metrics::Gauge* lost_probability_;
  metrics::Gauge* driven_;
  metrics::Histogram* period_;
  metrics::Histogram* step_;
  metrics::Histogram* round_trip_;
  // ---- the stepping thread's ----
  uint64_t counted_goal_ = 0;
  // Of the goal that is watched.
  uint64_t goal_ = 0;
  int goal_recoveries_ = 0;
  int goal_replans_ = 0;
  double driven_before_m_ = 0;
  double goal_driven_m_ = 0;
  bool was_lost_ = false;
  std::optional<base::MonotonicTime> counted_fix_;
  std::string counted_verdict_;
  uint64_t counted_route_ = 0;
  // Of the route that is watched.
  uint64_t route_ = 0;
  int64_t route_reached_ = 0;
  int64_t route_missed_ = 0;
  uint64_t counted_docking_ = 0;
  int64_t counted_trips_ = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_AGENT_METRICS_H_

#include "nav_agent/app/bridge/bridge_run.h"

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/app/bridge/bridge_topics.h"
#include "nav_agent/bridge/place_finder/place_report.h"
#include "nav_agent/bridge/topic_inputs/topic_watch.h"

namespace treeline::bridge_app {
namespace {

// The server's answers are looked for so often.
constexpr auto kStep = std::chrono::milliseconds(20);
// As ROS 2's diagnostics come.
constexpr auto kReportInterval = std::chrono::seconds(1);

double ProcessorTime_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void SayIfNot(const absl::Status& status, logging::ProgramLog& log) {
  if (status.ok()) return;
  log.Say(logging::LogLevel::kError, std::string(status.message()));
}

void Loop(const BridgeConfig& config, BridgeTopics& topics,
          const RosClock& clock, place_finder::PlaceFinder& finder,
          logging::ProgramLog& log, const std::stop_token& stop) {
  const auto begin = std::chrono::steady_clock::now();
  auto next_report = begin;
  topic_inputs::TopicWatch watch(
      {config.odom, config.image, config.CameraInfoTopic(), config.depth,
       config.scan, config.map},
      /*tells_nobody=*/true);
  auto last_need = place_finder::Need::kNone;
  while (!stop.stop_requested()) {
    for (const topic_inputs::TopicInputs::Fault& fault :
         topics.inputs().Deliver(kStep)) {
      log.Say(logging::LogLevel::kWarn,
              absl::StrCat(fault.topic, ": ", fault.why.message()));
    }
    for (const std::string& complaint :
         watch.Look(topics.inputs(), std::chrono::steady_clock::now())) {
      log.Say(logging::LogLevel::kWarn, complaint);
    }
    const place_finder::PlaceFinder::Output output = finder.Step(clock.Now());
    for (const std::string& event : output.events) {
      log.Say(logging::LogLevel::kInfo, event);
    }
    if (output.initial_pose.has_value()) {
      SayIfNot(topics.Publish(*output.initial_pose), log);
    }
    const auto now = std::chrono::steady_clock::now();
    if (now >= next_report || finder.state().need != last_need) {
      last_need = finder.state().need;
      next_report = now + kReportInterval;
      SayIfNot(topics.Publish(place_finder::ReportOf(
                   finder.state(), conversions::StampOf(clock.Now()))),
               log);
    }
    if (config.duration > 0 &&
        base::SecondsBetween(begin, now) > config.duration) {
      return;
    }
  }
}

}  // namespace

absl::Status RunBridge(
    const BridgeConfig& config, const SensorsOfFile& sensors,
    core::RelocalizationPort& server, logging::ProgramLog& log,
    const std::function<void(const std::string& line)>& announce,
    const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(config.Validate());
  TL_ASSIGN_OR_RETURN(const place_finder::PlaceFinderOptions options,
                      config.PlaceFinder(sensors));
  TL_ASSIGN_OR_RETURN(const dds::NodeName name, config.Node());
  TL_ASSIGN_OR_RETURN(const dds::DomainOptions domain_options,
                      config.Domain(std::getenv("ROS_DOMAIN_ID")));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<dds::Domain> domain,
                      dds::Domain::Join(domain_options));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<dds::Node> node,
                      dds::Node::Create(*domain, name));
  place_finder::PlaceFinder finder(server, options);
  RosClock clock(config.use_sim_time);
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<BridgeTopics> topics,
                      BridgeTopics::Open(*node, config, finder, clock));
  announce(absl::StrCat("bridge in domain ", domain->id()));
  Loop(config, *topics, clock, finder, log, stop);
  log.Write(logging::LogLevel::kInfo,
            log.Event()
                .Word("event", "stopped")
                .Integer("messages", topics->inputs().delivered())
                .Number("delivery_p50_ms", topics->inputs().Delivery_ms(0.5))
                .Number("delivery_p99_ms", topics->inputs().Delivery_ms(0.99))
                .Number("processor_s", ProcessorTime_s())
                .Integer("questions", finder.state().questions)
                .Integer("places", finder.state().places));
  return absl::OkStatus();
}

}  // namespace treeline::bridge_app

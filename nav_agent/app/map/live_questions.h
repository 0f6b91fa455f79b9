// A robot that was carried off while it maps asks the server that learns the
// scene meanwhile.
#ifndef NAV_AGENT_APP_MAP_LIVE_QUESTIONS_H_
#define NAV_AGENT_APP_MAP_LIVE_QUESTIONS_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/mapping/online_mapper.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {

struct LiveQuestionOptions {
  // Between two questions, of the frames' time; and for an answer (s).
  double every_s = 0.5;
  double timeout_s = 3;
  // Ground was driven on this near to where an answer puts the robot (m).
  double near_m = 3;
  behavior::FixGateOptions gate;
  // Told when the robot is lost, found, and what the server says.
  std::function<void(const std::string& line)> say = [](const std::string&) {};
};

struct LiveQuestionStatus {
  int64_t asked = 0;
  int64_t answered = 0;
  int64_t suggested = 0;  // that the gate lets through to the scans
};

// What the gate says of an answer while the map is made, with the base where it
// puts that: of the server's own
// doubts, gravity, and the ground that was driven on. What scans say of it
// comes later, over a metre of the way, so that it is weak at best.
behavior::FixJudgement JudgeWhileMapping(
    const core::RelocalizationAnswer& answer,
    const geometry::Rigid3& map_from_base,
    const geometry::Rotation3& level_from_base,
    const std::vector<dataset::TimedPose>& driven,
    const LiveQuestionOptions& options);

// Not thread-safe.
class LiveQuestions {
 public:
  // server must outlive it.
  LiveQuestions(core::RelocalizationPort& server,
                const LiveQuestionOptions& options)
      : server_(&server), options_(options) {}

  // A frame with its calibration, of the mapper's time: is asked about if the
  // robot is lost, and it is time to.
  void Add(const core::RgbdFrame& frame, const mapping::OnlineMapper& mapper);
  // Takes an answer, if one has come, and suggests it to the mapper. What is to
  // be written into the log, so that it can be mapped again.
  std::optional<recording::LogEvent> Step(
      mapping::OnlineMapper& mapper, const geometry::Rigid3& base_from_camera);

  const LiveQuestionStatus& status() const { return status_; }

 private:
  void Tell(const mapping::OnlineMapper& mapper);

  core::RelocalizationPort* server_;
  const LiveQuestionOptions options_;
  LiveQuestionStatus status_;
  bool was_lost_ = false;
  bool has_failed_ = false;
  std::optional<base::MonotonicTime> asked_;
  // Of the inertial sensor, when it was asked.
  geometry::Rotation3 level_from_base_;
};

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_LIVE_QUESTIONS_H_

// A simulated robot with tracker and recovery, and a server that is made up:
// for tests.
#ifndef TESTS_ROBOT_TESTING_LOST_ROBOT_H_
#define TESTS_ROBOT_TESTING_LOST_ROBOT_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/simulator.h"

namespace treeline {

// A world with all that is made from it, once for many tests.
struct LostPlace {
  std::string world;
  octree::VoxelMap voxels;
  traversability::TraversableMap levels;
  std::shared_ptr<const traversability::NavigationMap> map;
};
const LostPlace& LostPlaceOf(const std::string& world);

// Answers as it is told, so long after the question.
class ScriptedServer final : public core::RelocalizationPort {
 public:
  using Answer = absl::StatusOr<core::RelocalizationAnswer>;
  explicit ScriptedServer(const base::Clock& clock) : clock_(clock) {}

  // Called with the frame that was asked about.
  std::function<Answer(const core::RgbdFrame&)> answers;
  double delay_s = 0.2;
  int asked = 0;

  void Ask(const core::RgbdFrame& frame, double timeout_s) override;
  std::optional<Answer> TakeAnswer() override;
  bool IsAsking() const override { return frame_.has_value(); }
  void Cancel() override { frame_.reset(); }

 private:
  const base::Clock& clock_;
  std::optional<core::RgbdFrame> frame_;
  double timeout_s_ = 0;
  base::MonotonicTime asked_at_;
};

class LostRobot {
 public:
  LostRobot(const LostPlace& place, uint64_t seed, bool with_people,
            const behavior::RelocalizationBehaviorOptions& options,
            bool with_server = true);

  simulator::Simulator& simulator() { return *simulator_; }
  localization::RobotTracker& tracker() { return *tracker_; }
  behavior::RelocalizationBehavior& lost() { return *lost_; }
  ScriptedServer& server() { return *server_; }
  base::MonotonicTime Now() const { return simulator_->clock().Now(); }

  core::LevelPose Truth() const;
  geometry::Rigid3 TruthAt(base::MonotonicTime stamp) const;
  // What an honest server says: the truth, a little wrong.
  core::RelocalizationAnswer TrueAnswer(const core::RgbdFrame& frame,
                                        double confidence);
  core::RelocalizationAnswer AnswerFor(const geometry::Rigid3& map_from_base,
                                       const core::RgbdFrame& frame,
                                       double confidence);
  void TellTruth();
  // Somewhere with room: anywhere in the world. False: none was found.
  bool CarryAway(uint64_t seed);

  // 25 ms: senses, thinks, moves. `drives` what a robot does that is not lost.
  behavior::RelocalizationBehavior::Output Step(
      const core::VelocityCommand& drives = {});
  // Until it is found or needs help, or for so long (s). The state then.
  behavior::RelocalizationState StepUntilDone(double at_most_s);
  double Error_m() const;
  double Error_rad() const;
  bool IsRight() const;

  std::vector<behavior::RelocalizationNote> notes;

 private:
  void Feed();

  const LostPlace& place_;
  std::unique_ptr<simulator::Simulator> simulator_;
  std::unique_ptr<localization::RobotTracker> tracker_;
  std::unique_ptr<ScriptedServer> server_;
  std::unique_ptr<behavior::RelocalizationBehavior> lost_;
  base::Random random_;
  int64_t steps_ = 0;
};

}  // namespace treeline

#endif  // TESTS_ROBOT_TESTING_LOST_ROBOT_H_

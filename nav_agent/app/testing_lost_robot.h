// A simulated robot with tracker and recovery, and a server that is made up:
// for tests.
#ifndef NAV_AGENT_APP_TESTING_LOST_ROBOT_H_
#define NAV_AGENT_APP_TESTING_LOST_ROBOT_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nav_agent/behavior/lost_and_found.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/sim/scenario.h"
#include "nav_agent/sim/simulator.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline {

// A world with all that is made from it, once for many tests.
struct LostPlace {
  std::string world;
  VoxelMap voxels;
  TraversableMap levels;
  std::shared_ptr<const NavigationMap> map;
};
const LostPlace& LostPlaceOf(const std::string& world);

// Answers as it is told, so long after the question.
class MadeUpServer final : public RelocalizationPort {
 public:
  using Answer = absl::StatusOr<RelocalizationAnswer>;
  explicit MadeUpServer(const Clock& clock) : clock_(clock) {}

  // Called with the frame that was asked about.
  std::function<Answer(const RgbdFrame&)> answers;
  double delay_s = 0.2;
  int asked = 0;

  void Ask(const RgbdFrame& frame, double timeout_s) override;
  std::optional<Answer> TakeAnswer() override;
  bool IsAsking() const override { return frame_.has_value(); }
  void Cancel() override { frame_.reset(); }

 private:
  const Clock& clock_;
  std::optional<RgbdFrame> frame_;
  double timeout_s_ = 0;
  MonotonicTime asked_at_;
};

class LostRobot {
 public:
  LostRobot(const LostPlace& place, uint64_t seed, bool with_people,
            const LostAndFoundOptions& options, bool with_server = true);

  Simulator& simulator() { return *simulator_; }
  RobotTracker& tracker() { return *tracker_; }
  LostAndFound& lost() { return *lost_; }
  MadeUpServer& server() { return *server_; }
  MonotonicTime Now() const { return simulator_->clock().Now(); }

  LevelPose Truth() const;
  Rigid3 TruthAt(MonotonicTime stamp) const;
  // What an honest server says: the truth, a little wrong.
  RelocalizationAnswer TrueAnswer(const RgbdFrame& frame, double confidence);
  RelocalizationAnswer AnswerFor(const Rigid3& map_from_base,
                                 const RgbdFrame& frame, double confidence);
  void TellTruth();
  // Somewhere with room: anywhere in the world. False: none was found.
  bool CarryAway(uint64_t seed);

  // 25 ms: senses, thinks, moves. `drives` what a robot does that is not lost.
  LostAndFound::Output Step(const VelocityCommand& drives = {});
  // Until it is found or needs help, or for so long (s). The state then.
  RecoveryState StepUntilDone(double at_most_s);
  double Error_m() const;
  double Error_rad() const;
  bool IsRight() const;

  std::vector<RecoveryNote> notes;

 private:
  void Feed();

  const LostPlace& place_;
  std::unique_ptr<Simulator> simulator_;
  std::unique_ptr<RobotTracker> tracker_;
  std::unique_ptr<MadeUpServer> server_;
  std::unique_ptr<LostAndFound> lost_;
  Random random_;
  int64_t steps_ = 0;
};

}  // namespace treeline

#endif  // NAV_AGENT_APP_TESTING_LOST_ROBOT_H_

// Loops that would bend the map: followed before they are believed.
#ifndef NAV_AGENT_MAPPING_LOOP_SUSPECTS_H_
#define NAV_AGENT_MAPPING_LOOP_SUSPECTS_H_

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/pose_graph.h"
#include "nav_agent/mapping/scan_agreement.h"

namespace treeline::mapping {

// A keyscan that was found among others, and what these tell of its place.
struct LoopLink {
  PoseConstraint constraint;
  bool wide = false;
  // Between the scan and the others, where the loop puts it and where the graph
  // did.
  Contradictions there = {};
  Contradictions otherwise = {};
};

struct LoopSuspectOptions {
  // A loop that moves the robot by more than this is followed (m) ...
  double moved_m = 0.6;
  // ... until so many later scans are found where it puts them, over at least
  // follow_m of the way (m). It is given up after give_up_m.
  int min_followed = 3;
  double follow_m = 1.5;
  double give_up_m = 8;
  // Of what scans can tell of each other, so much more (a share of it) than
  // where the graph has them may stand where the other looked through.
  double max_contradicted = 0.04;

  bool IsValid() const;
  bool IsContradicted(const Contradictions& there,
                      const Contradictions& otherwise) const {
    return there.contradicted >
           otherwise.contradicted + max_contradicted * there.told;
  }
};

// What a later keyscan says of a loop, where that puts it.
struct FollowedKeyscan {
  std::optional<LoopLink> found;
  bool is_contradicted = false;
};

class LoopSuspects {
 public:
  explicit LoopSuspects(const LoopSuspectOptions& options)
      : options_(options) {}

  // Whether the loop would move the robot so far that it is to be followed.
  // poses: of all keyscans, map_from_keyscan.
  bool IsSuspect(const LoopLink& link,
                 std::span<const geometry::Rigid2> poses) const;
  // Adds a loop to those that are followed; false: one of them says the same.
  bool Add(const LoopLink& link, std::span<const geometry::Rigid2> poses);
  // Looks for a new keyscan where each of them puts it.
  void Follow(int keyscan, std::span<const geometry::Rigid2> poses,
              const std::function<FollowedKeyscan(
                  const geometry::Rigid2& map_from_keyscan)>& look);
  // The links of the one that was found most often, if any is confirmed; then
  // all are forgotten, since the map will change. Else none. way_m: along the
  // drive, of all keyscans. is_last_chance: nothing more will be seen.
  std::vector<LoopLink> TakeConfirmed(std::span<const double> way_m,
                                      bool is_last_chance);
  // Those that were followed in vain; how many they were.
  int GiveUp(std::span<const double> way_m);

 private:
  struct Suspect {
    std::vector<LoopLink> links;  // the first one is what is suspected
    int against = 0;  // keyscans that are contradicted where it puts them
  };

  static geometry::Rigid2 PlaceIf(const Suspect& suspect, int keyscan,
                                  std::span<const geometry::Rigid2> poses);
  static double Followed_m(const Suspect& suspect,
                           std::span<const double> way_m);
  bool IsConfirmed(const Suspect& suspect, std::span<const double> way_m,
                   bool is_last_chance) const;

  LoopSuspectOptions options_;
  std::vector<Suspect> suspects_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LOOP_SUSPECTS_H_

#include "nav_agent/planning/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <queue>
#include <vector>

#include "nav_agent/planning/path_improver.h"

namespace treeline {
namespace {

constexpr int kHeadings = 16;
// By angle.
constexpr std::array<CellIndex, kHeadings> kSteps = {{{1, 0},
                                                      {2, 1},
                                                      {1, 1},
                                                      {1, 2},
                                                      {0, 1},
                                                      {-1, 2},
                                                      {-1, 1},
                                                      {-2, 1},
                                                      {-1, 0},
                                                      {-2, -1},
                                                      {-1, -1},
                                                      {-1, -2},
                                                      {0, -1},
                                                      {1, -2},
                                                      {1, -1},
                                                      {2, -1}}};
constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr int kStopEvery = 256;
// What is left to go counts so much more than what was gone: fewer places are
// looked at, and ways are improved anyway.
constexpr float kGreed = 1.5F;
// From so near (m) straight lines to the goal are tried, which need a turn of
// at most this (rad): other headings are of other nodes.
constexpr double kLastLine_m = 1.0;
constexpr double kLastTurn_rad = 0.6;

double YawOf(int heading) {
  const CellIndex& step = kSteps[static_cast<size_t>(heading)];
  return std::atan2(step.y, step.x);
}

struct Open {
  float estimate_m = 0;
  uint32_t number = 0;
};
struct IsWorse {
  bool operator()(const Open& a, const Open& b) const {
    return a.estimate_m != b.estimate_m ? a.estimate_m > b.estimate_m
                                        : a.number > b.number;
  }
};
using Queue = std::priority_queue<Open, std::vector<Open>, IsWorse>;

// Nodes are places, one in each cell, with the heading that they were driven to
// with: number = (level * cells + cell) * headings + heading.
class Lattice {
 public:
  Lattice(const DriveSpace& space, const Stand& start, const Stand& goal)
      : space_(&space),
        ground_(&space.ground()),
        start_(start),
        goal_(goal),
        offset_(start.spot.at -
                ground_->CenterOf(ground_->CellOf(start.spot.at))),
        places_(ground_->cells() * static_cast<size_t>(ground_->levels())) {}

  Polyline Run(const std::function<bool()>& is_over) {
    if (!EstimateAll(is_over)) return {};
    cost_m_.assign(places_ * kHeadings, kFar);
    parent_.assign(places_ * kHeadings, kNone);
    turns_.assign(places_ * kHeadings, kUnknown);
    Begin();
    for (int count = 0; !open_.empty(); ++count) {
      if (count % kStopEvery == 0 && is_over()) return {};
      const Open next = open_.top();
      open_.pop();
      if (is_done_[next.number]) continue;
      is_done_[next.number] = true;
      if (LeadsToGoal(next.number)) return WayTo(next.number);
      Expand(next.number);
    }
    return {};
  }

 private:
  static constexpr uint8_t kUnknown = 0;
  static constexpr uint8_t kCan = 1;
  static constexpr uint8_t kCannot = 2;

  size_t PlaceOf(int level, CellIndex cell) const {
    return static_cast<size_t>(level) * ground_->cells() +
           ground_->IndexOf(cell);
  }
  CellIndex CellOf(size_t place) const {
    const size_t cell = place % ground_->cells();
    const auto width = static_cast<size_t>(ground_->width());
    return {static_cast<int>(cell % width), static_cast<int>(cell / width)};
  }
  int LevelOf(size_t place) const {
    return static_cast<int>(place / ground_->cells());
  }
  Spot SpotOf(size_t place) const {
    return {ground_->CenterOf(CellOf(place)) + offset_, LevelOf(place)};
  }

  // The inscribed disc's way to the goal from everywhere, by Dijkstra. False if
  // it is over.
  bool EstimateAll(const std::function<bool()>& is_over) {
    estimate_m_.assign(places_, kFar);
    Queue open;
    const size_t goal =
        PlaceOf(goal_.spot.level, ground_->CellOf(goal_.spot.at));
    estimate_m_[goal] = 0;
    open.push({0, static_cast<uint32_t>(goal)});
    for (int count = 0; !open.empty(); ++count) {
      if (count % kStopEvery == 0 && is_over()) return false;
      const Open next = open.top();
      open.pop();
      if (next.estimate_m > estimate_m_[next.number]) continue;
      const CellIndex cell = CellOf(next.number);
      for (const CellIndex& step : kSteps) {
        const CellIndex to = {cell.x + step.x, cell.y + step.y};
        const int level = ground_->LevelAfter(LevelOf(next.number), cell, to);
        if (level < 0 || !space_->MayHoldDisc({ground_->CenterOf(to), level})) {
          continue;
        }
        const float cost_m =
            next.estimate_m + static_cast<float>(ground_->resolution_m() *
                                                 std::hypot(step.x, step.y));
        const size_t place = PlaceOf(level, to);
        if (cost_m >= estimate_m_[place]) continue;
        estimate_m_[place] = cost_m;
        open.push({cost_m, static_cast<uint32_t>(place)});
      }
    }
    return true;
  }

  void Begin() {
    is_done_.assign(places_ * kHeadings, false);
    const size_t place =
        PlaceOf(start_.spot.level, ground_->CellOf(start_.spot.at));
    for (int heading = 0; heading < kHeadings; ++heading) {
      if (!space_->CanTurn(start_.spot, start_.yaw_rad, YawOf(heading))) {
        continue;
      }
      Reach(kNone, place, heading,
            static_cast<float>(TurnCost_m(start_.yaw_rad, YawOf(heading))));
    }
  }

  void Reach(uint32_t from, size_t place, int heading, float cost_m) {
    const size_t number = place * kHeadings + static_cast<size_t>(heading);
    if (cost_m >= cost_m_[number] || !std::isfinite(estimate_m_[place])) {
      return;
    }
    cost_m_[number] = cost_m;
    parent_[number] = from;
    open_.push(
        {cost_m + kGreed * estimate_m_[place], static_cast<uint32_t>(number)});
  }

  // Whether it turns there from a heading to the next one to the left.
  bool CanTurnLeft(size_t place, int heading) {
    uint8_t& known = turns_[place * kHeadings + static_cast<size_t>(heading)];
    if (known == kUnknown) {
      known = space_->CanTurn(SpotOf(place), YawOf(heading),
                              YawOf((heading + 1) % kHeadings))
                  ? kCan
                  : kCannot;
    }
    return known == kCan;
  }

  void Expand(uint32_t from) {
    const size_t place = from / kHeadings;
    const auto heading = static_cast<int>(from % kHeadings);
    DriveOn(from, place, heading);
    for (const int side : {1, -1}) {
      int turned = heading;
      for (int i = 0; i < kHeadings / 2; ++i) {
        const int next = (turned + side + kHeadings) % kHeadings;
        if (!CanTurnLeft(place, side > 0 ? turned : next)) break;
        turned = next;
        DriveOn(from, place, turned);
      }
    }
  }

  // A step from a node along a heading that it can be turned to.
  void DriveOn(uint32_t from, size_t place, int heading) {
    const CellIndex& step = kSteps[static_cast<size_t>(heading)];
    const CellIndex cell = CellOf(place);
    const CellIndex next = {cell.x + step.x, cell.y + step.y};
    const int level = ground_->LevelAfter(LevelOf(place), cell, next);
    if (level < 0) return;
    const size_t to = PlaceOf(level, next);
    if (is_done_[to * kHeadings + static_cast<size_t>(heading)]) return;
    const Spot spot = SpotOf(place);
    const Spot end = {ground_->CenterOf(next) + offset_, level};
    const auto cost_m = static_cast<float>(
        TurnCost_m(YawOf(static_cast<int>(from % kHeadings)), YawOf(heading)) +
        ground_->resolution_m() * std::hypot(step.x, step.y) *
            (space_->CostPerMetre(spot) + space_->CostPerMetre(end)) / 2);
    if (cost_m_[from] + cost_m >=
        cost_m_[to * kHeadings + static_cast<size_t>(heading)]) {
      return;
    }
    const std::optional<Spot> driven = space_->Drive(spot, end.at);
    if (!driven.has_value() || driven->level != level) return;
    Reach(from, to, heading, cost_m_[from] + cost_m);
  }

  bool LeadsToGoal(uint32_t from) const {
    const Spot spot = SpotOf(from / kHeadings);
    const Vec2 line = goal_.spot.at - spot.at;
    const double length_m = Norm(line);
    if (spot.level != goal_.spot.level || length_m > kLastLine_m) return false;
    const double yaw_rad = YawOf(static_cast<int>(from % kHeadings));
    if (length_m < 1e-6) {
      return space_->CanTurn(spot, yaw_rad, goal_.yaw_rad);
    }
    const double line_rad = std::atan2(line.y, line.x);
    if (std::abs(NormalizedAngle_rad(line_rad - yaw_rad)) > kLastTurn_rad) {
      return false;
    }
    const std::optional<Spot> end = space_->Drive(spot, goal_.spot.at);
    return end.has_value() && end->level == goal_.spot.level &&
           space_->CanTurn(spot, yaw_rad, line_rad) &&
           space_->CanTurn(*end, line_rad, goal_.yaw_rad);
  }

  // Through the places where the heading changes.
  Polyline WayTo(uint32_t last) const {
    Polyline way = {goal_.spot};
    if (Norm(SpotOf(last / kHeadings).at - goal_.spot.at) > 1e-6) {
      way.push_back(SpotOf(last / kHeadings));
    }
    for (uint32_t at = last; parent_[at] != kNone; at = parent_[at]) {
      const uint32_t before = parent_[at];
      const bool is_corner =
          parent_[before] == kNone || before % kHeadings != at % kHeadings ||
          LevelOf(before / kHeadings) != LevelOf(at / kHeadings);
      if (is_corner) way.push_back(SpotOf(before / kHeadings));
    }
    std::ranges::reverse(way);
    return way;
  }

  const DriveSpace* space_;
  const GroundIndex* ground_;
  Stand start_;
  Stand goal_;
  // From cells' centres to the places: one of them is the start.
  Vec2 offset_;
  size_t places_;
  // One a place.
  std::vector<float> estimate_m_;
  // One a node.
  std::vector<float> cost_m_;
  std::vector<uint32_t> parent_;
  std::vector<uint8_t> turns_;
  std::vector<bool> is_done_;
  Queue open_;
};

}  // namespace

Polyline SearchLattice(const DriveSpace& space, const Stand& start,
                       const Stand& goal,
                       const std::function<bool()>& is_over) {
  return Lattice(space, start, goal).Run(is_over);
}

}  // namespace treeline

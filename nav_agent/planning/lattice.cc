#include "nav_agent/planning/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/planning/cell_steps.h"
#include "nav_agent/planning/open_nodes.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/planner_parameters.h"
#include "nav_agent/planning/routes.h"

namespace treeline::planning {
namespace {

constexpr auto kHeadings = static_cast<int>(kCellSteps.size());
constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
static_assert(kHeadings == 16, "a flood's bits");
constexpr size_t kNowhere = std::numeric_limits<size_t>::max();

double YawOf(int heading) {
  const core::CellIndex& step = kCellSteps[static_cast<size_t>(heading)];
  return std::atan2(step.y, step.x);
}

// Nodes are places, one in each cell, with a heading to stand there with:
// number = (level * cells + cell) * headings + heading. Edges are steps ahead
// and turns to the next heading.
class Lattice {
 public:
  Lattice(const ConfigurationSpace& space, const Regions& regions,
          const Stand& start, const Stand& goal, double reach_m, double weight,
          const std::function<bool()>& is_over)
      : space_(&space),
        ground_(&space.ground()),
        is_over_(&is_over),
        weight_(static_cast<float>(weight)),
        start_(start),
        goal_(goal),
        offset_(start.spot.at -
                ground_->CenterOf(ground_->CellOf(start.spot.at))),
        places_(ground_->cells() * static_cast<size_t>(ground_->levels())),
        distance_(*ground_, regions, goal.spot, static_cast<float>(reach_m)),
        pages_(places_ / kPagePlaces + 1) {
    for (size_t heading = 0; heading < kHeadings; ++heading) {
      step_m_[heading] = static_cast<float>(
          ground_->resolution_m() *
          std::hypot(kCellSteps[heading].x, kCellSteps[heading].y));
    }
  }

  Polyline Run() {
    FindEnds();
    if (starts_.empty() || ends_.empty()) return {};
    return MayBeReached() ? Search() : Polyline();
  }

  // Without asking first whether there is a way out of the goal's niche.
  Polyline RunNear() {
    FindEnds();
    return starts_.empty() || ends_.empty() ? Polyline() : Search();
  }

 private:
  Polyline Search() {
    for (const uint32_t number : starts_) {
      const double yaw_rad = YawOf(HeadingOf(number));
      Reach(kNone, number,
            static_cast<float>(TurnCost_m(start_.yaw_rad, yaw_rad)));
    }
    for (int count = 0; !open_.empty(); ++count) {
      if (count % kStopEvery == 0 && (*is_over_)()) return {};
      if (count == kFloodAfter && !MayReach()) return {};
      const OpenNode next = open_.top();
      open_.pop();
      Node& node = NodeOf(next.number);
      if (node.is_done) continue;
      node.is_done = true;
      if (node.is_end) return WayTo(next.number);
      Expand(next.number);
    }
    return {};
  }

  static constexpr uint8_t kUnknown = 0;
  static constexpr uint8_t kCan = 1;
  static constexpr uint8_t kCannot = 2;
  static constexpr float kNotAsked = -1;
  static constexpr size_t kPagePlaces = 16;

  struct Node {
    float cost_m = kFar;
    uint32_t parent = kNone;
    // Whether it turns there to the next heading to the left.
    uint8_t turns = kUnknown;
    bool is_done = false;
    bool is_end = false;
    // From the goal, back.
    bool is_found = false;
  };
  struct Place {
    float room_m = kNotAsked;
    float estimate_m = kNotAsked;
    std::array<Node, kHeadings> nodes;
  };
  using Page = std::array<Place, kPagePlaces>;

  // Places come into being when they are first asked for: a search looks at few
  // of a large map's.
  Place& At(size_t place) {
    std::unique_ptr<Page>& page = pages_[place / kPagePlaces];
    if (page == nullptr) page = std::make_unique<Page>();
    return (*page)[place % kPagePlaces];
  }
  Node& NodeOf(uint32_t number) {
    return At(number / kHeadings).nodes[number % kHeadings];
  }

  size_t PlaceOf(int level, core::CellIndex cell) const {
    return static_cast<size_t>(level) * ground_->cells() +
           ground_->IndexOf(cell);
  }
  core::CellIndex CellOf(size_t place) const {
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
  static int HeadingOf(uint32_t number) {
    return static_cast<int>(number % kHeadings);
  }
  static uint32_t NumberOf(size_t place, int heading) {
    return static_cast<uint32_t>(place * kHeadings +
                                 static_cast<size_t>(heading));
  }

  // ConfigurationSpace's, asked once.
  double RoomAt_m(size_t place) {
    float& room_m = At(place).room_m;
    if (room_m == kNotAsked) {
      // Rounded down.
      room_m = static_cast<float>(space_->RoomAtLeast_m(SpotOf(place))) *
               (1 - std::numeric_limits<float>::epsilon());
    }
    return room_m;
  }

  // Nodes that it may begin and end with.
  void FindEnds() {
    const size_t start =
        PlaceOf(start_.spot.level, ground_->CellOf(start_.spot.at));
    for (int heading = 0; heading < kHeadings; ++heading) {
      if (space_->CanTurn(start_.spot, start_.yaw_rad, YawOf(heading))) {
        starts_.push_back(NumberOf(start, heading));
      }
    }
    const core::CellIndex middle = ground_->CellOf(goal_.spot.at);
    const int reach =
        static_cast<int>(kLastLine_m / ground_->resolution_m()) + 1;
    for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
      for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
        if (!ground_->Contains({x, y})) continue;
        for (int level = 0; level < ground_->levels(); ++level) {
          FindEndsAt(PlaceOf(level, {x, y}));
        }
      }
    }
  }

  void FindEndsAt(size_t place) {
    const Spot spot = SpotOf(place);
    const geometry::Vec2 line = goal_.spot.at - spot.at;
    const double length_m = geometry::Norm(line);
    if (length_m > kLastLine_m ||
        !space_->MayHoldDisc({ground_->CenterOf(CellOf(place)), spot.level})) {
      return;
    }
    const bool is_there = length_m < 1e-6;
    const double line_rad =
        is_there ? goal_.yaw_rad : std::atan2(line.y, line.x);
    if (is_there ? spot.level != goal_.spot.level
                 : !LeadsToGoal(spot, line_rad)) {
      return;
    }
    for (int heading = 0; heading < kHeadings; ++heading) {
      const double turn_rad =
          std::abs(geometry::NormalizedAngle_rad(line_rad - YawOf(heading)));
      if ((!is_there && turn_rad > kLastTurn_rad) ||
          !space_->CanTurn(spot, YawOf(heading), line_rad)) {
        continue;
      }
      ends_.push_back(NumberOf(place, heading));
      NodeOf(ends_.back()).is_end = true;
    }
  }

  bool LeadsToGoal(const Spot& spot, double line_rad) const {
    const std::optional<Spot> end = space_->Drive(spot, goal_.spot.at);
    return end.has_value() && end->level == goal_.spot.level &&
           space_->CanTurn(*end, line_rad, goal_.yaw_rad);
  }

  // False if none of the ways back from the goal leads far, and none to the
  // start: niches that cannot be driven into would have everything else
  // searched.
  bool MayBeReached() {
    std::vector<uint32_t> found = ends_;
    for (const uint32_t number : found) NodeOf(number).is_found = true;
    const auto add = [&](uint32_t number) {
      Node& node = NodeOf(number);
      if (!node.is_found) found.push_back(number);
      node.is_found = true;
    };
    for (size_t i = 0; i < found.size(); ++i) {
      if (i > size_t{kNicheNodes.value} ||
          std::ranges::find(starts_, found[i]) != starts_.end()) {
        return true;
      }
      const size_t place = found[i] / kHeadings;
      const int heading = HeadingOf(found[i]);
      const int left = (heading + 1) % kHeadings;
      const int right = (heading + kHeadings - 1) % kHeadings;
      if (CanTurnLeft(place, heading)) add(NumberOf(place, left));
      if (CanTurnLeft(place, right)) add(NumberOf(place, right));
      const core::CellIndex& step = kCellSteps[static_cast<size_t>(heading)];
      const core::CellIndex cell = CellOf(place);
      const core::CellIndex before = {cell.x - step.x, cell.y - step.y};
      for (int level = 0; level < ground_->levels(); ++level) {
        if (!ground_->map().IsFree(level, before)) continue;
        const size_t from = PlaceOf(level, before);
        if (PlaceAhead(from, heading) == place &&
            CanDrive(from, heading, place)) {
          add(NumberOf(from, heading));
        }
      }
    }
    return false;
  }

  // False if no end can be come to from the start, however long the way: a
  // flood over places with all headings of each at once. It says true where the
  // search would find nothing, too, if a turn the longer way round is needed.
  bool MayReach() {
    std::vector<uint16_t> is_end(places_);
    for (const uint32_t end : ends_) is_end[end / kHeadings] |= BitOf(end);
    std::vector<uint16_t> reached(places_);
    std::vector<uint16_t> pending(places_);
    std::vector<uint32_t> open;
    const auto add = [&](size_t place, uint16_t headings) {
      const auto added = static_cast<uint16_t>(headings & ~reached[place]);
      if (added == 0) return;
      if (pending[place] == 0) open.push_back(static_cast<uint32_t>(place));
      pending[place] |= added;
    };
    for (const uint32_t start : starts_) add(start / kHeadings, BitOf(start));
    for (int count = 0; !open.empty(); ++count) {
      if (count % kStopEvery == 0 && (*is_over_)()) return true;
      const size_t place = open.back();
      open.pop_back();
      const uint16_t known = reached[place];
      const uint16_t all =
          WithTurns(place, static_cast<uint16_t>(known | pending[place]));
      pending[place] = 0;
      reached[place] = all;
      if ((all & is_end[place]) != 0) return true;
      for (int heading = 0; heading < kHeadings; ++heading) {
        const auto bit = static_cast<uint16_t>(1U << heading);
        if ((all & ~known & bit) == 0) continue;
        const size_t to = PlaceAhead(place, heading);
        if (to != kNowhere && (reached[to] & bit) == 0 &&
            CanDrive(place, heading, to)) {
          add(to, bit);
        }
      }
    }
    return false;
  }

  static uint16_t BitOf(uint32_t number) {
    return static_cast<uint16_t>(1U << (number % kHeadings));
  }

  // The headings that can be turned to from some at a place.
  uint16_t WithTurns(size_t place, uint16_t headings) {
    if (RoomAt_m(place) >= space_->footprint().circumradius_m) return 0xffff;
    for (bool is_changed = true; is_changed && headings != 0xffff;) {
      is_changed = false;
      for (int heading = 0; heading < kHeadings; ++heading) {
        const int left = (heading + 1) % kHeadings;
        const bool has = (headings >> heading & 1) != 0;
        const bool has_left = (headings >> left & 1) != 0;
        if (has == has_left || !CanTurnLeft(place, heading)) continue;
        headings |= static_cast<uint16_t>(1U << heading | 1U << left);
        is_changed = true;
      }
    }
    return headings;
  }

  // The inscribed disc's way to the goal.
  float Estimate_m(size_t place) {
    float& estimate_m = At(place).estimate_m;
    if (estimate_m == kNotAsked) {
      estimate_m =
          distance_.Of_m({ground_->CenterOf(CellOf(place)), LevelOf(place)});
    }
    return estimate_m;
  }

  void Reach(uint32_t from, uint32_t number, float cost_m) {
    const float estimate_m = Estimate_m(number / kHeadings);
    Node& node = NodeOf(number);
    if (cost_m >= node.cost_m || !std::isfinite(estimate_m)) return;
    node.cost_m = cost_m;
    node.parent = from;
    open_.push({cost_m + weight_ * estimate_m, number});
  }

  // Whether it turns there from a heading to the next one to the left.
  bool CanTurnLeft(size_t place, int heading) {
    if (RoomAt_m(place) >= space_->footprint().circumradius_m) return true;
    uint8_t& known = At(place).nodes[static_cast<size_t>(heading)].turns;
    if (known == kUnknown) {
      known = space_->CanTurn(SpotOf(place), YawOf(heading),
                              YawOf((heading + 1) % kHeadings))
                  ? kCan
                  : kCannot;
    }
    return known == kCan;
  }

  // Where a step along a heading leads; kNowhere: off the ground.
  size_t PlaceAhead(size_t place, int heading) const {
    const core::CellIndex& step = kCellSteps[static_cast<size_t>(heading)];
    const core::CellIndex cell = CellOf(place);
    const core::CellIndex next = {cell.x + step.x, cell.y + step.y};
    const int level = ground_->LevelAfter(LevelOf(place), cell, next);
    return level < 0 ? kNowhere : PlaceOf(level, next);
  }

  bool CanDrive(size_t place, int heading, size_t to) {
    // All that a step sweeps is that near.
    if (!ground_->has_one_way() && LevelOf(place) == LevelOf(to) &&
        RoomAt_m(place) >= space_->footprint().circumradius_m +
                               step_m_[static_cast<size_t>(heading)]) {
      return true;
    }
    const std::optional<Spot> driven =
        space_->Drive(SpotOf(place), SpotOf(to).at);
    return driven.has_value() && driven->level == LevelOf(to);
  }

  void Expand(uint32_t from) {
    const size_t place = from / kHeadings;
    const int heading = HeadingOf(from);
    const int left = (heading + 1) % kHeadings;
    const int right = (heading + kHeadings - 1) % kHeadings;
    if (MayTurnOn(from)) {
      if (CanTurnLeft(place, heading)) Turn(from, place, left);
      if (CanTurnLeft(place, right)) Turn(from, place, right);
    }
    const size_t to = PlaceAhead(place, heading);
    if (to == kNowhere) return;
    const uint32_t number = NumberOf(to, heading);
    if (NodeOf(number).is_done) return;
    const float from_cost_m = NodeOf(from).cost_m;
    const auto cost_m =
        static_cast<float>(step_m_[static_cast<size_t>(heading)] *
                           (space_->CostPerMetre(SpotOf(place)) +
                            space_->CostPerMetre(SpotOf(to))) /
                           2);
    if (from_cost_m + cost_m >= NodeOf(number).cost_m) return;
    if (CanDrive(place, heading, to)) {
      Reach(from, number, from_cost_m + cost_m);
    }
  }

  // Turns are driven the shorter way round: at most half a turn in one place.
  // At the start all such are among the first nodes.
  bool MayTurnOn(uint32_t node) {
    int turns = 0;
    for (uint32_t before = NodeOf(node).parent;
         before != kNone && before / kHeadings == node / kHeadings;
         before = NodeOf(before).parent) {
      if (++turns == kHeadings / 2) return false;
    }
    return node / kHeadings != starts_.front() / kHeadings;
  }

  void Turn(uint32_t from, size_t place, int heading) {
    const double cost_m = TurnCost_m(YawOf(HeadingOf(from)), YawOf(heading));
    Reach(from, NumberOf(place, heading),
          NodeOf(from).cost_m + static_cast<float>(cost_m));
  }

  // Through the places where it turns or comes to another level.
  Polyline WayTo(uint32_t last) {
    std::vector<uint32_t> nodes;
    for (uint32_t at = last; at != kNone; at = NodeOf(at).parent) {
      nodes.push_back(at);
    }
    std::ranges::reverse(nodes);
    Polyline way = {start_.spot};
    for (size_t i = 1; i + 1 < nodes.size(); ++i) {
      const size_t place = nodes[i] / kHeadings;
      const size_t next = nodes[i + 1] / kHeadings;
      const bool is_corner =
          next != place && (nodes[i - 1] / kHeadings == place ||
                            LevelOf(next) != LevelOf(place));
      if (is_corner && place != nodes.front() / kHeadings) {
        way.push_back(SpotOf(place));
      }
    }
    const size_t end = last / kHeadings;
    if (end != nodes.front() / kHeadings) way.push_back(SpotOf(end));
    if (geometry::Norm(SpotOf(end).at - goal_.spot.at) > 1e-6) {
      way.push_back(goal_.spot);
    }
    return way;
  }

  const ConfigurationSpace* space_;
  const GroundIndex* ground_;
  const std::function<bool()>* is_over_;
  float weight_;
  Stand start_;
  Stand goal_;
  // From cells' centres to the places: one of them is the start.
  geometry::Vec2 offset_;
  std::array<float, kHeadings> step_m_ = {};
  size_t places_;
  std::vector<uint32_t> starts_;
  std::vector<uint32_t> ends_;
  DistanceToGoal distance_;
  std::vector<std::unique_ptr<Page>> pages_;
  OpenNodes open_;
};

}  // namespace

Polyline SearchLattice(const ConfigurationSpace& space, const Regions& regions,
                       const Stand& start, const Stand& goal,
                       const std::function<bool()>& is_over, double weight) {
  return Lattice(space, regions, start, goal,
                 std::numeric_limits<double>::infinity(), weight, is_over)
      .Run();
}

Polyline SearchLatticeNear(const ConfigurationSpace& space,
                           const Regions& regions, const Stand& start,
                           const Stand& goal, double reach_m, int max_nodes,
                           const std::function<bool()>& is_over) {
  int asked = 0;
  const std::function<bool()> is_enough = [&] {
    return kStopEvery * asked++ > max_nodes || is_over();
  };
  return Lattice(space, regions, start, goal, reach_m, kGreed, is_enough)
      .RunNear();
}

}  // namespace treeline::planning

// The way through what is known so far: how far it is to the goal from
// everywhere.
#ifndef NAV_AGENT_MAPLESS_WAY_FIELD_H_
#define NAV_AGENT_MAPLESS_WAY_FIELD_H_

#include <limits>
#include <vector>

#include "nav_agent/mapless/body_shape.h"
#include "nav_agent/mapless/evidence_grid.h"

namespace treeline::mapless {

// Dijkstra's distances from the goal over the cells that the body's inner
// circle fits on; what was never seen counts as free. Cells near things cost
// more. So that the robot does not flip between ways that are about as good,
// cells of the present way cost less (kPresentWay): it is left only for one
// that is clearly shorter, or when it turns out to be blocked. Not thread-safe.
class WayField {
 public:
  static constexpr double kNoWay = std::numeric_limits<double>::infinity();

  explicit WayField(const BodyShape& body) : body_(body) {}

  // The present way is forgotten: a new goal.
  void Restart();
  // Plans anew. False: there is no way through what is known.
  bool Update(const EvidenceGrid& map, geometry::Vec2 robot,
              geometry::Vec2 goal);

  // What is to go from here, in metres of free ground; kNoWay where the body
  // cannot be, or where nothing was planned.
  double ToGo(geometry::Vec2 point) const;
  // From the robot of the last Update to the goal; empty: there is none.
  const std::vector<geometry::Vec2>& path() const { return path_; }
  double length_m() const;
  // How far the goal was moved to where there is room (m).
  double moved_goal_m() const { return moved_goal_m_; }
  // Updates since Restart that took another way than that before.
  int changes() const { return changes_; }

 private:
  void MakeCosts(const ClearanceWindow& clearance);
  size_t IndexOf(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(columns_) +
           static_cast<size_t>(x);
  }
  bool Spread(core::CellIndex goal, core::CellIndex robot);
  core::CellIndex NearestFree(core::CellIndex cell) const;
  std::vector<geometry::Vec2> Descend(core::CellIndex robot) const;
  void NoteChange(const std::vector<geometry::Vec2>& before);

  BodyShape body_;
  int columns_ = 0;
  int rows_ = 0;
  double cell_m_ = 1;
  geometry::Vec2 origin_;
  // Of a metre; not positive: the body does not fit there.
  std::vector<float> cost_;
  std::vector<float> to_go_;
  std::vector<geometry::Vec2> path_;
  double moved_goal_m_ = 0;
  int changes_ = 0;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_WAY_FIELD_H_

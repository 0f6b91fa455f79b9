#include "common/ros2/conversions/transform_history.h"

#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/ros2/conversions/geometry_values.h"

namespace treeline::conversions {
namespace {

// More than robots have; bounds loops.
constexpr size_t kMaxFrames = 2000;

std::string NameOf(const std::string& frame) {
  return std::string(absl::StripPrefix(frame, "/"));
}

}  // namespace

void TransformHistory::AddMoment(const std::string& child, int64_t time_ns,
                                 Moment moment) {
  if (child.empty() || moment.parent.empty() || child == moment.parent) return;
  if (edges_.size() >= kMaxFrames && edges_.count(child) == 0) return;
  Edge& edge = edges_[child];
  edge.is_constant &=
      edge.moments.empty() || edge.moments.begin()->second == moment;
  edge.moments[time_ns] = std::move(moment);
}

void TransformHistory::Add(const messages::TFMessage& message) {
  for (const messages::TransformStamped& transform : message.transforms) {
    const std::string child = NameOf(transform.child_frame_id);
    const auto value = RigidOf(transform.transform);
    if (!value.ok() || posed_.count(child) > 0) continue;
    AddMoment(child, messages::Nanoseconds(transform.header.stamp),
              {NameOf(transform.header.frame_id), *value});
  }
}

void TransformHistory::AddStatic(const messages::TFMessage& message) {
  for (const messages::TransformStamped& transform : message.transforms) {
    const std::string child = NameOf(transform.child_frame_id);
    const auto value = RigidOf(transform.transform);
    if (!value.ok() || posed_.count(child) > 0) continue;
    // The newest counts, at any time.
    edges_.erase(child);
    AddMoment(child, 0, {NameOf(transform.header.frame_id), *value});
  }
}

void TransformHistory::AddPose(const std::string& parent,
                               const std::string& child, int64_t time_ns,
                               const geometry::Rigid3& parent_from_child) {
  const std::string name = NameOf(child);
  if (posed_.insert(name).second) edges_.erase(name);
  AddMoment(name, time_ns, {NameOf(parent), parent_from_child});
}

absl::StatusOr<TransformHistory::Moment> TransformHistory::MomentOf(
    const std::string& child, const Edge& edge, int64_t time_ns) const {
  if (edge.is_constant) return edge.moments.begin()->second;
  const auto next = edge.moments.lower_bound(time_ns);
  if (next != edge.moments.end() && next->first == time_ns) {
    return next->second;
  }
  if (next == edge.moments.end() || next == edge.moments.begin()) {
    return absl::NotFoundError(
        absl::StrCat("nothing tells where ", child,
                     " was before the first or after the "
                     "last transform"));
  }
  const auto last = std::prev(next);
  // Stamps are from outside: their difference need not fit.
  const double gap_ns =
      static_cast<double>(next->first) - static_cast<double>(last->first);
  if (gap_ns > max_gap_s_ * 1e9 || last->second.parent != next->second.parent) {
    return absl::NotFoundError(absl::StrCat(
        "nothing tells where ", child, " was: a gap of ", gap_ns * 1e-9, " s"));
  }
  const double t = (static_cast<double>(time_ns - last->first)) / gap_ns;
  const geometry::Rigid3& a = last->second.parent_from_child;
  const geometry::Rigid3& b = next->second.parent_from_child;
  return Moment{last->second.parent,
                {geometry::Slerp(a.rotation, b.rotation, t),
                 a.translation + t * (b.translation - a.translation)}};
}

absl::StatusOr<geometry::Rigid3> TransformHistory::Find(
    const std::string& target, const std::string& source,
    int64_t time_ns) const {
  // All frames above the target, with the target in each.
  std::map<std::string, geometry::Rigid3> frame_from_target;
  geometry::Rigid3 from_target;
  std::string frame = NameOf(target);
  absl::Status failure;
  while (frame_from_target.emplace(frame, from_target).second) {
    const auto edge = edges_.find(frame);
    if (edge == edges_.end()) break;
    const auto moment = MomentOf(frame, edge->second, time_ns);
    if (!moment.ok()) {
      failure = moment.status();
      break;
    }
    from_target = moment->parent_from_child * from_target;
    frame = moment->parent;
  }
  geometry::Rigid3 from_source;
  frame = NameOf(source);
  for (size_t i = 0; i <= edges_.size(); ++i) {
    const auto common = frame_from_target.find(frame);
    if (common != frame_from_target.end()) {
      return common->second.Inverse() * from_source;
    }
    const auto edge = edges_.find(frame);
    if (edge == edges_.end()) break;
    TL_ASSIGN_OR_RETURN(const Moment moment,
                        MomentOf(frame, edge->second, time_ns));
    from_source = moment.parent_from_child * from_source;
    frame = moment.parent;
  }
  if (!failure.ok()) return failure;
  return absl::NotFoundError(absl::StrCat(
      "/tf and /tf_static do not tell where ", source, " is in ", target));
}

std::vector<std::string> TransformHistory::ChainFrom(
    const std::string& frame) const {
  std::vector<std::string> chain = {NameOf(frame)};
  while (chain.size() <= edges_.size()) {
    const auto edge = edges_.find(chain.back());
    if (edge == edges_.end()) break;
    chain.push_back(edge->second.moments.begin()->second.parent);
  }
  return chain;
}

bool TransformHistory::Moves(const std::string& frame) const {
  const auto edge = edges_.find(NameOf(frame));
  return edge != edges_.end() && !edge->second.is_constant;
}

}  // namespace treeline::conversions

#include "nav_agent/rgbd_slam/mapper.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "nav_agent/rgbd_slam/feature_matching.h"

namespace treeline::rgbd_slam {
namespace {

constexpr int kNeighbours = 6;
constexpr size_t kCandidates = 3;
// Keyframes that share this many landmarks are at the same place anyway.
constexpr int kMinNeighbourShared = 8;
constexpr uint64_t kMeetingStream = uint64_t{1} << 40;

}  // namespace

Mapper::Mapper(const RgbdSlamOptions& options, const Tracker* tracker,
               SlamMap* map)
    : options_(options),
      tracker_(*tracker),
      map_(*map),
      index_(options.seed),
      local_{.window = options.local_keyframes,
             .fixed = options.local_keyframes,
             .landmarks = options.local_landmarks,
             .iterations = options.local_iterations} {}

int Mapper::Insert(MapKeyframe keyframe) {
  const int first_new = map_.landmark_count();
  const int k = map_.AddKeyframe(std::move(keyframe));
  for (int l = first_new; l < map_.landmark_count(); ++l) recent_.push_back(l);
  CullRecent(k);
  FuseNeighbours(k);
  AdjustLocally(k, local_, &map_);
  if (options_.closes_loops) {
    if (const auto meeting = Meet(k, false)) Close(k, *meeting);
  }
  index_.Add(map_.keyframe(k).features);
  return k;
}

void Mapper::CullRecent(int keyframe) {
  constexpr int kTrial = 4;
  constexpr double kMinFound = 0.2;
  std::vector<int> kept;
  for (const int l : recent_) {
    const Landmark& landmark = map_.landmark(l);
    if (landmark.is_erased) continue;
    const bool is_found = landmark.found >= kMinFound * landmark.visible;
    const bool is_on_trial = keyframe - landmark.reference < kTrial;
    if (is_found && is_on_trial) {
      kept.push_back(l);
    } else if (!is_found || landmark.sightings.size() < 2) {
      map_.EraseLandmark(l);
    }
  }
  recent_ = std::move(kept);
}

void Mapper::FuseNeighbours(int k) {
  constexpr double kRadius_px = 3;
  std::vector<Covisible> neighbours =
      map_.CovisibleWith(k, options_.min_shared);
  if (neighbours.size() > kNeighbours) neighbours.resize(kNeighbours);
  const std::vector<int> theirs = map_.LandmarksOf(neighbours, 8000);
  map_.FuseInto(k, theirs, kRadius_px);
  const Covisible self{k, 0};
  const std::vector<int> own = map_.LandmarksOf({&self, 1}, 8000);
  for (const Covisible& neighbour : neighbours) {
    map_.FuseInto(neighbour.keyframe, own, kRadius_px);
  }
}

std::vector<int> Mapper::CandidatesFor(int k, bool in_other_submaps) const {
  const std::vector<double> scores = index_.Score(map_.keyframe(k).features);
  std::vector<char> is_neighbour(scores.size(), 0);
  // What neighbours look like to each other is what a place known again must
  // come near to.
  double least = 0;
  int counted = 0;
  for (const Covisible& other : map_.CovisibleWith(k, kMinNeighbourShared)) {
    const auto at = static_cast<size_t>(other.keyframe);
    if (at >= scores.size()) continue;
    is_neighbour[at] = 1;
    if (counted++ < 5)
      least = counted == 1 ? scores[at] : std::min(least, scores[at]);
  }
  constexpr double kShareOfNeighbours = 0.6;
  const int submap = map_.keyframe(k).submap;
  std::vector<std::pair<double, int>> ranked;
  for (size_t other = 0; other < scores.size(); ++other) {
    const int index = static_cast<int>(other);
    const bool is_other_submap = map_.keyframe(index).submap != submap;
    if (is_neighbour[other] != 0 || index == k) continue;
    if (in_other_submaps && !is_other_submap) continue;
    if (!is_other_submap && scores[other] < kShareOfNeighbours * least) {
      continue;
    }
    ranked.emplace_back(-scores[other], index);
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > kCandidates) ranked.resize(kCandidates);
  std::vector<int> candidates;
  for (const auto& entry : ranked) candidates.push_back(entry.second);
  return candidates;
}

std::optional<Mapper::Meeting> Mapper::Meet(int k,
                                            bool in_other_submaps) const {
  const FeatureSet& features = map_.keyframe(k).features;
  for (const int candidate : CandidatesFor(k, in_other_submaps)) {
    const uint64_t stream = kMeetingStream +
                            static_cast<uint64_t>(k) * 1000003 +
                            static_cast<uint64_t>(candidate);
    if (auto place = tracker_.FindFrom(candidate, features,
                                       2 * options_.min_inliers, stream)) {
      return Meeting{candidate, *std::move(place)};
    }
  }
  return std::nullopt;
}

void Mapper::Close(int k, const Meeting& meeting) {
  const geometry::Rigid3 map_from_k = meeting.place.camera_from_map.Inverse();
  const int here = map_.keyframe(k).submap;
  const int there = map_.keyframe(meeting.from).submap;
  loop_edges_.push_back(
      {.from = meeting.from,
       .to = k,
       .from_from_to =
           map_.keyframe(meeting.from).map_from_camera.Inverse() * map_from_k,
       .shared = static_cast<int>(meeting.place.matches.size())});
  if (here == there) {
    ++loops_;
    constexpr int kIterations = 20;
    OptimizeKeyframes(map_.CovisibilityEdges(options_.min_shared), loop_edges_,
                      here, kIterations, &map_);
  } else {
    ++joined_submaps_;
    const geometry::Rigid3 there_from_here =
        map_from_k * map_.keyframe(k).map_from_camera.Inverse();
    if (there < here) {
      map_.JoinSubmap(here, there, there_from_here);
    } else {
      map_.JoinSubmap(there, here, there_from_here.Inverse());
    }
  }
  FuseMeeting(k, meeting);
  AdjustLocally(k, local_, &map_);
}

void Mapper::FuseMeeting(int k, const Meeting& meeting) {
  constexpr double kRadius_px = 5;
  for (const FeatureMatch& match : meeting.place.matches) {
    if (map_.landmark(match.landmark).is_erased) continue;
    const int held =
        map_.keyframe(k).landmarks[static_cast<size_t>(match.feature)];
    if (held == kNoLandmark) {
      map_.AddSighting(match.landmark, {k, match.feature});
    } else {
      map_.Merge(held, match.landmark);
    }
  }
  const auto group_of = [this](int keyframe) {
    std::vector<Covisible> group =
        map_.CovisibleWith(keyframe, options_.min_shared);
    if (group.size() > kNeighbours) group.resize(kNeighbours);
    group.push_back({keyframe, 0});
    return group;
  };
  const std::vector<int> theirs =
      map_.LandmarksOf(group_of(meeting.from), 8000);
  for (const Covisible& member : group_of(k)) {
    map_.FuseInto(member.keyframe, theirs, kRadius_px);
  }
}

void Mapper::Connect(int submap) {
  if (!options_.closes_loops) return;
  int anchor = 0;
  while (anchor < map_.keyframe_count() &&
         map_.keyframe(anchor).submap != submap) {
    ++anchor;
  }
  if (anchor == map_.keyframe_count()) return;
  for (int k = 0; k < map_.keyframe_count(); ++k) {
    // Joining renames submaps.
    if (map_.keyframe(k).submap == map_.keyframe(anchor).submap) continue;
    if (const auto meeting = Meet(k, true)) Close(k, *meeting);
  }
}

}  // namespace treeline::rgbd_slam

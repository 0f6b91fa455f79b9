#include "nav_agent/rgbd_slam/slam_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <unordered_set>
#include <utility>

#include "nav_agent/rgbd_slam/feature_matching.h"

namespace treeline::rgbd_slam {
namespace {

std::vector<Covisible> Ranked(const std::vector<int>& shared, int min_shared) {
  std::vector<Covisible> ranked;
  for (size_t k = 0; k < shared.size(); ++k) {
    if (shared[k] >= min_shared) {
      ranked.push_back({static_cast<int>(k), shared[k]});
    }
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Covisible& a, const Covisible& b) {
                     return a.shared > b.shared;
                   });
  return ranked;
}

}  // namespace

int SlamMap::AddKeyframe(MapKeyframe keyframe) {
  const int index = keyframe_count();
  keyframe.landmarks.resize(static_cast<size_t>(keyframe.features.size()),
                            kNoLandmark);
  keyframes_.push_back(std::move(keyframe));
  const size_t count = keyframes_.back().landmarks.size();
  const geometry::Vec3 camera_in_map =
      keyframes_.back().map_from_camera.translation;
  for (size_t f = 0; f < count; ++f) {
    MapKeyframe& added = keyframes_.back();
    const ImageFeature& feature = added.features[static_cast<int>(f)];
    int landmark = added.landmarks[f];
    if (landmark == kNoLandmark) {
      if (feature.depth_m <= 0) continue;
      landmark = landmark_count();
      const geometry::Vec3 point =
          added.map_from_camera *
          pinhole_.PointAt(feature.pixel, feature.depth_m);
      const geometry::Vec3 to_camera = camera_in_map - point;
      const double distance_m = geometry::Norm(to_camera);
      Landmark made;
      made.point_in_map = point;
      made.reference = index;
      made.finest_distance_m = distance_m * OctaveScale(feature.octave);
      made.direction_in_map = to_camera / distance_m;
      made.visible = 1;
      made.found = 1;
      landmarks_.push_back(std::move(made));
    }
    added.landmarks[f] = kNoLandmark;
    AddSighting(landmark, {index, static_cast<int>(f)});
  }
  return index;
}

void SlamMap::AddSighting(int l, Sighting sighting) {
  MapKeyframe& seen_by = keyframe(sighting.keyframe);
  seen_by.landmarks[static_cast<size_t>(sighting.feature)] = l;
  landmark(l).sightings.push_back(sighting);
  landmark(l).descriptor = seen_by.features[sighting.feature].descriptor;
}

void SlamMap::RemoveSighting(int l, Sighting sighting) {
  keyframe(sighting.keyframe).landmarks[static_cast<size_t>(sighting.feature)] =
      kNoLandmark;
  std::vector<Sighting>& sightings = landmark(l).sightings;
  std::erase_if(sightings, [sighting](const Sighting& other) {
    return other.keyframe == sighting.keyframe &&
           other.feature == sighting.feature;
  });
  if (sightings.empty()) landmark(l).is_erased = true;
}

void SlamMap::EraseLandmark(int l) {
  Landmark& erased = landmark(l);
  for (const Sighting& sighting : erased.sightings) {
    keyframe(sighting.keyframe)
        .landmarks[static_cast<size_t>(sighting.feature)] = kNoLandmark;
  }
  erased.sightings.clear();
  erased.is_erased = true;
}

void SlamMap::Merge(int from, int into) {
  if (from == into || landmark(from).is_erased || landmark(into).is_erased) {
    return;
  }
  const std::vector<Sighting> sightings = landmark(from).sightings;
  landmark(into).visible += landmark(from).visible;
  landmark(into).found += landmark(from).found;
  EraseLandmark(from);
  for (const Sighting& sighting : sightings) {
    if (!Sees(sighting.keyframe, into)) AddSighting(into, sighting);
  }
}

bool SlamMap::Sees(int k, int l) const {
  const std::vector<Sighting>& sightings = landmark(l).sightings;
  return std::any_of(
      sightings.begin(), sightings.end(),
      [k](const Sighting& sighting) { return sighting.keyframe == k; });
}

PointSighting SlamMap::MeasurementOf(Sighting sighting) const {
  const MapKeyframe& seen_by = keyframe(sighting.keyframe);
  const ImageFeature& feature = seen_by.features[sighting.feature];
  const int l = seen_by.landmarks[static_cast<size_t>(sighting.feature)];
  return {.point_in_map = landmark(l).point_in_map,
          .pixel = feature.pixel,
          .depth_m = feature.depth_m,
          .sigma_px = OctaveScale(feature.octave)};
}

std::vector<Covisible> SlamMap::CovisibleWith(int k, int min_shared) const {
  std::vector<int> shared(keyframes_.size(), 0);
  for (const int l : keyframe(k).landmarks) {
    if (l == kNoLandmark) continue;
    for (const Sighting& sighting : landmark(l).sightings) {
      ++shared[static_cast<size_t>(sighting.keyframe)];
    }
  }
  shared[static_cast<size_t>(k)] = 0;
  return Ranked(shared, min_shared);
}

std::vector<Covisible> SlamMap::KeyframesThatSee(std::span<const int> landmarks,
                                                 int min_shared) const {
  std::vector<int> shared(keyframes_.size(), 0);
  for (const int l : landmarks) {
    for (const Sighting& sighting : landmark(l).sightings) {
      ++shared[static_cast<size_t>(sighting.keyframe)];
    }
  }
  return Ranked(shared, min_shared);
}

std::vector<KeyframeEdge> SlamMap::CovisibilityEdges(int min_shared) const {
  std::vector<KeyframeEdge> edges;
  for (int k = 0; k < keyframe_count(); ++k) {
    for (const Covisible& other : CovisibleWith(k, min_shared)) {
      if (other.keyframe <= k) continue;
      edges.push_back({.from = k,
                       .to = other.keyframe,
                       .from_from_to = keyframe(k).map_from_camera.Inverse() *
                                       keyframe(other.keyframe).map_from_camera,
                       .shared = other.shared});
    }
  }
  return edges;
}

std::vector<int> SlamMap::LandmarksOf(std::span<const Covisible> keyframes,
                                      size_t limit) const {
  std::vector<int> collected;
  std::unordered_set<int> seen;
  for (const Covisible& entry : keyframes) {
    for (const int l : keyframe(entry.keyframe).landmarks) {
      if (l == kNoLandmark || !seen.insert(l).second) continue;
      if (collected.size() == limit) return collected;
      collected.push_back(l);
    }
  }
  return collected;
}

void SlamMap::MoveKeyframes(
    std::span<const geometry::Rigid3> map_from_cameras) {
  for (Landmark& moved : landmarks_) {
    if (moved.is_erased) continue;
    const auto reference = static_cast<size_t>(moved.reference);
    const geometry::Rigid3 correction =
        map_from_cameras[reference] *
        keyframes_[reference].map_from_camera.Inverse();
    moved.point_in_map = correction * moved.point_in_map;
    moved.direction_in_map = correction.rotation * moved.direction_in_map;
  }
  for (size_t k = 0; k < keyframes_.size(); ++k) {
    keyframes_[k].map_from_camera = map_from_cameras[k];
  }
}

void SlamMap::JoinSubmap(int from, int into,
                         const geometry::Rigid3& into_from_from) {
  std::vector<geometry::Rigid3> poses;
  poses.reserve(keyframes_.size());
  for (MapKeyframe& moved : keyframes_) {
    const bool is_joined = moved.submap == from;
    poses.push_back(is_joined ? into_from_from * moved.map_from_camera
                              : moved.map_from_camera);
    if (is_joined) moved.submap = into;
  }
  MoveKeyframes(poses);
}

int SlamMap::FuseInto(int k, std::span<const int> landmarks, double radius_px) {
  std::vector<int> unseen;
  for (const int l : landmarks) {
    if (!landmark(l).is_erased && !Sees(k, l)) unseen.push_back(l);
  }
  const MapKeyframe& target = keyframe(k);
  const std::vector<FeatureMatch> matches = MatchByProjection(
      *this, unseen, target.features, target.map_from_camera.Inverse(),
      {.radius_px = radius_px, .max_distance = 50, .ratio = 1}, nullptr);
  for (const FeatureMatch& match : matches) {
    const int held = keyframe(k).landmarks[static_cast<size_t>(match.feature)];
    // It may have become another's, or been seen here, by a merge just made.
    if (landmark(match.landmark).is_erased || Sees(k, match.landmark)) continue;
    if (held == kNoLandmark) {
      AddSighting(match.landmark, {k, match.feature});
    } else if (landmark(held).sightings.size() >
               landmark(match.landmark).sightings.size()) {
      Merge(match.landmark, held);
    } else {
      Merge(held, match.landmark);
    }
  }
  return static_cast<int>(matches.size());
}

}  // namespace treeline::rgbd_slam

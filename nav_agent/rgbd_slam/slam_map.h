// Keyframes and landmarks of RGB-D SLAM, and who sees whom.
#ifndef NAV_AGENT_RGBD_SLAM_SLAM_MAP_H_
#define NAV_AGENT_RGBD_SLAM_SLAM_MAP_H_

#include <cstdint>
#include <span>
#include <vector>

#include "common/dataset/text_formats.h"
#include "nav_agent/rgbd_slam/binary_features.h"
#include "nav_agent/rgbd_slam/pose_solver.h"

namespace treeline::rgbd_slam {

constexpr int kNoLandmark = -1;

struct Sighting {
  int keyframe = 0;
  int feature = 0;
};

// A point of the map.
struct Landmark {
  geometry::Vec3 point_in_map;
  // As its latest keyframe sees it.
  BinaryDescriptor descriptor{};
  // The keyframe that made it; it moves with it.
  int reference = 0;
  // At this distance a feature of octave 0 would see it (m).
  double finest_distance_m = 0;
  // Where it was seen from first, as a unit vector from the landmark.
  geometry::Vec3 direction_in_map;
  std::vector<Sighting> sightings;
  // Number of frames whose view it was in, and in which it was found.
  int visible = 0;
  int found = 0;
  bool is_erased = false;
};

struct MapKeyframe {
  int frame = 0;
  dataset::Time_ns time = 0;
  // Maps that are not connected yet have frames of their own.
  int submap = 0;
  // Of the colour camera.
  geometry::Rigid3 map_from_camera;
  FeatureSet features;
  // For each feature its landmark, or kNoLandmark.
  std::vector<int> landmarks;
};

// Another keyframe that sees the same landmarks.
struct Covisible {
  int keyframe = 0;
  int shared = 0;
};

// Relative pose of two keyframes, for the pose graph.
struct KeyframeEdge {
  int from = 0;
  int to = 0;
  geometry::Rigid3 from_from_to;
  // Landmarks that speak for it.
  int shared = 0;
};

class SlamMap {
 public:
  explicit SlamMap(const Pinhole& pinhole) : pinhole_(pinhole) {}

  const Pinhole& pinhole() const { return pinhole_; }
  int keyframe_count() const { return static_cast<int>(keyframes_.size()); }
  int landmark_count() const { return static_cast<int>(landmarks_.size()); }
  const MapKeyframe& keyframe(int k) const {
    return keyframes_[static_cast<size_t>(k)];
  }
  MapKeyframe& keyframe(int k) { return keyframes_[static_cast<size_t>(k)]; }
  const Landmark& landmark(int l) const {
    return landmarks_[static_cast<size_t>(l)];
  }
  Landmark& landmark(int l) { return landmarks_[static_cast<size_t>(l)]; }

  // Takes the keyframe, whose `landmarks` name those that it sees, and makes
  // landmarks of all features with depth that see none. Returns its index.
  int AddKeyframe(MapKeyframe keyframe);

  void AddSighting(int landmark, Sighting sighting);
  // Erases a landmark that nothing sees any more.
  void RemoveSighting(int landmark, Sighting sighting);
  void EraseLandmark(int landmark);
  // All that saw `from` now sees `into`, but for keyframes that see both.
  void Merge(int from, int into);

  bool Sees(int keyframe, int landmark) const;
  PointSighting MeasurementOf(Sighting sighting) const;

  // Keyframes that share at least min_shared landmarks with `keyframe`, those
  // with the most first.
  std::vector<Covisible> CovisibleWith(int keyframe, int min_shared) const;
  // Those of these landmarks' sightings, counted alike.
  std::vector<Covisible> KeyframesThatSee(std::span<const int> landmarks,
                                          int min_shared) const;
  // Every pair of covisible keyframes, as their poses are now.
  std::vector<KeyframeEdge> CovisibilityEdges(int min_shared) const;
  // The landmarks of these keyframes, each once, at most `limit`.
  std::vector<int> LandmarksOf(std::span<const Covisible> keyframes,
                               size_t limit) const;

  // Moves keyframes to new poses, landmarks with their references.
  void MoveKeyframes(std::span<const geometry::Rigid3> map_from_cameras);
  // Moves all of a submap into another one's frame.
  void JoinSubmap(int from, int into, const geometry::Rigid3& into_from_from);

  // Looks for landmarks (of one list, each once) in a keyframe: where one is
  // near a feature without, it is seen there; where the feature has another,
  // they become one. Returns how many were found.
  int FuseInto(int keyframe, std::span<const int> landmarks, double radius_px);

 private:
  Pinhole pinhole_;
  std::vector<MapKeyframe> keyframes_;
  std::vector<Landmark> landmarks_;
};

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_SLAM_MAP_H_

#include "nav_agent/rgbd_slam/rgbd_slam.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/rgbd_slam/binary_features.h"
#include "nav_agent/rgbd_slam/feature_matching.h"
#include "nav_agent/rgbd_slam/mapper.h"
#include "nav_agent/rgbd_slam/slam_map.h"
#include "nav_agent/rgbd_slam/tracker.h"

namespace treeline::rgbd_slam {
namespace {

// A frame's place relative to a keyframe, so that it follows corrections.
struct FramePlace {
  int keyframe = -1;  // -1: lost
  geometry::Rigid3 keyframe_from_camera;
};

FeatureOptions FeatureOptionsOf(const RgbdSlamOptions& options) {
  return {.count = options.features,
          .contrast = options.contrast,
          .max_depth_m = options.max_depth_m};
}

int CountWithDepth(const FeatureSet& features) {
  return static_cast<int>(std::count_if(
      features.all().begin(), features.all().end(),
      [](const ImageFeature& feature) { return feature.depth_m > 0; }));
}

}  // namespace

const char* RgbdTrackingName(RgbdTracking tracking) {
  switch (tracking) {
    case RgbdTracking::kTracked:
      return "tracked";
    case RgbdTracking::kRelocalized:
      return "relocalized";
    case RgbdTracking::kNewSubmap:
      return "new submap";
    case RgbdTracking::kLostFewFeatures:
      return "lost: few features";
    case RgbdTracking::kLostNoMatch:
      return "lost: nothing known in sight";
  }
  return "";
}

absl::Status RgbdSlamOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("features", features, 50, 5000));
  TL_RETURN_IF_ERROR(base::CheckRange("contrast", contrast, 1, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("max_depth_m", max_depth_m, 0.5, 50));
  TL_RETURN_IF_ERROR(base::CheckRange("min_inliers", min_inliers, 6, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("keyframe_distance_m", keyframe_distance_m, 0.001, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("keyframe_angle_rad", keyframe_angle_rad, 0.001, 3.14));
  TL_RETURN_IF_ERROR(
      base::CheckRange("keyframe_frames", keyframe_frames, 1, 100000));
  TL_RETURN_IF_ERROR(base::CheckRange("keyframe_share", keyframe_share, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("min_shared", min_shared, 5, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("local_keyframes", local_keyframes, 1, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("local_landmarks", local_landmarks, 10, 100000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("local_iterations", local_iterations, 1, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("lost_frames", lost_frames, 1, 10000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("final_iterations", final_iterations, 0, 100));
  return base::CheckRange("final_landmarks", final_landmarks, 10, 100000);
}

struct RgbdSlam::State {
  State(const RgbdSlamOptions& given, const camera::RgbdCalibration& rig)
      : options(given),
        calibration(rig),
        extractor(rig, FeatureOptionsOf(given)),
        map(extractor.pinhole()),
        tracker(options, &map),
        mapper(options, &tracker, &map) {}

  RgbdTrackResult Place(FeatureSet features, dataset::Time_ns time);
  RgbdTrackResult Lose(FeatureSet features, dataset::Time_ns time);
  RgbdTrackResult Follow(FeatureSet features, dataset::Time_ns time,
                         const TrackedFrame& tracked);
  bool NeedsKeyframe(const TrackedFrame& tracked) const;
  void MakeKeyframe(FeatureSet features, dataset::Time_ns time,
                    const TrackedFrame& tracked, int submap);
  geometry::Rigid3 PoseOf(const FramePlace& place) const;
  // The submap with the most frames, and its first frame.
  int LargestSubmap() const;
  // Pose-sensor poses in the frame of the submap's first frame.
  std::optional<geometry::Rigid3> MapFromColor(int submap) const;

  const RgbdSlamOptions options;
  const camera::RgbdCalibration calibration;
  const base::SteadyClock clock{};
  FeatureExtractor extractor;
  SlamMap map;
  Tracker tracker;
  Mapper mapper;
  std::vector<FramePlace> places;
  std::optional<dataset::Time_ns> last_time;
  int lost_in_a_row = 0;
  int frames_since_keyframe = 0;
  int reference_inliers = 0;
  double mapping_ms = 0;
  bool is_finished = false;
  RgbdSlamStatistics statistics;
};

geometry::Rigid3 RgbdSlam::State::PoseOf(const FramePlace& place) const {
  return map.keyframe(place.keyframe).map_from_camera *
         place.keyframe_from_camera;
}

bool RgbdSlam::State::NeedsKeyframe(const TrackedFrame& tracked) const {
  const geometry::Rigid3 keyframe_from_camera =
      (tracked.camera_from_map *
       map.keyframe(tracker.keyframe()).map_from_camera)
          .Inverse();
  const auto inliers = static_cast<double>(tracked.matches.size());
  return geometry::Norm(keyframe_from_camera.translation) >=
             options.keyframe_distance_m ||
         geometry::AngleBetween_rad(keyframe_from_camera.rotation, {}) >=
             options.keyframe_angle_rad ||
         frames_since_keyframe >= options.keyframe_frames ||
         inliers < options.keyframe_share * reference_inliers;
}

void RgbdSlam::State::MakeKeyframe(FeatureSet features, dataset::Time_ns time,
                                   const TrackedFrame& tracked, int submap) {
  const base::MonotonicTime start = clock.Now();
  MapKeyframe keyframe{.frame = static_cast<int>(places.size()),
                       .time = time,
                       .submap = submap,
                       .map_from_camera = tracked.camera_from_map.Inverse(),
                       .features = std::move(features),
                       .landmarks = {}};
  keyframe.landmarks.assign(static_cast<size_t>(keyframe.features.size()),
                            kNoLandmark);
  for (const FeatureMatch& match : tracked.matches) {
    keyframe.landmarks[static_cast<size_t>(match.feature)] = match.landmark;
  }
  const geometry::Rigid3 old_map_from_camera = keyframe.map_from_camera;
  const int k = mapper.Insert(std::move(keyframe));
  TrackedFrame place = tracked;
  place.matches.clear();
  const std::vector<int>& seen = map.keyframe(k).landmarks;
  for (size_t f = 0; f < seen.size(); ++f) {
    if (seen[f] != kNoLandmark) {
      place.matches.push_back({static_cast<int>(f), seen[f]});
    }
  }
  tracker.SetPlace(place, k);
  tracker.Correct(map.keyframe(k).map_from_camera *
                  old_map_from_camera.Inverse());
  frames_since_keyframe = 0;
  reference_inliers = std::max(static_cast<int>(tracked.matches.size()),
                               static_cast<int>(place.matches.size()) / 3);
  places.push_back({.keyframe = k, .keyframe_from_camera = {}});
  mapping_ms = base::MillisecondsBetween(start, clock.Now());
  statistics.mapping_ms.push_back(mapping_ms);
}

RgbdTrackResult RgbdSlam::State::Follow(FeatureSet features,
                                        dataset::Time_ns time,
                                        const TrackedFrame& tracked) {
  RgbdTrackResult result{.tracking = tracked.is_relocalized
                                         ? RgbdTracking::kRelocalized
                                         : RgbdTracking::kTracked,
                         .inliers = static_cast<int>(tracked.matches.size()),
                         .is_keyframe = false,
                         .map_from_camera = std::nullopt};
  ++statistics.tracked;
  if (tracked.is_relocalized) ++statistics.relocalized;
  lost_in_a_row = 0;
  ++frames_since_keyframe;
  if (NeedsKeyframe(tracked)) {
    result.is_keyframe = true;
    MakeKeyframe(std::move(features), time, tracked,
                 map.keyframe(tracker.keyframe()).submap);
  } else {
    const int k = tracker.keyframe();
    places.push_back({.keyframe = k,
                      .keyframe_from_camera = (tracked.camera_from_map *
                                               map.keyframe(k).map_from_camera)
                                                  .Inverse()});
    tracker.SetPlace(tracked, k);
  }
  return result;
}

RgbdTrackResult RgbdSlam::State::Lose(FeatureSet features,
                                      dataset::Time_ns time) {
  constexpr int kMinFeatures = 50;
  const bool has_few = CountWithDepth(features) < kMinFeatures;
  RgbdTrackResult result;
  result.tracking =
      has_few ? RgbdTracking::kLostFewFeatures : RgbdTracking::kLostNoMatch;
  ++lost_in_a_row;
  const bool is_first = map.keyframe_count() == 0;
  if (!has_few && (is_first || lost_in_a_row > options.lost_frames)) {
    mapper.SetLost();
    tracker.SetLost();
    tracker.SetKeyframe(-1);
    MakeKeyframe(std::move(features), time, {}, statistics.submaps);
    ++statistics.submaps;
    ++statistics.tracked;
    lost_in_a_row = 0;
    result.tracking = RgbdTracking::kNewSubmap;
    result.is_keyframe = true;
    return result;
  }
  tracker.SetLost();
  mapper.SetLost();
  ++statistics.lost;
  places.push_back({});
  return result;
}

RgbdTrackResult RgbdSlam::State::Place(FeatureSet features,
                                       dataset::Time_ns time) {
  std::optional<TrackedFrame> tracked = tracker.Track(features);
  if (!tracked && map.keyframe_count() > 0) {
    tracked = tracker.Relocalize(features, mapper.index(),
                                 static_cast<uint64_t>(places.size()));
    if (tracked) mapper.SetLost();
  }
  return tracked ? Follow(std::move(features), time, *tracked)
                 : Lose(std::move(features), time);
}

int RgbdSlam::State::LargestSubmap() const {
  std::vector<int> frames(static_cast<size_t>(statistics.submaps), 0);
  for (const FramePlace& place : places) {
    if (place.keyframe >= 0) {
      ++frames[static_cast<size_t>(map.keyframe(place.keyframe).submap)];
    }
  }
  if (frames.empty()) return -1;
  return static_cast<int>(std::max_element(frames.begin(), frames.end()) -
                          frames.begin());
}

std::optional<geometry::Rigid3> RgbdSlam::State::MapFromColor(
    int submap) const {
  for (const FramePlace& place : places) {
    if (place.keyframe < 0 || map.keyframe(place.keyframe).submap != submap) {
      continue;
    }
    return camera::PoseOfSensor(PoseOf(place), camera::RgbdSensor::kColor,
                                calibration.pose_sensor, calibration)
        .Inverse();
  }
  return std::nullopt;
}

RgbdSlam::RgbdSlam(std::unique_ptr<State> state) : state_(std::move(state)) {}
RgbdSlam::~RgbdSlam() = default;

absl::StatusOr<std::unique_ptr<RgbdSlam>> RgbdSlam::Create(
    const RgbdSlamOptions& options,
    const camera::RgbdCalibration& calibration) {
  TL_RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<RgbdSlam>(
      new RgbdSlam(std::make_unique<State>(options, calibration)));
}

absl::StatusOr<RgbdTrackResult> RgbdSlam::AddFrame(const image::Frame& frame,
                                                   dataset::Time_ns time) {
  State& state = *state_;
  if (state.is_finished) {
    return absl::FailedPreconditionError("a frame after Finish");
  }
  if (state.last_time && time <= *state.last_time) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a frame at ", time, " ns after one at ", *state.last_time, " ns"));
  }
  const base::MonotonicTime start = state.clock.Now();
  TL_ASSIGN_OR_RETURN(FeatureSet features, state.extractor.Extract(frame));
  state.last_time = time;
  ++state.statistics.frames;
  state.mapping_ms = 0;
  RgbdTrackResult result = state.Place(std::move(features), time);
  state.statistics.tracking_ms.push_back(
      base::MillisecondsBetween(start, state.clock.Now()) - state.mapping_ms);
  const FramePlace& place = state.places.back();
  if (place.keyframe >= 0) {
    const std::optional<geometry::Rigid3> origin =
        state.MapFromColor(state.map.keyframe(place.keyframe).submap);
    result.map_from_camera =
        *origin *
        camera::PoseOfSensor(state.PoseOf(place), camera::RgbdSensor::kColor,
                             state.calibration.pose_sensor, state.calibration);
  }
  return result;
}

void RgbdSlam::Finish() {
  State& state = *state_;
  if (state.is_finished) return;
  state.is_finished = true;
  const int submap = state.LargestSubmap();
  if (submap < 0) return;
  state.mapper.Connect(submap);
  if (state.options.final_iterations > 0) {
    AdjustSubmap(state.LargestSubmap(),
                 {.landmarks = state.options.final_landmarks,
                  .iterations = state.options.final_iterations},
                 &state.map);
  }
}

std::vector<std::optional<geometry::Rigid3>> RgbdSlam::Trajectory() const {
  const State& state = *state_;
  std::vector<std::optional<geometry::Rigid3>> poses(state.places.size());
  const int submap = state.LargestSubmap();
  const std::optional<geometry::Rigid3> origin = state.MapFromColor(submap);
  if (!origin) return poses;
  for (size_t i = 0; i < poses.size(); ++i) {
    const FramePlace& place = state.places[i];
    if (place.keyframe < 0 ||
        state.map.keyframe(place.keyframe).submap != submap) {
      continue;
    }
    poses[i] = *origin * camera::PoseOfSensor(
                             state.PoseOf(place), camera::RgbdSensor::kColor,
                             state.calibration.pose_sensor, state.calibration);
  }
  return poses;
}

std::vector<RgbdKeyframe> RgbdSlam::Keyframes() const {
  const State& state = *state_;
  std::vector<RgbdKeyframe> keyframes;
  const std::vector<std::optional<geometry::Rigid3>> poses = Trajectory();
  for (int k = 0; k < state.map.keyframe_count(); ++k) {
    const MapKeyframe& keyframe = state.map.keyframe(k);
    const std::optional<geometry::Rigid3>& pose =
        poses[static_cast<size_t>(keyframe.frame)];
    if (pose) keyframes.push_back({keyframe.frame, keyframe.time, *pose});
  }
  return keyframes;
}

RgbdSlamStatistics RgbdSlam::Statistics() const {
  RgbdSlamStatistics statistics = state_->statistics;
  statistics.loops = state_->mapper.loops();
  statistics.joined_submaps = state_->mapper.joined_submaps();
  statistics.keyframes = state_->map.keyframe_count();
  for (int l = 0; l < state_->map.landmark_count(); ++l) {
    statistics.landmarks += state_->map.landmark(l).is_erased ? 0 : 1;
  }
  return statistics;
}

}  // namespace treeline::rgbd_slam

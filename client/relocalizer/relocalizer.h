// Asking a Treeline server where a camera is.
#ifndef CLIENT_RELOCALIZER_RELOCALIZER_H_
#define CLIENT_RELOCALIZER_RELOCALIZER_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/geometry/pose_prior.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "common/wire/query_frame.h"

namespace treeline::relocalizer {

struct LocalizeQuery {
  // Empty: the server finds out which scene it is.
  std::string scene = {};
  // With an empty scene: where the frame may have been taken; none: anywhere.
  std::vector<std::string> candidate_scenes = {};
  // Empty: the newest version that is ready.
  std::string model_version = {};
  wire::QueryFrame frame = {};
  // The same seed, frame and model version give the same answer, bit for bit.
  uint64_t seed = 0;
  // Most that the server may take from the arrival of the request (ms),
  // positive, beside the call's own timeout.
  std::optional<double> time_budget_ms = std::nullopt;
  // Least confidence of an answer that is localized, in [0, 1]; nullopt: the
  // scene's threshold, above which 99 of 100 are right. Lower only if poses are
  // checked by other means.
  std::optional<double> min_confidence = std::nullopt;
  // Where the camera is expected: looked at first, and an answer that
  // contradicts it is none.
  geometry::PosePriors priors = {};
  // Whether the answer says which pixels support it, for pictures: some tens of
  // kilobytes more.
  bool wants_inlier_pixels = false;
};

// Where the server's time went, in the order of its stages (ms).
struct ServerTimings {
  double queue_ms = 0;
  double decode_ms = 0;
  double sample_ms = 0;
  double forest_ms = 0;
  double pose_ms = 0;
  // The localizer as a whole: sample, forest, pose and what lies between.
  double localize_ms = 0;
  // From the arrival of the request to its answer.
  double total_ms = 0;
  // Parts of pose_ms: features found and matched; the pose verified.
  double features_ms = 0;
  double verify_ms = 0;
};

// A scene that the server considered, if it was to choose one.
struct SceneCandidate {
  std::string scene;
  double similarity = 0;  // in [0, 1], comparable within one answer
  // Whether a pose in it was looked for; the rest is of that.
  bool tried = false;
  bool localized = false;
  double confidence = 0;
  int inliers = 0;
};

// "Not localized" is an answer like any other.
struct LocalizeAnswer {
  bool localized = false;
  // Why not: "TOO_FEW_SAMPLES", "TOO_FEW_INLIERS", "POORLY_CONSTRAINED",
  // "LOW_CONFIDENCE", "CONTRADICTS_PRIOR", "CONTRADICTS_DEPTH" or
  // "UNKNOWN_CAMERA", as in relocalization.proto without their prefix. "NONE"
  // if localized.
  std::string reason;
  // Meaningful if localized: the pose of pose_sensor's camera, bit for bit as
  // the server computed it, and its covariance.
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
  camera::RgbdSensor pose_sensor = camera::RgbdSensor::kColor;
  int inliers = 0;
  int samples = 0;
  double inlier_ratio = 0;  // in [0, 1]
  // The pose is of a camera whose focal length is so many times the stated one,
  // since that fits better; 1: the stated one fits.
  double focal_scale = 1;
  // If localized by a picture of which no camera was stated, or a guess that
  // does not fit: the camera that the pose is of, found by what is seen.
  // nullopt: the stated one, or the scene's.
  std::optional<camera::Camera> camera;
  // The pose is that of depth that is so many times as large as what was sent,
  // since that fits better; 1: it fits as it is.
  double depth_scale = 1;
  // If asked for: the inliers' pixels in the colour image (x right, y down; as
  // the server says, unchecked).
  std::vector<geometry::Vec2> inlier_pixels;
  // Probability that the pose is right, in [0, 1]: see
  // docs/reference/service.md.
  double confidence = 0;
  // The scene's: of answers that reach it, 99 of 100 were right in training.
  double confidence_threshold = 0;
  // Who answered.
  std::string scene;
  std::string model_version;
  // If the server chose the scene: the best first.
  std::vector<SceneCandidate> candidates;
  ServerTimings server;
  // From the call to the answer in hand, retries included (ms).
  double round_trip_ms = 0;
};

// A model file as the server describes it.
struct ModelDescription {
  std::string method;
  std::string dataset;
  std::string created_utc;
  std::string software_version;
  std::string checksum;
  camera::RgbdCalibration calibration;
  // Axis-aligned box of the training points, world frame (m).
  geometry::Vec3 bounds_min_in_world;
  geometry::Vec3 bounds_max_in_world;
  int training_frames = 0;
  double training_s = 0;
  int trees = 0;
  int64_t leaves = 0;
  uint64_t file_bytes = 0;
};

// A scene as the server describes it.
struct SceneDescription {
  std::string name;
  // "READY", "LOADING", "UNLOADED" or "FAILED".
  std::string state;
  // Why it failed: "DATA_LOSS: ...". Empty otherwise.
  std::string failure;
  // The version that answers; empty if none does.
  std::string model_version;
  // All versions on the server's disk, the newest first.
  std::vector<std::string> versions;
  // From the scene's scene.json; empty: none.
  std::string display_name;
  // Memory that its loaded versions take (bytes).
  uint64_t resident_bytes = 0;
  // Of the version that answers.
  std::optional<ModelDescription> model;
};

struct CallOptions {
  // For the whole call, retries included.
  std::chrono::milliseconds timeout = std::chrono::seconds(10);
  // Cancels the call, here and on the server.
  std::stop_token stop = {};
  // The caller's span, as W3C has it, whose child the server's becomes:
  // "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01". Empty, or
  // anything else: none.
  std::string traceparent = {};
};

// How a stream treats its frames.
struct StreamOptions {
  // If more than max_pending frames wait on the server, the oldest of them is
  // dropped: ABORTED, reason FRAME_DROPPED.
  bool drop_oldest = false;
  int max_pending = 0;  // 1..64; 0: the server's default
  // That most frames will ask for: a balancer may choose the server by it.
  // Empty: none.
  std::string scene = {};
  // Cancels the stream, here and on the server.
  std::stop_token stop = {};
  // As CallOptions; of all frames.
  std::string traceparent = {};
};

struct StreamAnswer {
  uint64_t id = 0;
  absl::StatusOr<LocalizeAnswer> answer;
};

// A sequence of frames, answered in their order while further ones are sent.
// One thread may send while another receives. Destroying it cancels what is
// left.
class LocalizeStream {
 public:
  virtual ~LocalizeStream() = default;

  // Blocks while the server has no room. False: the stream has ended, and
  // Finish tells why.
  virtual bool Send(uint64_t id, const LocalizeQuery& query) = 0;
  // No further frame will come.
  virtual void FinishSending() = 0;
  // The answer to the next frame, round_trip_ms without the time that the frame
  // waited for room. nullopt: the stream has ended.
  virtual std::optional<StreamAnswer> Receive() = 0;
  // After Receive has returned nullopt: how the stream ended.
  virtual absl::Status Finish() = 0;
};

// Answers queries; implemented by a connection
// (grpc_relocalizer.h) and by fakes in tests.
// Thread-safe. All methods block.
//
// Errors are those of relocalization.proto and scenes.proto. UNAVAILABLE also
// means that the server could not be reached, and DEADLINE_EXCEEDED that it did
// not answer in time.
class Relocalizer {
 public:
  virtual ~Relocalizer() = default;

  virtual absl::StatusOr<LocalizeAnswer> Localize(
      const LocalizeQuery& query, const CallOptions& options) = 0;
  virtual absl::StatusOr<std::vector<SceneDescription>> ListScenes(
      const CallOptions& options) = 0;
  virtual absl::StatusOr<SceneDescription> GetScene(
      const std::string& scene, const CallOptions& options) = 0;
  // An empty version: the newest to load, all to unload. Both are for the
  // administrators of a server.
  virtual absl::StatusOr<SceneDescription> LoadScene(
      const std::string& scene, const std::string& model_version,
      const CallOptions& options) = 0;
  virtual absl::StatusOr<SceneDescription> UnloadScene(
      const std::string& scene, const std::string& model_version,
      const CallOptions& options) = 0;
  // Does not wait for the server.
  virtual std::unique_ptr<LocalizeStream> OpenStream(
      const StreamOptions& options) = 0;
};

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_RELOCALIZER_H_

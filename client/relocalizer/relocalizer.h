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
#include "common/geometry/rigid3.h"
#include "common/wire/query_frame.h"

namespace treeline {

struct LocalizeQuery {
  std::string scene = {};
  // Empty: the newest version that is ready.
  std::string model_version = {};
  QueryFrame frame = {};
  // The same seed, frame and model version give the same answer, bit for bit.
  uint64_t seed = 0;
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
};

// "Not localized" is an answer like any other.
struct LocalizeAnswer {
  bool localized = false;
  // Why not: "TOO_FEW_SAMPLES", "TOO_FEW_INLIERS",
  // "POORLY_CONSTRAINED" or "LOW_CONFIDENCE", as
  // in relocalization.proto without their prefix. "NONE" if localized.
  std::string reason;
  // Meaningful if localized: the pose of pose_sensor's camera, bit for bit as
  // the server computed it, and its covariance.
  Rigid3 world_from_camera;
  PoseCovariance covariance{};
  RgbdSensor pose_sensor = RgbdSensor::kColor;
  int inliers = 0;
  int samples = 0;
  double inlier_ratio = 0;  // in [0, 1]
  // Probability that the pose is right, in [0, 1]: see docs/service.md.
  double confidence = 0;
  // Who answered.
  std::string scene;
  std::string model_version;
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
  RgbdCalibration calibration;
  // Axis-aligned box of the training points, world frame (m).
  Vec3 bounds_min_in_world;
  Vec3 bounds_max_in_world;
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
  // Of the version that answers.
  std::optional<ModelDescription> model;
};

struct CallOptions {
  // For the whole call, retries included.
  std::chrono::milliseconds timeout = std::chrono::seconds(10);
  // Cancels the call, here and on the server.
  std::stop_token stop = {};
};

// Answers queries; implemented by the connection below and by fakes in tests.
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
};

struct ConnectOptions {
  // "HOST:PORT", or any target that gRPC resolves ("dns:///...", in which case
  // calls go round-robin over all its addresses).
  std::string server;
  // How often a call is tried while the server answers UNAVAILABLE: 1..5. The
  // waits between tries grow from 50 ms to 1 s, or are what the server asks
  // for, and end with the call's timeout.
  int max_attempts = 4;
  // Largest request and answer (MiB), 1..1024.
  int max_message_mib = 32;

  absl::Status Validate() const;
};

// A connection, made when it is first needed and again whenever it breaks; so
// that the server is not there yet is no error here. INVALID_ARGUMENT: options.
absl::StatusOr<std::unique_ptr<Relocalizer>> ConnectRelocalizer(
    const ConnectOptions& options);

}  // namespace treeline

#endif  // CLIENT_RELOCALIZER_RELOCALIZER_H_

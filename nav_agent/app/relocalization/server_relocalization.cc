#include "nav_agent/app/relocalization/server_relocalization.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::relocalization {
namespace {

using Answer = absl::StatusOr<core::RelocalizationAnswer>;

base::MonotonicTime After(base::MonotonicTime time, double seconds) {
  return time + std::chrono::duration_cast<base::MonotonicTime::duration>(
                    std::chrono::duration<double>(seconds));
}

std::chrono::milliseconds Milliseconds(double seconds) {
  return std::chrono::milliseconds(
      std::max<int64_t>(1, static_cast<int64_t>(1e3 * seconds)));
}

// What the robot wants to know of a server's answer.
core::RelocalizationAnswer AnswerOf(const relocalizer::LocalizeAnswer& answer,
                                    const core::RgbdFrame& frame) {
  core::RelocalizationAnswer result;
  result.stamp = frame.stamp;
  result.localized = answer.localized;
  result.reason = answer.localized ? "" : answer.reason;
  result.map_from_camera = answer.world_from_camera;
  // The robot knows where the sensor is that its calibration names.
  if (frame.frame.calibration.has_value()) {
    result.map_from_camera = camera::PoseOfSensor(
        answer.world_from_camera, answer.pose_sensor,
        frame.frame.calibration->pose_sensor, *frame.frame.calibration);
  }
  result.covariance = answer.covariance;
  result.confidence = answer.confidence;
  result.confidence_threshold = answer.confidence_threshold;
  result.inliers = answer.inliers;
  result.samples = answer.samples;
  result.inlier_pixels = answer.inlier_pixels;
  result.scene = answer.scene;
  result.model_version = answer.model_version;
  result.round_trip_s = 1e-3 * answer.round_trip_ms;
  return result;
}

// Encodes and asks; blocks.
Answer AskNow(relocalizer::Relocalizer& relocalizer,
              const ServerRelocalizationOptions& options,
              const core::RgbdFrame& frame, double timeout_s,
              const std::stop_token& stop,
              const std::string& traceparent = {}) {
  const auto began = std::chrono::steady_clock::now();
  relocalizer::LocalizeQuery query;
  query.scene = options.scene;
  query.seed = options.seed;
  query.min_confidence = options.min_confidence;
  query.wants_inlier_pixels = true;
  TL_ASSIGN_OR_RETURN(query.frame,
                      EncodeFrame(frame.frame, options.jpeg_quality));
  // A robot's camera stands as it did when the map was learnt.
  query.frame.orientation = {image::QuarterTurn::kNone, /*is_certain=*/true};
  TL_ASSIGN_OR_RETURN(
      const relocalizer::LocalizeAnswer answer,
      relocalizer.Localize(query, {.timeout = Milliseconds(timeout_s),
                                   .stop = stop,
                                   .traceparent = traceparent}));
  core::RelocalizationAnswer result = AnswerOf(answer, frame);
  // With what the encoding took.
  result.round_trip_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began)
          .count();
  return result;
}

class ServerRelocalization final : public core::RelocalizationPort {
 public:
  ServerRelocalization(std::shared_ptr<relocalizer::Relocalizer> relocalizer,
                       ServerRelocalizationOptions options,
                       const base::Clock& clock)
      : relocalizer_(std::move(relocalizer)),
        options_(std::move(options)),
        clock_(clock),
        thread_([this](const std::stop_token& stop) { Work(stop); }) {}

  ~ServerRelocalization() override {
    thread_.request_stop();
    Cancel();
    thread_.join();
  }

  void Ask(const core::RgbdFrame& frame, double timeout_s) override {
    const absl::MutexLock lock(&mutex_);
    DropLocked();
    ++number_;
    question_ = frame;
    if (options_.trace != nullptr) {
      traceparent_ = options_.trace->BeginQuestion();
    }
    timeout_s_ = timeout_s;
    deadline_ = After(clock_.Now(), timeout_s);
    is_asking_ = true;
    changed_.SignalAll();
  }

  std::optional<Answer> TakeAnswer() override {
    const absl::MutexLock lock(&mutex_);
    if (answer_.has_value()) {
      is_asking_ = false;
      if (options_.trace != nullptr) options_.trace->EndQuestion(*answer_);
      return std::exchange(answer_, std::nullopt);
    }
    if (is_asking_ && clock_.Now() >= deadline_) {
      const Answer late =
          absl::DeadlineExceededError("the server did not answer in time");
      if (options_.trace != nullptr) options_.trace->EndQuestion(late);
      DropLocked();
      return late;
    }
    return std::nullopt;
  }

  bool IsAsking() const override {
    const absl::MutexLock lock(&mutex_);
    return is_asking_;
  }

  void Cancel() override {
    const absl::MutexLock lock(&mutex_);
    DropLocked();
    changed_.SignalAll();
  }

 private:
  void DropLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    ++number_;
    question_.reset();
    answer_.reset();
    is_asking_ = false;
    if (options_.trace != nullptr) options_.trace->CancelQuestion();
    call_.request_stop();
  }

  void Work(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      core::RgbdFrame frame;
      double timeout_s = 0;
      std::string traceparent;
      uint64_t number = 0;
      std::stop_token call_stop;
      {
        const absl::MutexLock lock(&mutex_);
        while (!question_.has_value() && !stop.stop_requested()) {
          changed_.Wait(&mutex_);
        }
        if (stop.stop_requested()) return;
        frame = *std::move(question_);
        question_.reset();
        timeout_s = timeout_s_;
        traceparent = traceparent_;
        number = number_;
        call_ = std::stop_source();
        call_stop = call_.get_token();
      }
      Answer answer = AskNow(*relocalizer_, options_, frame, timeout_s,
                             call_stop, traceparent);
      const absl::MutexLock lock(&mutex_);
      // Nobody waits for what was cancelled.
      if (number == number_) answer_ = std::move(answer);
    }
  }

  const std::shared_ptr<relocalizer::Relocalizer> relocalizer_;
  const ServerRelocalizationOptions options_;
  const base::Clock& clock_;
  mutable absl::Mutex mutex_;
  absl::CondVar changed_;
  // Of the question that counts.
  uint64_t number_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<core::RgbdFrame> question_ ABSL_GUARDED_BY(mutex_);
  double timeout_s_ ABSL_GUARDED_BY(mutex_) = 0;
  std::string traceparent_ ABSL_GUARDED_BY(mutex_);
  base::MonotonicTime deadline_ ABSL_GUARDED_BY(mutex_);
  bool is_asking_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<Answer> answer_ ABSL_GUARDED_BY(mutex_);
  std::stop_source call_ ABSL_GUARDED_BY(mutex_);
  // The last member: it uses all others.
  std::jthread thread_;
};

class SynchronousRelocalization final : public core::RelocalizationPort {
 public:
  SynchronousRelocalization(
      std::shared_ptr<relocalizer::Relocalizer> relocalizer,
      ServerRelocalizationOptions options, const base::Clock& clock,
      const SynchronousOptions& timing)
      : relocalizer_(std::move(relocalizer)),
        options_(std::move(options)),
        clock_(clock),
        timing_(timing) {}

  void Ask(const core::RgbdFrame& frame, double timeout_s) override {
    const auto began = std::chrono::steady_clock::now();
    answer_ = AskNow(*relocalizer_, options_, frame,
                     timing_.real_timeout_s.value_or(timeout_s), {});
    const double really_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began)
            .count();
    double took_s = timing_.latency_s.value_or(really_s) + timing_.extra_s;
    if (absl::IsDeadlineExceeded(answer_->status())) took_s = timeout_s;
    if (took_s > timeout_s) {
      answer_ = Answer(
          absl::DeadlineExceededError("the server did not answer in time"));
      took_s = timeout_s;
    }
    if (answer_->ok()) (*answer_)->round_trip_s = took_s;
    ready_ = After(clock_.Now(), took_s);
  }

  std::optional<Answer> TakeAnswer() override {
    if (!answer_.has_value() || clock_.Now() < ready_) return std::nullopt;
    return std::exchange(answer_, std::nullopt);
  }

  bool IsAsking() const override { return answer_.has_value(); }
  void Cancel() override { answer_.reset(); }

 private:
  const std::shared_ptr<relocalizer::Relocalizer> relocalizer_;
  const ServerRelocalizationOptions options_;
  const base::Clock& clock_;
  const SynchronousOptions timing_;
  std::optional<Answer> answer_;
  base::MonotonicTime ready_;
};

absl::Status Check(const std::shared_ptr<relocalizer::Relocalizer>& relocalizer,
                   const ServerRelocalizationOptions& options) {
  if (relocalizer == nullptr) {
    return absl::InvalidArgumentError("relocalization: no connection");
  }
  return options.Validate();
}

}  // namespace

absl::Status ServerRelocalizationOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("relocalization: jpeg_quality", jpeg_quality, 1, 100));
  return base::CheckRange("relocalization: min_confidence", min_confidence, 0,
                          1);
}

absl::StatusOr<wire::QueryFrame> EncodeFrame(const image::Frame& frame,
                                             int jpeg_quality) {
  if (frame.color.width < 1 || frame.color.height < 1) {
    return absl::InvalidArgumentError("a frame without a colour picture");
  }
  wire::QueryFrame query;
  wire::EncodedImage color;
  TL_ASSIGN_OR_RETURN(color.bytes,
                      image::EncodeJpeg(frame.color, jpeg_quality));
  query.color = std::move(color);
  const std::optional<camera::RgbdCalibration>& calibration = frame.calibration;
  if (calibration.has_value()) query.camera = calibration->color;
  if (!frame.depth.has_value()) return query;
  wire::EncodedImage png;
  TL_ASSIGN_OR_RETURN(png.bytes, image::EncodeDepthPng(*frame.depth));
  wire::QueryDepth depth;
  depth.image = std::move(png);
  depth.unit_m = frame.depth->unit_m;
  if (calibration.has_value()) {
    const bool is_registered =
        calibration->depth == calibration->color &&
        calibration->color_from_depth == geometry::Rigid3();
    depth.registration = is_registered
                             ? wire::DepthRegistration::kRegisteredToColor
                             : wire::DepthRegistration::kExplicit;
    if (!is_registered) {
      depth.geometry = wire::QueryDepth::Geometry{
          .depth_camera = calibration->depth,
          .color_from_depth = calibration->color_from_depth};
    }
    depth.depth_scale = calibration->depth_scale;
  }
  query.depth = std::move(depth);
  return query;
}

absl::StatusOr<std::unique_ptr<core::RelocalizationPort>>
MakeServerRelocalization(std::shared_ptr<relocalizer::Relocalizer> relocalizer,
                         const ServerRelocalizationOptions& options,
                         const base::Clock& clock) {
  TL_RETURN_IF_ERROR(Check(relocalizer, options));
  return std::make_unique<ServerRelocalization>(std::move(relocalizer), options,
                                                clock);
}

absl::StatusOr<std::unique_ptr<core::RelocalizationPort>>
MakeServerRelocalization(const relocalizer::ConnectOptions& connection,
                         const std::string& scene, const base::Clock& clock,
                         RecoveryTrace* trace) {
  TL_ASSIGN_OR_RETURN(std::shared_ptr<relocalizer::Relocalizer> relocalizer,
                      relocalizer::ConnectRelocalizer(connection));
  return MakeServerRelocalization(std::move(relocalizer),
                                  {.scene = scene, .trace = trace}, clock);
}

absl::StatusOr<std::unique_ptr<core::RelocalizationPort>>
MakeSynchronousRelocalization(
    std::shared_ptr<relocalizer::Relocalizer> relocalizer,
    const ServerRelocalizationOptions& options, const base::Clock& clock,
    const SynchronousOptions& timing) {
  TL_RETURN_IF_ERROR(Check(relocalizer, options));
  return std::make_unique<SynchronousRelocalization>(std::move(relocalizer),
                                                     options, clock, timing);
}

}  // namespace treeline::relocalization

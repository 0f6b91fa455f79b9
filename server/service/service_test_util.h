// For the tests of this folder: scenes whose localizer is a function.
#ifndef SERVER_SERVICE_SERVICE_TEST_UTIL_H_
#define SERVER_SERVICE_SERVICE_TEST_UTIL_H_

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/wire/frame.h"
#include "gtest/gtest.h"
#include "server/repository/folder_source.h"
#include "server/repository/scene_repository.h"
#include "server/service/call_observer.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::service {

using LocalizeFunction = std::function<absl::StatusOr<localizer::PoseEstimate>(
    const image::Frame&, const localizer::LocalizeOptions&)>;

inline constexpr int kTestWidth = 40;
inline constexpr int kTestHeight = 30;

// Colour and depth of 40 x 30 pixels; poses are the depth camera's.
inline camera::RgbdCalibration TestCalibration() {
  const double parameters[] = {35, 20, 15};
  camera::RgbdCalibration calibration;
  calibration.color =
      camera::Camera::Create(camera::CameraModel::kSimplePinhole, kTestWidth,
                             kTestHeight, parameters, 3)
          .value();
  calibration.depth = calibration.color;
  calibration.color_from_depth.translation = {0.025, 0, 0};
  calibration.depth_scale = 1.01;
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return calibration;
}

class FakeLocalizer final : public localizer::Localizer {
 public:
  FakeLocalizer(std::string method, LocalizeFunction localize)
      : localize_(std::move(localize)) {
    info_.method = std::move(method);
    info_.calibration = TestCalibration();
  }
  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame& frame,
      const localizer::LocalizeOptions& options) const override {
    return localize_(frame, options);
  }
  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }

 private:
  forest::ModelInfo info_;
  LocalizeFunction localize_;
};

// A repository of scenes "name" -> function, each with one version "1", and
// one corrupt scene, "broken".
class FakeScenes {
 public:
  // keep_files: until this is destroyed, rather than until all is loaded.
  explicit FakeScenes(const std::map<std::string, LocalizeFunction>& scenes,
                      bool keep_files = false) {
    namespace fs = std::filesystem;
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    const fs::path root = fs::path(testing::TempDir()) /
                          ("scenes-" + std::to_string(getpid()) + "-" +
                           test->test_suite_name() + "-" + test->name());
    const auto put = [&](const std::string& name) {
      fs::create_directories(root / name / "1");
      std::ofstream(root / name / "1" / "model.treeline") << name;
    };
    put("broken");
    for (const auto& [name, localize] : scenes) put(name);
    repository_ =
        repository::SceneRepository::Open(
            std::make_unique<repository::FolderSource>(root.string()),
            [scenes](const std::string& path)
                -> absl::StatusOr<std::unique_ptr<localizer::Localizer>> {
              const std::string name =
                  fs::path(path).parent_path().parent_path().filename();
              const auto scene = scenes.find(name);
              if (scene == scenes.end()) {
                return absl::DataLossError("checksum differs");
              }
              return std::make_unique<FakeLocalizer>(name, scene->second);
            },
            {.load_all_at_start = true}, clock_)
            .value();
    EXPECT_TRUE(repository_->WaitForLoads().ok());
    root_ = root.string();
    if (!keep_files) fs::remove_all(root);
  }
  ~FakeScenes() { std::filesystem::remove_all(root_); }

  repository::SceneRepository& repository() const { return *repository_; }

 private:
  base::SteadyClock clock_;
  std::string root_;
  std::unique_ptr<repository::SceneRepository> repository_;
};

// A valid request: raw colour and raw depth from the scene's own cameras.
inline v1::LocalizeRequest TestRequest(const std::string& scene) {
  wire::QueryFrame frame;
  frame.color = image::ColorImage{
      .width = kTestWidth,
      .height = kTestHeight,
      .rgb = std::vector<uint8_t>(3 * kTestWidth * kTestHeight, 100)};
  frame.depth = wire::QueryDepth{
      .image = image::DepthImage{
          .width = kTestWidth,
          .height = kTestHeight,
          .values = std::vector<uint16_t>(kTestWidth * kTestHeight, 1500)}};
  v1::LocalizeRequest request;
  request.set_scene(scene);
  *request.mutable_frame() = wire::ToProto(frame);
  return request;
}

inline localizer::PoseEstimate LocalizedEstimate() {
  localizer::PoseEstimate estimate;
  estimate.outcome = localizer::Outcome::kLocalized;
  estimate.reason = localizer::NotLocalizedReason::kNone;
  estimate.world_from_camera = {
      geometry::Normalized(
          geometry::Rotation3::FromAxisAngle({0.1, -0.2, 0.3})),
      {1.5, -0.25, 3}};
  for (size_t i = 0; i < estimate.covariance.size(); ++i) {
    estimate.covariance[i] = 1e-6 * static_cast<double>(i);
  }
  estimate.inliers = 432;
  estimate.samples = 500;
  estimate.inlier_ratio = 432.0 / 500;
  estimate.timings = {
      .sample_ms = 0.5, .forest_ms = 2, .pose_ms = 1, .total_ms = 3.75};
  return estimate;
}

class RecordingObserver final : public CallObserver {
 public:
  void OnCall(const CallRecord& record) override {
    absl::MutexLock lock(&mutex_);
    records_.push_back(record);
  }
  std::vector<CallRecord> records() const {
    absl::MutexLock lock(&mutex_);
    return records_;
  }

 private:
  mutable absl::Mutex mutex_;
  std::vector<CallRecord> records_ ABSL_GUARDED_BY(mutex_);
};

// A clock that each look moves on.
class SteppingClock final : public base::Clock {
 public:
  explicit SteppingClock(std::chrono::milliseconds step) : step_(step) {}
  base::MonotonicTime Now() const override {
    absl::MutexLock lock(&mutex_);
    return now_ += step_;
  }

 private:
  const std::chrono::milliseconds step_;
  mutable absl::Mutex mutex_;
  mutable base::MonotonicTime now_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_SERVICE_TEST_UTIL_H_

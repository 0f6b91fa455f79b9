// A small recording on disk and a localizer made of a function, for tests.
#ifndef SERVER_TOOLS_TESTING_FIXTURES_H_
#define SERVER_TOOLS_TESTING_FIXTURES_H_

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/core/localizer/localizer.h"

namespace treeline::tools {

// A 7-Scenes folder of 8 x 6 images under the test's temporary folder. The
// first red value of frame i is i. Removed when destroyed.
class SmallRecording {
 public:
  // poses[i] (world_from_depth) is frame i's; frames beyond have none.
  SmallRecording(int frames, const std::vector<geometry::Rigid3>& poses);
  ~SmallRecording();
  SmallRecording(const SmallRecording&) = delete;
  SmallRecording& operator=(const SmallRecording&) = delete;

  dataset::DatasetOptions options() const;
  dataset::Dataset Open() const;
  const std::string& folder() const { return folder_; }
  std::string ColorPath(int i) const;

 private:
  std::string folder_;
};

// The number that SmallRecording put into a frame.
inline int FrameNumber(const image::Frame& frame) { return frame.color.rgb[0]; }

// A folder of its own for a test, removed when destroyed.
class TestFolder {
 public:
  TestFolder();
  ~TestFolder();
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  // The path of something in it.
  std::string operator/(const std::string& name) const;

 private:
  std::string path_;
};

// How to open what WriteBoxRoomRecording wrote to `folder` with
// BoxRoomCalibration(). Poses are of that calibration's pose sensor.
dataset::DatasetOptions BoxRoomOptions(const std::string& folder);

// Answers with what a function says.
class FunctionLocalizer final : public localizer::Localizer {
 public:
  using Function = std::function<absl::StatusOr<localizer::PoseEstimate>(
      const image::Frame&, const localizer::LocalizeOptions&)>;

  FunctionLocalizer(forest::ModelInfo info, Function function)
      : info_(std::move(info)), function_(std::move(function)) {}

  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame& frame,
      const localizer::LocalizeOptions& options) const override {
    return function_(frame, options);
  }
  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }

 private:
  const forest::ModelInfo info_;
  const Function function_;
};

// A localized estimate at this pose, 40 of 50 samples inliers.
localizer::PoseEstimate LocalizedAt(const geometry::Rigid3& world_from_camera);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_TESTING_FIXTURES_H_

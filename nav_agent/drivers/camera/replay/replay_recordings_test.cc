// Real recordings as a camera (TREELINE_DATA).
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/drivers/camera/replay/replay_camera.h"

namespace treeline::replay_camera {
namespace {

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now{std::chrono::hours(1)};
};

// Empty if the recording is not there.
std::string Folder(const std::string& name) {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string folder =
      std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) + "/" + name;
  return std::filesystem::is_directory(folder) ? folder : "";
}

std::unique_ptr<ReplayCamera> Open(const dataset::DatasetOptions& options,
                                   const base::Clock& clock) {
  auto dataset = dataset::Dataset::Open(options);
  EXPECT_TRUE(dataset.ok()) << dataset.status();
  auto camera = ReplayCamera::Create({}, *std::move(dataset), clock);
  EXPECT_TRUE(camera.ok()) << camera.status();
  return *std::move(camera);
}

TEST(ReplayRecordingsTest, TumPlaysInItsOwnTime) {
  const std::string folder = Folder("tum-fr1-rpy/train");
  if (folder.empty()) GTEST_SKIP() << "no tum-fr1-rpy in TREELINE_DATA";
  FakeClock clock;
  const auto camera = Open({.uri = "tum:" + folder}, clock);
  const int size = camera->dataset().size();
  ASSERT_GT(size, 50);
  const base::MonotonicTime start = clock.now;
  std::vector<core::RgbdFrame> frames;
  while (camera->Health().state != core::DeviceState::kLost) {
    for (core::RgbdFrame& frame : camera->TakeFrames()) {
      EXPECT_LE(frame.stamp, clock.now);
      EXPECT_GT(frame.stamp, clock.now - std::chrono::milliseconds(10));
      // A real view: of the size of the calibration, with depth.
      EXPECT_EQ(frame.frame.color.width, camera->Calibration().color.width());
      ASSERT_TRUE(frame.frame.depth.has_value());
      frame.frame = {};
      frames.push_back(std::move(frame));
    }
    clock.now += std::chrono::milliseconds(10);
  }
  EXPECT_EQ(frames.size(), static_cast<size_t>(size));
  EXPECT_EQ(camera->Health().corrupt, 0);
  EXPECT_EQ(camera->Health().dropped, 0);
  EXPECT_NEAR(base::MillisecondsBetween(start, frames.back().stamp),
              1000 * camera->duration_s(), 1e-3);
  // A Kinect takes 30 frames a second; nobody recorded faster.
  for (size_t i = 1; i < frames.size(); ++i) {
    EXPECT_GT(base::MillisecondsBetween(frames[i - 1].stamp, frames[i].stamp),
              15);
  }
  int known = 0;
  for (const core::RgbdFrame& frame : frames) {
    const int index = camera->DatasetFrameOf(frame.sequence);
    known += camera->dataset().frame(index).world_from_camera ? 1 : 0;
  }
  EXPECT_GT(known, size / 2);
}

TEST(ReplayRecordingsTest, SevenScenesPlaysAt30Hz) {
  const std::string folder = Folder("7scenes-redkitchen");
  if (folder.empty()) GTEST_SKIP() << "no red kitchen in TREELINE_DATA";
  FakeClock clock;
  const auto camera = Open({.uri = "7scenes:" + folder,
                            .frame_list = folder + "/test.txt",
                            .pose_file = folder + "/poses-sfm.txt"},
                           clock);
  // Frames 120-179, 320-379 and 520-579.
  ASSERT_EQ(camera->dataset().size(), 180);
  EXPECT_NEAR(camera->duration_s(), (579 - 120) / 30.0, 1e-9);
  clock.now += std::chrono::milliseconds(1005);
  const auto frames = camera->TakeFrames();
  ASSERT_EQ(frames.size(), 31u);
  EXPECT_EQ(camera->dataset().frame(camera->DatasetFrameOf(30)).stem,
            "seq-01/frame-000150");
  ASSERT_TRUE(camera->Seek(camera->duration_s()).ok());
  const auto last = camera->TakeFrames();
  ASSERT_EQ(last.size(), 1u);
  const int index = camera->DatasetFrameOf(last[0].sequence);
  EXPECT_EQ(camera->dataset().frame(index).stem, "seq-01/frame-000579");
  EXPECT_TRUE(camera->dataset().frame(index).world_from_camera.has_value());
}

}  // namespace
}  // namespace treeline::replay_camera

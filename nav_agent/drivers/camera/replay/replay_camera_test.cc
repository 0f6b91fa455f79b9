#include "nav_agent/drivers/camera/replay/replay_camera.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/synchronization/mutex.h"
#include "common/base/file.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::replay_camera {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    absl::MutexLock lock(&mutex_);
    return now_;
  }
  void Advance(std::chrono::nanoseconds by) {
    absl::MutexLock lock(&mutex_);
    now_ += by;
  }

 private:
  mutable absl::Mutex mutex_;
  base::MonotonicTime now_ ABSL_GUARDED_BY(mutex_){std::chrono::hours(1)};
};

// The recordings' frames are 16 x 8 pixels of a grey that counts them.
class ReplayCameraTest : public ::testing::Test {
 protected:
  ReplayCameraTest()
      : folder_(absl::StrCat(
            ::testing::TempDir(), "/replay-", getpid(), "-",
            ::testing::UnitTest::GetInstance()->current_test_info()->name())) {}
  ~ReplayCameraTest() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& name, const std::string& contents) const {
    const std::string path = folder_ + "/" + name;
    ASSERT_TRUE(base::MakeParentFolder(path).ok());
    ASSERT_TRUE(base::WriteFileAtomically(path, contents).ok());
  }
  static std::string Color(int grey) {
    image::ColorImage image = {.width = 16, .height = 8, .rgb = {}};
    image.rgb.assign(3 * 16 * 8, static_cast<uint8_t>(grey));
    return *image::EncodePng(image);
  }
  static std::string Depth(int value) {
    image::DepthImage image = {.width = 16, .height = 8, .values = {}};
    image.values.assign(16 * 8, static_cast<uint16_t>(value));
    return *image::EncodeDepthPng(image);
  }
  void WriteSevenScenesFrame(const std::string& sequence, int number,
                             int grey) const {
    const std::string stem = absl::StrFormat("%s/frame-%06d", sequence, number);
    Write(stem + ".color.png", Color(grey));
    Write(stem + ".depth.png", Depth(1000 + grey));
    Write(stem + ".pose.txt",
          absl::StrFormat("1 0 0 %d\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", grey));
  }
  // `count` frames, 30 a second.
  dataset::Dataset SevenScenes(int count) const {
    for (int i = 0; i < count; ++i) WriteSevenScenesFrame("seq-01", i, i);
    return OpenSevenScenes();
  }
  dataset::Dataset OpenSevenScenes() const {
    auto dataset =
        dataset::Dataset::Open({.uri = "7scenes:" + folder_,
                                .color_camera = "PINHOLE,20,20,7.5,3.5",
                                .depth_camera = "PINHOLE,20,20,7.5,3.5"});
    EXPECT_TRUE(dataset.ok()) << dataset.status();
    return *std::move(dataset);
  }
  dataset::Dataset Tum(const std::vector<std::string>& times) const {
    std::string rgb;
    std::string depth;
    std::string poses;
    for (size_t i = 0; i < times.size(); ++i) {
      const int grey = static_cast<int>(i);
      Write(absl::StrCat("rgb/", i, ".png"), Color(grey));
      Write(absl::StrCat("depth/", i, ".png"), Depth(5000 + grey));
      absl::StrAppend(&rgb, times[i], " rgb/", i, ".png\n");
      absl::StrAppend(&depth, times[i], " depth/", i, ".png\n");
      absl::StrAppend(&poses, times[i], " ", i, " 0 0 0 0 0 1\n");
    }
    Write("rgb.txt", rgb);
    Write("depth.txt", depth);
    Write("groundtruth.txt", poses);
    auto dataset = dataset::Dataset::Open(
        {.uri = "tum:" + folder_, .color_camera = "PINHOLE,20,20,7.5,3.5"});
    EXPECT_TRUE(dataset.ok()) << dataset.status();
    return *std::move(dataset);
  }
  std::unique_ptr<ReplayCamera> Replay(
      dataset::Dataset dataset, const ReplayCameraOptions& options = {}) {
    auto camera = ReplayCamera::Create(options, std::move(dataset), clock_);
    EXPECT_TRUE(camera.ok()) << camera.status();
    return *std::move(camera);
  }
  static std::vector<int> Greys(const std::vector<core::RgbdFrame>& frames) {
    std::vector<int> greys;
    for (const core::RgbdFrame& frame : frames) {
      greys.push_back(frame.frame.color.rgb[0]);
    }
    return greys;
  }

  const std::string folder_;
  FakeClock clock_;
};

TEST_F(ReplayCameraTest, FramesComeWhenTheyAreDue) {
  const auto camera = Replay(SevenScenes(5));
  const base::MonotonicTime start = clock_.Now();
  const auto first = camera->TakeFrames();
  EXPECT_THAT(Greys(first), ElementsAre(0));
  EXPECT_EQ(first[0].stamp, start);
  EXPECT_THAT(camera->TakeFrames(), IsEmpty());
  clock_.Advance(milliseconds(33));
  EXPECT_THAT(camera->TakeFrames(), IsEmpty());
  clock_.Advance(milliseconds(1));
  EXPECT_THAT(Greys(camera->TakeFrames()), ElementsAre(1));
  clock_.Advance(milliseconds(67));
  const auto two = camera->TakeFrames();
  EXPECT_THAT(Greys(two), ElementsAre(2, 3));
  EXPECT_EQ(two[1].sequence, 3);
  EXPECT_NEAR(base::MillisecondsBetween(start, two[1].stamp), 100, 1e-5);
  EXPECT_EQ(camera->Health().received, 4);
  EXPECT_EQ(camera->Health().state, core::DeviceState::kRunning);
}

TEST_F(ReplayCameraTest, FramesCarryDepthAndCalibration) {
  const auto camera = Replay(SevenScenes(1));
  const auto frames = camera->TakeFrames();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].frame.depth->values[0], 1000);
  ASSERT_TRUE(frames[0].frame.calibration.has_value());
  EXPECT_EQ(frames[0].frame.calibration, camera->Calibration());
  EXPECT_EQ(camera->Calibration().color.fx(), 20);
}

TEST_F(ReplayCameraTest, TumKeepsItsTimeStamps) {
  const auto camera = Replay(Tum({"1305031910.765238", "1305031910.797230",
                                  "1305031911.000000", "1305031915.250000"}));
  const base::MonotonicTime start = clock_.Now();
  clock_.Advance(std::chrono::seconds(5));
  const auto frames = camera->TakeFrames();
  ASSERT_EQ(frames.size(), 4u);
  // To a microsecond, as they are written.
  EXPECT_NEAR(base::MillisecondsBetween(start, frames[1].stamp), 31.992, 1e-3);
  EXPECT_NEAR(base::MillisecondsBetween(start, frames[2].stamp), 234.762, 1e-3);
  EXPECT_NEAR(camera->duration_s(), 4.484762, 1e-6);
}

TEST_F(ReplayCameraTest, SevenScenesKeepsItsGaps) {
  WriteSevenScenesFrame("seq-01", 10, 0);
  WriteSevenScenesFrame("seq-01", 40, 1);
  const auto camera = Replay(OpenSevenScenes());
  clock_.Advance(milliseconds(999));
  EXPECT_THAT(Greys(camera->TakeFrames()), ElementsAre(0));
  clock_.Advance(milliseconds(1));
  EXPECT_THAT(Greys(camera->TakeFrames()), ElementsAre(1));
}

TEST_F(ReplayCameraTest, RateSpeedsUp) {
  const auto camera = Replay(SevenScenes(9), {.rate = 4});
  const base::MonotonicTime start = clock_.Now();
  clock_.Advance(microseconds(33334));
  const auto frames = camera->TakeFrames();
  EXPECT_THAT(Greys(frames), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_NEAR(base::MillisecondsBetween(start, frames[4].stamp), 1000.0 / 30,
              1e-5);
}

TEST_F(ReplayCameraTest, TheEndIsALoss) {
  const auto camera = Replay(SevenScenes(2));
  clock_.Advance(std::chrono::seconds(1));
  EXPECT_EQ(camera->TakeFrames().size(), 2u);
  EXPECT_EQ(camera->Health().state, core::DeviceState::kRunning);
  EXPECT_THAT(camera->TakeFrames(), IsEmpty());
  EXPECT_EQ(camera->Health().state, core::DeviceState::kLost);
  EXPECT_EQ(camera->Health().cause.code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(camera->Health().losses, 1);
  // Seeking revives it.
  ASSERT_TRUE(camera->Seek(0).ok());
  EXPECT_EQ(camera->TakeFrames().size(), 1u);
  EXPECT_EQ(camera->Health().state, core::DeviceState::kRunning);
}

TEST_F(ReplayCameraTest, ALoopGoesOnAFrameLater) {
  const auto camera = Replay(SevenScenes(3), {.loop = true});
  const base::MonotonicTime start = clock_.Now();
  clock_.Advance(milliseconds(234));
  const auto frames = camera->TakeFrames();
  EXPECT_THAT(Greys(frames), ElementsAre(0, 1, 2, 0, 1, 2, 0, 1));
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_NEAR(base::MillisecondsBetween(start, frames[i].stamp),
                static_cast<double>(i) * 1000 / 30, 1e-5);
    EXPECT_EQ(frames[i].sequence, static_cast<int64_t>(i));
    EXPECT_EQ(camera->DatasetFrameOf(frames[i].sequence),
              static_cast<int>(i) % 3);
  }
}

TEST_F(ReplayCameraTest, SeekingAndBeginningLater) {
  const auto camera = Replay(SevenScenes(10), {.begin_s = 0.15});
  // Frame 5 is at 0.1667 s.
  EXPECT_THAT(camera->TakeFrames(), IsEmpty());
  clock_.Advance(milliseconds(17));
  EXPECT_THAT(Greys(camera->TakeFrames()), ElementsAre(5));
  ASSERT_TRUE(camera->Seek(0.3).ok());
  const auto last = camera->TakeFrames();
  EXPECT_THAT(Greys(last), ElementsAre(9));
  EXPECT_EQ(last[0].sequence, 1);
  EXPECT_EQ(last[0].stamp, clock_.Now());
  ASSERT_TRUE(camera->Seek(0).ok());
  clock_.Advance(milliseconds(40));
  EXPECT_THAT(Greys(camera->TakeFrames()), ElementsAre(0, 1));
  EXPECT_EQ(camera->DatasetFrameOf(0), 5);
  EXPECT_EQ(camera->DatasetFrameOf(1), 9);
  EXPECT_EQ(camera->DatasetFrameOf(3), 1);
  EXPECT_EQ(camera->DatasetFrameOf(4), -1);
  EXPECT_EQ(camera->DatasetFrameOf(-1), -1);
  EXPECT_FALSE(camera->Seek(0.31).ok());
  EXPECT_FALSE(camera->Seek(std::nan("")).ok());
}

TEST_F(ReplayCameraTest, TruePosesLieBeside) {
  const auto camera = Replay(SevenScenes(3));
  clock_.Advance(milliseconds(100));
  for (const core::RgbdFrame& frame : camera->TakeFrames()) {
    const int index = camera->DatasetFrameOf(frame.sequence);
    EXPECT_EQ(camera->dataset().frame(index).world_from_camera->translation.x,
              frame.frame.color.rgb[0]);
  }
}

TEST_F(ReplayCameraTest, WhoComesLateGetsTheLatest) {
  const auto camera = Replay(SevenScenes(100));
  clock_.Advance(std::chrono::seconds(10));
  const auto frames = camera->TakeFrames();
  ASSERT_EQ(frames.size(), size_t{core::kMaxWaiting});
  EXPECT_EQ(frames.front().sequence, 100 - core::kMaxWaiting);
  EXPECT_EQ(Greys(frames).front(), 100 - core::kMaxWaiting);
  EXPECT_EQ(frames.back().sequence, 99);
  EXPECT_EQ(camera->Health().dropped, 100 - core::kMaxWaiting);
}

TEST_F(ReplayCameraTest, FilesThatAreBrokenAreLeftOut) {
  const dataset::Dataset dataset = SevenScenes(4);
  Write("seq-01/frame-000001.color.png", "broken");
  std::filesystem::remove(folder_ + "/seq-01/frame-000002.depth.png");
  const auto camera = Replay(dataset);
  clock_.Advance(milliseconds(101));
  EXPECT_THAT(Greys(camera->TakeFrames()), ElementsAre(0, 3));
  EXPECT_EQ(camera->Health().corrupt, 2);
}

// Whatever the thread does meanwhile, the clock alone decides.
TEST_F(ReplayCameraTest, TheSameClockGivesTheSameFrames) {
  const dataset::Dataset dataset = SevenScenes(60);
  std::vector<std::vector<int>> runs;
  for (const int ahead : {1, 3, 64}) {
    const auto camera = Replay(dataset, {.loop = true, .decode_ahead = ahead});
    std::vector<int> counts;
    for (int i = 0; i < 100; ++i) {
      counts.push_back(static_cast<int>(camera->TakeFrames().size()));
      clock_.Advance(milliseconds((i * 37) % 90));
    }
    runs.push_back(counts);
  }
  EXPECT_EQ(runs[0], runs[1]);
  EXPECT_EQ(runs[0], runs[2]);
}

TEST_F(ReplayCameraTest, BadOptionsAreRefused) {
  const dataset::Dataset dataset = SevenScenes(2);
  const ReplayCameraOptions bad[] = {{.rate = 0},
                                     {.rate = std::nan("")},
                                     {.begin_s = -1},
                                     {.begin_s = 2},
                                     {.decode_ahead = 0}};
  for (const ReplayCameraOptions& options : bad) {
    EXPECT_EQ(ReplayCamera::Create(options, dataset, clock_).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace treeline::replay_camera

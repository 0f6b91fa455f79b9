#include "nav_agent/app/map/live_scene.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::map_app {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr dataset::Time_ns kSecond = 1'000'000'000;

// In place of the learner: a script that is told what the learner is told.
class LiveSceneTest : public testing::Test {
 protected:
  void UseScript(const std::string& script) {
    folder_.Write("learner", absl::StrCat("#!/bin/sh\n", script, "\n"));
    std::filesystem::permissions(folder_.Path("learner"),
                                 std::filesystem::perms::owner_all);
    options_.learner = folder_.Path("learner");
    options_.repository = folder_.Path("models");
    options_.scene = "place";
    options_.folder = folder_.Path("learning");
    options_.log = folder_.Path("log");
    options_.say = [this](const std::string& line) {
      absl::StrAppend(&said_, line, "\n");
    };
  }
  std::unique_ptr<LiveScene> Create() {
    auto scene = LiveScene::Create(options_);
    EXPECT_TRUE(scene.ok()) << scene.status();
    return *std::move(scene);
  }
  static recording::LogFrame FrameAt(double time_s) {
    return {.stamp = base::MonotonicTime(
                std::chrono::milliseconds(static_cast<int>(1000 * time_s))),
            .color = "colour",
            .depth = "depth"};
  }
  // A place each 0.1 s, forward with 1 m/s, until `seconds`.
  static std::vector<dataset::TimedPose> Straight(double seconds,
                                                  double y_m = 0) {
    std::vector<dataset::TimedPose> poses;
    for (int i = 0; i <= static_cast<int>(10 * seconds + 0.5); ++i) {
      poses.push_back({.time = i * kSecond / 10,
                       .world_from_camera = {{}, {0.1 * i, y_m, 0}}});
    }
    return poses;
  }
  std::vector<std::string> Lines() const {
    const auto text = base::ReadFile(folder_.Path("lines"));
    EXPECT_TRUE(text.ok()) << text.status();
    return absl::StrSplit(*text, '\n', absl::SkipEmpty());
  }

  const base::TestingFolder folder_;
  LiveSceneOptions options_;
  std::string said_;
  const geometry::Rigid3 base_from_camera_{{}, {0, 0, 1.25}};
};

TEST_F(LiveSceneTest, HandsOverFramesWithTheirPlacesAndCorrectsThem) {
  UseScript(absl::StrCat("echo \"$@\"; cat >'", folder_.Path("lines"), "'"));
  const auto scene = Create();
  for (const double time_s : {0.05, 0.06, 0.55, 1.55}) {
    scene->Add(FrameAt(time_s), {});
  }
  // The second is where the first one is, of the last nothing is known yet.
  scene->Follow(Straight(1), base_from_camera_);
  EXPECT_EQ(scene->status().frames, 2);
  scene->Follow(Straight(2), base_from_camera_);
  EXPECT_EQ(scene->status().frames, 3);
  // A little is not worth it, much is.
  scene->Follow(Straight(2, 0.03), base_from_camera_);
  EXPECT_EQ(scene->status().corrections, 0);
  scene->Follow(Straight(2, 0.2), base_from_camera_);
  EXPECT_EQ(scene->status().corrections, 1);
  EXPECT_NEAR(scene->status().moved_m, 0.2, 1e-6);
  // Soon the map will be there.
  scene->End(Straight(2, 0.21), base_from_camera_);
  scene->Finish(Straight(2, 0.21), base_from_camera_, {});
  const std::vector<std::string> lines = Lines();
  const std::string first = folder_.Path("learning/frame-000000");
  ASSERT_EQ(lines.size(), 3 + 3 + 1 + 3);
  EXPECT_EQ(lines[0], absl::StrCat(first, ".color.png ", first,
                                   ".depth.png 0.050000 0.000000 1.250000 "
                                   "0.000000000 0.000000000 0.000000000 "
                                   "1.000000000"));
  EXPECT_THAT(lines[3], StartsWith(absl::StrCat(
                            "pose ", first, ".color.png 0.050000 0.200000")));
  EXPECT_EQ(lines[6], "end");
  EXPECT_THAT(lines[7], HasSubstr(" 0.210000 "));
  EXPECT_THAT(said_, HasSubstr("learn --live - --corrections"));
  EXPECT_THAT(said_, HasSubstr("--scene place"));
}

TEST_F(LiveSceneTest, KeepsFewPicturesAndNoneAtTheEnd) {
  UseScript("cat >/dev/null");
  auto scene = Create();
  constexpr int kFrames = 45;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < kFrames; ++i) {
      scene->Add(FrameAt(0.1 * (kFrames * round + i)), {});
    }
    scene->Follow(Straight(0.1 * kFrames * (round + 1)), base_from_camera_);
  }
  EXPECT_EQ(scene->status().frames, 10 * kFrames);
  const auto pictures =
      std::distance(std::filesystem::directory_iterator(options_.folder), {});
  EXPECT_LE(pictures, 2 * 200 + 1);  // and the calibration
  scene.reset();
  EXPECT_FALSE(std::filesystem::exists(options_.folder));
}

// Mapping must not even notice.
TEST_F(LiveSceneTest, SaysOnceThatTheLearnerHasEnded) {
  UseScript("echo no room; exit 3");
  const auto scene = Create();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  for (int i = 0; said_.empty() && std::chrono::steady_clock::now() < end;
       ++i) {
    scene->Add(FrameAt(0.1 * i), {});
    scene->Follow(Straight(0.1 * i + 1), base_from_camera_);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_THAT(said_, HasSubstr("has ended with 3"));
  EXPECT_THAT(said_, HasSubstr("no room"));
  EXPECT_THAT(said_, HasSubstr("the map is not concerned"));
  said_.clear();
  scene->Add(FrameAt(900), {});
  scene->End(Straight(1000), base_from_camera_);
  scene->Finish(Straight(1000), base_from_camera_, {});
  EXPECT_THAT(said_, IsEmpty());
}

// One that hangs takes no more than lines that wait.
TEST_F(LiveSceneTest, ADeafLearnerDelaysNothing) {
  UseScript("sleep 600");
  const auto scene = Create();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 40; ++i) scene->Add(FrameAt(0.1 * i), {});
  for (int i = 0; i < 200; ++i) {
    scene->Follow(Straight(5, 0.1 * i), base_from_camera_);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
  EXPECT_EQ(scene->status().frames, 40);
}

TEST_F(LiveSceneTest, ALearnerThatNeverEndsIsGivenUp) {
  UseScript("cat >/dev/null; exec sleep 600");
  options_.patience = std::chrono::milliseconds(300);
  auto scene = Create();
  scene->Add(FrameAt(0.05), {});
  scene->End(Straight(1), base_from_camera_);
  scene->Finish(Straight(1), base_from_camera_, {});
  EXPECT_THAT(said_, HasSubstr("has not written the model with the map's"));
  EXPECT_THAT(said_, HasSubstr("the map is not concerned"));
}

TEST_F(LiveSceneTest, SaysWhatItNeeds) {
  UseScript("true");
  options_.folder = "my maps/learning";
  EXPECT_THAT(LiveScene::Create(options_).status().message(),
              HasSubstr("blanks"));
  options_.folder = "maps";
  options_.learner = folder_.Path("nowhere");
  EXPECT_TRUE(absl::IsNotFound(LiveScene::Create(options_).status()));
}

}  // namespace
}  // namespace treeline::map_app

#include "server/service/scene_maps.h"

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/keyframes/testing_keyframe_model.h"
#include "server/service/service_test_util.h"

namespace treeline::service {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr uint32_t kPointsOfKeyframe = 40;

// Cameras in a row that look along y, at a wall two metres away.
keyframes::Keyframes Wall(int cameras) {
  keyframes::Keyframes keyframes;
  for (int i = 0; i < cameras; ++i) {
    keyframes::KeyframeRecord record;
    // Camera axes: x right, y down, z along the world's y.
    record.rotation = {std::sqrt(0.5), -std::sqrt(0.5), 0, 0};
    record.position_in_world = {0.5 * i, 0, 1.5};
    record.first_point = static_cast<uint32_t>(keyframes.points.size());
    record.points = kPointsOfKeyframe;
    for (uint32_t k = 0; k < kPointsOfKeyframe; ++k) {
      keyframes::KeyframePoint point;
      point.position_in_world = {
          static_cast<float>(0.5 * i - 0.7 + 0.2 * (k % 8)), 2,
          static_cast<float>(1.1 + 0.2 * (k / 8))};
      point.normal_in_world = {0, -127, 0};
      point.gray = {static_cast<uint8_t>(k), 0, 0, 0};
      keyframes.points.push_back(point);
    }
    keyframes.records.push_back(record);
  }
  return keyframes;
}

class MapLocalizer final : public localizer::Localizer {
 public:
  explicit MapLocalizer(int cameras) {
    info_.calibration = TestCalibration();
    if (cameras == 0) return;
    model_ = keyframes::ModelWithKeyframes(Wall(cameras)).value();
    map_ = keyframes::KeyframeMap::Read(*model_).value();
  }
  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame&, const localizer::LocalizeOptions&) const override {
    return localizer::PoseEstimate();
  }
  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }
  const keyframes::KeyframeMap* keyframes() const override { return &map_; }

 private:
  forest::ModelInfo info_;
  std::unique_ptr<const forest::ModelFile> model_;
  keyframes::KeyframeMap map_;
};

repository::Scene SceneOf(int cameras) {
  return {.name = "hall",
          .version = "3",
          .localizer = std::make_shared<const MapLocalizer>(cameras)};
}

class SceneMapsTest : public ::testing::Test {
 protected:
  absl::StatusOr<v1::GetSceneMapResponse> Start(
      const v1::GetSceneMapRequest& request) {
    absl::Notification done;
    absl::StatusOr<v1::GetSceneMapResponse> answer =
        absl::UnknownError("not yet");
    maps_.Start({.request = request,
                 .client = "tester",
                 .stop = {},
                 .done = [&](absl::StatusOr<v1::GetSceneMapResponse> response) {
                   answer = std::move(response);
                   done.Notify();
                 }});
    done.WaitForNotification();
    return answer;
  }

  base::SteadyClock clock_;
  FakeScenes scenes_{{{"plain", nullptr}}};
  WorkerPool workers_{1, 4, clock_};
  WaitingRoom waiting_{2};
  SceneMaps maps_{scenes_.repository(), workers_, waiting_, clock_};
};

// A scene "hall", which is loaded when it is asked for.
class HallRepository {
 public:
  using Opener = std::function<std::unique_ptr<localizer::Localizer>()>;

  explicit HallRepository(const Opener& open)
      : root_(testing::TempDir() + "/hall-" + std::to_string(getpid())) {
    std::filesystem::create_directories(root_ + "/hall/1");
    std::ofstream(root_ + "/hall/1/model.treeline") << "hall";
    repository_ =
        repository::SceneRepository::Open(
            std::make_unique<repository::FolderSource>(root_),
            [open](const std::string&)
                -> absl::StatusOr<std::unique_ptr<localizer::Localizer>> {
              return open();
            },
            {}, clock_)
            .value();
  }
  ~HallRepository() { std::filesystem::remove_all(root_); }
  repository::SceneRepository& operator*() const { return *repository_; }

 private:
  base::SteadyClock clock_;
  const std::string root_;
  std::unique_ptr<repository::SceneRepository> repository_;
};

class ThrowingLocalizer final : public localizer::Localizer {
 public:
  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame&, const localizer::LocalizeOptions&) const override {
    return localizer::PoseEstimate();
  }
  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }
  const keyframes::KeyframeMap* keyframes() const override {
    throw std::runtime_error("secret of the house");
  }

 private:
  forest::ModelInfo info_;
};

TEST_F(SceneMapsTest, HasPointsAndKeyframes) {
  const auto map = maps_.Make({}, SceneOf(3));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->scene(), "hall");
  EXPECT_EQ(map->model_version(), "3");
  EXPECT_EQ(map->points_in_model(), 3 * kPointsOfKeyframe);
  EXPECT_EQ(map->points_in_world_m().size(), 3u * kPointsOfKeyframe * 12);
  EXPECT_EQ(map->brightness().size(), 3u * kPointsOfKeyframe);
  float first[3];
  std::memcpy(first, map->points_in_world_m().data(), sizeof(first));
  EXPECT_THAT(first, testing::ElementsAre(-0.7F, 2, 1.1F));
  EXPECT_EQ(map->brightness()[7], 7);
  ASSERT_EQ(map->world_from_keyframe_size(), 3);
  EXPECT_EQ(map->world_from_keyframe(2).translation_m().x(), 1);
  EXPECT_EQ(map->camera().width_px(), kTestWidth);
  EXPECT_FALSE(map->has_coverage());
  // z is up already.
  EXPECT_NEAR(map->plan_from_world().w(), 1, 1e-9);
}

TEST_F(SceneMapsTest, TakesPointsEvenly) {
  v1::GetSceneMapRequest request;
  request.set_max_points(30);
  const auto map = maps_.Make(request, SceneOf(3));
  ASSERT_TRUE(map.ok()) << map.status();
  // Every fourth of 120, across the keyframes.
  ASSERT_EQ(map->brightness().size(), 30u);
  for (size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(map->brightness()[i],
              static_cast<char>(4 * i % kPointsOfKeyframe));
  }
}

TEST_F(SceneMapsTest, HasCoverageWhereItIsAskedFor) {
  v1::GetSceneMapRequest request;
  request.set_include_coverage(true);
  const repository::Scene scene = SceneOf(3);
  const auto map = maps_.Make(request, scene);
  ASSERT_TRUE(map.ok()) << map.status();
  const v1::SceneCoverage& coverage = map->coverage();
  const auto places = static_cast<size_t>(coverage.columns() * coverage.rows());
  EXPECT_GT(places, 0u);
  EXPECT_EQ(coverage.is_open().size(), places);
  EXPECT_EQ(coverage.good_headings().size(), places);
  EXPECT_EQ(coverage.weak_headings().size(), places);
  EXPECT_GT(coverage.open_m2(), 0);
  EXPECT_GT(coverage.good_share() + coverage.weak_share(), 0);
  // The same again, and of another version anew.
  EXPECT_EQ(maps_.Make(request, scene)->coverage().SerializeAsString(),
            coverage.SerializeAsString());
  EXPECT_NE(maps_.Make(request, SceneOf(6))->coverage().columns(),
            coverage.columns());
}

TEST_F(SceneMapsTest, SaysWhereThereAreNoKeyframes) {
  const absl::Status without = maps_.Make({}, SceneOf(0)).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(without));
  EXPECT_EQ(base::ErrorInfoOf(without).reason, "NO_KEYFRAMES");
}

TEST_F(SceneMapsTest, ChecksWhatIsAsked) {
  v1::GetSceneMapRequest request;
  request.set_scene("plain");
  EXPECT_EQ(base::ErrorInfoOf(Start(request).status()).reason, "NO_KEYFRAMES");
  request.set_max_points(200001);
  EXPECT_THAT(std::string(Start(request).status().message()),
              HasSubstr("max_points: 200001"));
  request.set_max_points(-1);
  EXPECT_TRUE(absl::IsInvalidArgument(Start(request).status()));
  request.set_max_points(0);
  request.set_scene("none");
  EXPECT_TRUE(absl::IsNotFound(Start(request).status()));
}

// Each waits in memory for a scene whose loading may take minutes.
TEST_F(SceneMapsTest, OnlySoManyWaitForAScene) {
  absl::Notification load;
  const HallRepository hall([&] {
    load.WaitForNotification();
    return std::make_unique<MapLocalizer>(3);
  });
  SceneMaps maps(*hall, workers_, waiting_, clock_);
  v1::GetSceneMapRequest request;
  request.set_scene("hall");
  absl::Mutex mutex;
  std::vector<absl::Status> answers;
  const auto add = [&](const absl::StatusOr<v1::GetSceneMapResponse>& answer) {
    const absl::MutexLock lock(&mutex);
    answers.push_back(answer.status());
  };
  for (int i = 0; i < 3; ++i)
    maps.Start(
        {.request = request, .client = "tester", .stop = {}, .done = add});
  {
    const absl::MutexLock lock(&mutex);
    ASSERT_EQ(answers.size(), 1u);
    EXPECT_EQ(base::ErrorInfoOf(answers[0]).reason, "QUEUE_FULL");
    EXPECT_TRUE(IsShed(answers[0]));
  }
  load.Notify();
  const absl::MutexLock lock(&mutex);
  mutex.Await(absl::Condition(
      +[](std::vector<absl::Status>* all) { return all->size() == 3; },
      &answers));
  EXPECT_TRUE(answers[1].ok()) << answers[1];
  EXPECT_TRUE(answers[2].ok()) << answers[2];
  EXPECT_EQ(waiting_.waiting(), 0);
}

TEST_F(SceneMapsTest, WhatIsThrownIsForTheLogAlone) {
  const HallRepository hall(
      [] { return std::make_unique<ThrowingLocalizer>(); });
  SceneMaps maps(*hall, workers_, waiting_, clock_);
  SceneMaps::Call call;
  call.request.set_scene("hall");
  std::string fault;
  call.on_fault = [&](const char* what) { fault = what; };
  absl::Status answer;
  absl::Notification done;
  call.done = [&](const absl::StatusOr<v1::GetSceneMapResponse>& response) {
    answer = response.status();
    done.Notify();
  };
  maps.Start(std::move(call));
  done.WaitForNotification();
  EXPECT_TRUE(absl::IsInternal(answer));
  EXPECT_THAT(std::string(answer.message()), Not(HasSubstr("secret")));
  EXPECT_EQ(fault, "secret of the house");
}

}  // namespace
}  // namespace treeline::service

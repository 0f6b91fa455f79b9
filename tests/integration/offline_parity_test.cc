// The server's answer is the localizer's, bit for bit.
#include <string>
#include <thread>
#include <vector>

#include "client/relocalizer/grpc_relocalizer.h"
#include "gmock/gmock.h"
#include "server/core/localizer/localizer.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

constexpr int kFrames = 6;

class OfflineParity : public ServerTest {
 protected:
  OfflineParity() : frames_(HeldOutFrames()) {}

  void SetUp() override {
    ServerTest::SetUp();
    PutRoom();
    StartServer({"--drain-s", "0", "--workers", "3"});
    auto localizer = localizer::OpenLocalizer(RoomModelPath());
    ASSERT_TRUE(localizer.ok()) << localizer.status();
    localizer_ = *std::move(localizer);
  }

  localizer::PoseEstimate Offline(int i, uint64_t seed) const {
    localizer::LocalizeOptions options;
    options.seed = seed;
    return localizer_->Localize(frames_.Load(i).value(), options).value();
  }

  static void ExpectSame(const relocalizer::LocalizeAnswer& served,
                         const localizer::PoseEstimate& offline) {
    EXPECT_EQ(served.localized,
              offline.outcome == localizer::Outcome::kLocalized);
    EXPECT_EQ(served.inliers, offline.inliers);
    EXPECT_EQ(served.samples, offline.samples);
    EXPECT_EQ(served.inlier_ratio, offline.inlier_ratio);
    if (!served.localized) return;
    EXPECT_EQ(served.world_from_camera, offline.world_from_camera);
    EXPECT_EQ(served.covariance, offline.covariance);
  }

  const dataset::Dataset frames_;
  std::unique_ptr<localizer::Localizer> localizer_;
};

TEST_F(OfflineParity, EncodedFrames) {
  int localized = 0;
  for (const uint64_t seed : {0u, 7u}) {
    for (int i = 0; i < kFrames; ++i) {
      SCOPED_TRACE(frames_.frame(i).stem);
      const auto served = client_->Localize(QueryOf(frames_, i, seed), {});
      ASSERT_TRUE(served.ok()) << served.status();
      ExpectSame(*served, Offline(i, seed));
      localized += served->localized;
    }
  }
  // Else there were no poses to compare.
  EXPECT_GT(localized, kFrames);
}

// Else the test above could not tell whether the seed arrives.
TEST_F(OfflineParity, OtherSeedsGiveOtherPoses) {
  EXPECT_NE(Offline(0, 0).world_from_camera, Offline(0, 7).world_from_camera);
}

TEST_F(OfflineParity, RawFrames) {
  for (int i = 0; i < kFrames; ++i) {
    SCOPED_TRACE(frames_.frame(i).stem);
    const image::Frame frame = frames_.Load(i).value();
    relocalizer::LocalizeQuery query{.scene = "room"};
    query.frame.color = frame.color;
    const image::DepthImage& depth = frame.depth.value();
    query.frame.depth =
        wire::QueryDepth{.image = depth, .unit_m = depth.unit_m};
    const auto served = client_->Localize(query, {});
    ASSERT_TRUE(served.ok()) << served.status();
    ExpectSame(*served, Offline(i, 0));
  }
}

// The scene's own calibration, stated by the client, changes nothing.
TEST_F(OfflineParity, FramesWithTheirCalibration) {
  const camera::RgbdCalibration& calibration = localizer_->info().calibration;
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  query.frame.camera = calibration.color;
  query.frame.depth->registration = wire::DepthRegistration::kExplicit;
  query.frame.depth->geometry = {calibration.depth,
                                 calibration.color_from_depth};
  query.frame.depth->depth_scale = calibration.depth_scale;
  const auto served = client_->Localize(query, {});
  ASSERT_TRUE(served.ok()) << served.status();
  ExpectSame(*served, Offline(0, 0));
  EXPECT_EQ(served->pose_sensor, calibration.pose_sensor);
}

TEST_F(OfflineParity, ManyClientsAtOnce) {
  std::vector<localizer::PoseEstimate> offline;
  for (int i = 0; i < kFrames; ++i) offline.push_back(Offline(i, 0));
  std::vector<std::thread> clients;
  for (int c = 0; c < 4; ++c) {
    clients.emplace_back([&, c] {
      const auto client =
          relocalizer::ConnectRelocalizer({.server = address_}).value();
      for (int k = 0; k < 2 * kFrames; ++k) {
        const int i = (k + c) % kFrames;
        const auto served = client->Localize(QueryOf(frames_, i), {});
        ASSERT_TRUE(served.ok()) << served.status();
        ExpectSame(*served, offline[static_cast<size_t>(i)]);
      }
    });
  }
  for (std::thread& client : clients) client.join();
}

TEST_F(OfflineParity, TheModelDescribesItselfTheSame) {
  const auto scene = client_->GetScene("room", {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->state, "READY");
  ASSERT_TRUE(scene->model.has_value());
  const forest::ModelInfo& info = localizer_->info();
  EXPECT_EQ(scene->model->method, "rgbd");
  EXPECT_EQ(scene->model->checksum, info.checksum);
  EXPECT_EQ(scene->model->calibration, info.calibration);
  EXPECT_EQ(scene->model->bounds_min_in_world, info.bounds_min_in_world);
  EXPECT_EQ(scene->model->bounds_max_in_world, info.bounds_max_in_world);
  EXPECT_EQ(scene->model->trees, info.trees);
  EXPECT_EQ(scene->model->leaves, info.leaves);
  EXPECT_EQ(scene->model->file_bytes, info.file_bytes);
}

}  // namespace
}  // namespace treeline

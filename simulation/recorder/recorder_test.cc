#include "simulation/recorder/recorder.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <map>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/dataset/dataset.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/recorder/tour_walk.h"
#include "simulation/recorder/walk.h"
#include "simulation/sensors/picture.h"
#include "simulation/worlds/testing_world.h"

namespace treeline::recorder {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class RecorderTest : public ::testing::Test {
 protected:
  RecorderTest()
      : folder_(fs::temp_directory_path() /
                absl::StrCat("treeline-recorder-", getpid(), "-",
                             ::testing::UnitTest::GetInstance()
                                 ->current_test_info()
                                 ->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~RecorderTest() override { fs::remove_all(folder_); }

  RecordOptions Options(const char* name) const {
    RecordOptions options;
    options.folder = (folder_ / name).string();
    options.frames = 5;
    return options;
  }

  std::map<std::string, std::string> Contents(const char* name) const {
    std::map<std::string, std::string> contents;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / name)) {
      if (!entry.is_regular_file()) continue;
      contents[fs::relative(entry.path(), folder_ / name).string()] =
          *base::ReadFile(entry.path().string());
    }
    return contents;
  }

  const fs::path folder_;
};

TEST_F(RecorderTest, SameSeedSameBytesOnOneAndTwoThreads) {
  RecordOptions options = Options("one");
  options.threads = 1;
  std::atomic<int> done = 0;
  ASSERT_EQ(RecordWorld(options, [&] { ++done; }, {}), absl::OkStatus());
  EXPECT_EQ(done, 5);
  options.folder = Options("two").folder;
  options.threads = 2;
  ASSERT_EQ(RecordWorld(options, {}, {}), absl::OkStatus());

  const auto one = Contents("one");
  EXPECT_EQ(one.size(), 3u * 5 + 3);
  EXPECT_EQ(one, Contents("two"));
  EXPECT_THAT(one.at("recording.txt"), HasSubstr("world room\n"));
  EXPECT_THAT(one.at("recording.txt"),
              HasSubstr("color_from_depth 1 0 0 0 -0.025 0 0\n"));
  EXPECT_EQ(one.at("train.txt"),
            "seq-01/frame-000000\nseq-01/frame-000001\nseq-01/frame-000002\n");
  EXPECT_EQ(one.at("test.txt"), "seq-01/frame-000004\n");
}

TEST_F(RecorderTest, StoppingLeavesNothing) {
  std::stop_source source;
  // After the first frame.
  EXPECT_EQ(RecordIn(
                worlds::TestingWorld(), Options("stopped"),
                [&] { source.request_stop(); }, source.get_token())
                .code(),
            absl::StatusCode::kCancelled);
  EXPECT_TRUE(Contents("stopped").empty());
  EXPECT_FALSE(fs::exists(folder_ / "stopped" / "seq-01"));
}

TEST_F(RecorderTest, DoesNotRecordOverARecording) {
  ASSERT_EQ(RecordIn(worlds::TestingWorld(), Options("once"), {}, {}),
            absl::OkStatus());
  const auto before = Contents("once");
  EXPECT_EQ(RecordIn(worlds::TestingWorld(), Options("once"), {}, {}).code(),
            absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(Contents("once"), before);
}

TEST_F(RecorderTest, AFolderThatCannotBeMadeIsNamed) {
  ASSERT_EQ(base::WriteFileAtomically((folder_ / "file").string(), "x"),
            absl::OkStatus());
  const absl::Status status =
      RecordIn(worlds::TestingWorld(), Options("file/below"), {}, {});
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(), HasSubstr("file/below"));
}

// TestingWorld with a box that goes to and fro.
worlds::World MovingWorld() {
  worlds::World world = worlds::TestingWorld();
  worlds::WorldBuilder builder;
  builder.BeginBody();
  const worlds::Finish grey = {
      .texture = builder.AddTexture([] { return worlds::Canvas(8, 8); })};
  builder.AddBox({}, {-0.2f, -0.2f, 0}, {0.2f, 0.2f, 1.5f}, {.sides = grey});
  builder.EndBody(
      "cart", 0.3f, 1.5f,
      worlds::Motion{
          .keys = {{.time_s = 0, .world_from_body = {{3.4f, 0.5f, 0}, 0}},
                   {.time_s = 1, .world_from_body = {{3.4f, 2.5f, 0}, 1}}},
          .period_s = 2});
  world.bodies = builder.Build("", {}, {}, 1).bodies;
  return world;
}

TEST_F(RecorderTest, EverythingAtOnceIsTheSameOnOneAndTwoThreads) {
  for (const RecordFormat format :
       {RecordFormat::kSevenScenes, RecordFormat::kTum}) {
    const bool is_tum = format == RecordFormat::kTum;
    RecordOptions options = Options(is_tum ? "tum-one" : "one");
    options.format = format;
    options.is_exposure_automatic = true;
    options.shutter_s = 0.02;
    options.lowest_jpeg_quality = 30;
    options.has_truth = true;
    options.threads = 1;
    ASSERT_EQ(RecordIn(MovingWorld(), options, {}, {}), absl::OkStatus());
    options.folder = Options(is_tum ? "tum-two" : "two").folder;
    options.threads = 2;
    ASSERT_EQ(RecordIn(MovingWorld(), options, {}, {}), absl::OkStatus());
    const auto one = Contents(is_tum ? "tum-one" : "one");
    EXPECT_EQ(one, Contents(is_tum ? "tum-two" : "two"));
    EXPECT_EQ(one.count("truth/000004.normal.png"), 1u);
    EXPECT_EQ(one.size(), is_tum ? 5u * 5 + 6 : 6u * 5 + 3);
  }
}

TEST_F(RecorderTest, TumIsReadBackAsItWasSeen) {
  RecordOptions options = Options("tum");
  options.format = RecordFormat::kTum;
  options.rate_hz = 10;
  ASSERT_EQ(RecordIn(worlds::TestingWorld(), options, {}, {}),
            absl::OkStatus());
  const absl::StatusOr<dataset::Dataset> dataset =
      dataset::Dataset::Open({.uri = "tum:" + options.folder});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 5);
  EXPECT_TRUE(dataset->depth_is_registered());
  EXPECT_EQ(dataset->frame(3).stem, "0.300000");

  const auto renderer =
      *renderer::Renderer::CreateUnlit(worlds::TestingWorld());
  const renderer::PixelRays rays(dataset->calibration().color);
  const CameraPath path =
      *MakeCameraPath(renderer->world(), renderer->caster(), options.seed);
  for (int i = 0; i < 5; ++i) {
    const geometry::Rigid3 pose = *dataset->frame(i).world_from_camera;
    const geometry::PoseError error =
        geometry::ErrorBetween(pose, path(0.1 * i));
    EXPECT_LT(error.translation_m, 1e-8);
    EXPECT_LT(error.rotation_rad, 1e-8);
    // Depth, against the truth at the pose that was read: where both are, a
    // median pixel is within the noise (4 mm at 1.5 m; a step is 4 mm there).
    const image::Frame frame = *dataset->Load(i);
    const auto truth = renderer->RenderDepth(rays, pose, 1);
    std::vector<double> errors_m;
    for (size_t k = 0; k < truth.size(); ++k) {
      if (!image::IsMeasured(frame.depth->values[k])) continue;
      errors_m.push_back(std::abs(frame.depth->values[k] * frame.depth->unit_m -
                                  truth[k].depth_m));
    }
    ASSERT_GT(errors_m.size(), truth.size() / 2);
    std::nth_element(
        errors_m.begin(),
        errors_m.begin() + static_cast<ptrdiff_t>(errors_m.size() / 2),
        errors_m.end());
    EXPECT_LT(errors_m[errors_m.size() / 2], 0.008);
  }
  EXPECT_EQ(
      dataset::Dataset::Open({.uri = "tum:" + options.folder,
                              .frame_list = options.folder + "/train.txt"})
          ->size(),
      3);
}

TEST_F(RecorderTest, SevenScenesIsReadBackWithItsPoses) {
  const RecordOptions options = Options("seven");
  ASSERT_EQ(RecordIn(worlds::TestingWorld(), options, {}, {}),
            absl::OkStatus());
  const absl::StatusOr<dataset::Dataset> dataset =
      dataset::Dataset::Open({.uri = "7scenes:" + options.folder});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const worlds::World world = worlds::TestingWorld();
  const Walk walk(world.walk_area, options.seed);
  for (int i = 0; i < 5; ++i) {
    const geometry::PoseError error = geometry::ErrorBetween(
        *dataset->frame(i).world_from_camera, walk.WorldFromCameraAt(i / 30.0));
    EXPECT_LT(error.translation_m, 1e-9);
    EXPECT_LT(error.rotation_rad, 1e-6);
    EXPECT_EQ(dataset->Load(i)->depth->unit_m, 0.001);
  }
}

TEST_F(RecorderTest, ATrajectoryIsFollowed) {
  const geometry::Rigid3 first = sensors::LookingFrom({2, 1.5, 1.3}, 0, 0);
  const geometry::Rigid3 last = sensors::LookingFrom({2.4, 1.5, 1.3}, 0, 0);
  RecordOptions options = Options("line");
  options.format = RecordFormat::kTum;
  options.trajectory = {{.time = 5'000'000'000, .world_from_camera = first},
                        {.time = 6'000'000'000, .world_from_camera = last}};
  ASSERT_EQ(RecordIn(worlds::TestingWorld(), options, {}, {}),
            absl::OkStatus());
  const auto two = *dataset::Dataset::Open({.uri = "tum:" + options.folder});
  ASSERT_EQ(two.size(), 2);
  EXPECT_EQ(two.frame(1).stem, "6.000000");
  EXPECT_LT(geometry::ErrorBetween(*two.frame(1).world_from_camera, last)
                .translation_m,
            1e-8);

  // Five in the second, with the ends.
  options.folder = Options("between").folder;
  options.is_resampled = true;
  options.frames = 5;
  options.rate_hz = 4;
  ASSERT_EQ(RecordIn(worlds::TestingWorld(), options, {}, {}),
            absl::OkStatus());
  const std::string poses =
      *base::ReadFile(options.folder + "/groundtruth.txt");
  EXPECT_THAT(poses, HasSubstr("\n5.250000 2.100000000 1.5"));
  EXPECT_THAT(poses, HasSubstr("\n6.000000 2.400000000 1.5"));

  options.frames = 7;
  EXPECT_THAT(RecordIn(worlds::TestingWorld(), options, {}, {}).message(),
              HasSubstr("longer than the trajectory"));
}

TEST_F(RecorderTest, OptionsAreChecked) {
  const auto error = [&](auto change) {
    RecordOptions options = Options("bad");
    change(options);
    const absl::Status status = RecordWorld(options, {}, {});
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_FALSE(fs::exists(folder_ / "bad" / "seq-01"));
    return std::string(status.message());
  };
  EXPECT_THAT(error([](auto& o) { o.frames = 4; }), HasSubstr("4 frames"));
  EXPECT_THAT(error([](auto& o) { o.folder = ""; }), HasSubstr("no folder"));
  EXPECT_THAT(error([](auto& o) { o.rate_hz = 0; }), HasSubstr("0 Hz"));
  EXPECT_THAT(error([](auto& o) { o.jpeg_quality = 0; }),
              HasSubstr("JPEG quality"));
  EXPECT_THAT(error([](auto& o) { o.lowest_jpeg_quality = 93; }),
              HasSubstr("lowest JPEG quality"));
  EXPECT_THAT(error([](auto& o) { o.shutter_s = -1; }), HasSubstr("shutter"));
  EXPECT_THAT(error([](auto& o) { o.readout_s = 0.3; }), HasSubstr("readout"));
  EXPECT_THAT(error([](auto& o) { o.shutter_s = o.readout_s = 0.02; }),
              HasSubstr("cannot be combined"));
  EXPECT_THAT(error([](auto& o) { o.world = "moon"; }), HasSubstr("'moon'"));
}

}  // namespace
}  // namespace treeline::recorder

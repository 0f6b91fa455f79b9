#include "evaluation/accuracy/foreign_images.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

EvaluationOptions Quiet() {
  EvaluationOptions options;
  options.quiet = true;
  return options;
}

forest::ModelInfo SmallModel() {
  forest::ModelInfo info;
  info.calibration.color =
      camera::Camera::Parse("PINHOLE,30,30,16,12", 32, 24).value();
  info.calibration.depth =
      camera::Camera::Parse("PINHOLE,15,15,8,6", 16, 12).value();
  return info;
}

TEST(ParseForeignSource, TakesBuiltinPicturesAndRecordings) {
  EXPECT_EQ(ParseForeignSource("builtin")->builtin_count,
            kBuiltinForeignImages);
  EXPECT_EQ(ParseForeignSource("builtin,7")->builtin_count, 7);
  const NegativeSource recording = *ParseForeignSource("tum:/a/b,/c/d.txt");
  EXPECT_FALSE(recording.builtin);
  EXPECT_EQ(recording.dataset.uri, "tum:/a/b");
  EXPECT_EQ(recording.dataset.frame_list, "/c/d.txt");
  EXPECT_EQ(ParseForeignSource("7scenes:/a")->dataset.frame_list, "");
  const NegativeSource colmap = *ParseForeignSource("colmap:/m,/i,/list");
  EXPECT_EQ(colmap.dataset.uri, "colmap:/m,/i");
  EXPECT_EQ(colmap.dataset.frame_list, "/list");
  const NegativeSource other = *ParseForeignSource(
      "tum:/a,/b.txt;color-camera=PINHOLE,450,450,270,180;depth-unit=0.001");
  EXPECT_EQ(other.dataset.uri, "tum:/a");
  EXPECT_EQ(other.dataset.frame_list, "/b.txt");
  EXPECT_EQ(other.dataset.color_camera, "PINHOLE,450,450,270,180");
  EXPECT_EQ(other.dataset.depth_unit_m, 0.001);
  for (const char* text :
       {"", "elsewhere", "builtin,0", "builtin,x", ":a", "tum:/a;x=1",
        "tum:/a;color-camera=", "tum:/a;depth-unit=x", "builtin;depth-unit=1",
        "builtin,3;depth-unit=1"}) {
    EXPECT_FALSE(ParseForeignSource(text).ok()) << text;
  }
}

TEST(BuiltinForeignFrame, IsAFunctionOfItsIndex) {
  const camera::RgbdCalibration calibration = SmallModel().calibration;
  std::set<std::vector<uint8_t>> different;
  for (int i = 0; i < 40; ++i) {
    const image::Frame frame = BuiltinForeignFrame(calibration, i);
    EXPECT_EQ(frame.color.width, 32);
    EXPECT_EQ(frame.color.rgb.size(), 3u * 32 * 24);
    ASSERT_TRUE(frame.depth.has_value());
    EXPECT_EQ(frame.depth->values.size(), 16u * 12);
    EXPECT_EQ(BuiltinForeignFrame(calibration, i).color.rgb, frame.color.rgb);
    EXPECT_EQ(BuiltinForeignFrame(calibration, i).depth->values,
              frame.depth->values);
    different.insert(frame.color.rgb);
  }
  // All but black and white ones differ.
  EXPECT_GE(different.size(), 36u);
}

TEST(BuiltinForeignFrame, HasBlackPicturesAndMissingDepth) {
  const camera::RgbdCalibration calibration = SmallModel().calibration;
  int black = 0;
  int without_depth = 0;
  for (int i = 0; i < kBuiltinForeignImages; ++i) {
    const image::Frame frame = BuiltinForeignFrame(calibration, i);
    black +=
        std::ranges::all_of(frame.color.rgb, [](uint8_t v) { return v == 0; });
    without_depth += std::ranges::none_of(
        frame.depth->values, [](uint16_t v) { return image::IsMeasured(v); });
  }
  EXPECT_GT(black, 0);
  EXPECT_GT(without_depth, 0);
}

TEST(AskForeign, CountsWhatBecameOfPicturesWithAndWithoutDepth) {
  // Refuses pictures without depth; accepts every other one of the others.
  const tools::SmallRecording recording(4, {});
  const tools::FunctionLocalizer localizer(
      SmallModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&)
          -> absl::StatusOr<localizer::PoseEstimate> {
        if (!frame.depth) return absl::InvalidArgumentError("no depth");
        localizer::PoseEstimate estimate;
        if (tools::FrameNumber(frame) % 2 == 1) {
          estimate = tools::LocalizedAt({});
          estimate.confidence = tools::FrameNumber(frame) == 1 ? 0.95 : 0.2;
        }
        return estimate;
      });
  NegativeSource source{.name = "elsewhere", .dataset = recording.options()};
  const auto tallies = AskForeign(localizer, {source}, 0.9, Quiet());
  ASSERT_TRUE(tallies.ok()) << tallies.status();
  ASSERT_EQ(tallies->size(), 2u);
  const NegativeTally& with = (*tallies)[0];
  EXPECT_TRUE(with.with_depth);
  EXPECT_EQ(with.images, 4);
  EXPECT_EQ(with.accepted, 2);
  EXPECT_EQ(with.confident, 1);
  EXPECT_EQ(with.not_localized, 2);
  EXPECT_THAT(with.accepted_names,
              ElementsAre("seq-01/frame-000001", "seq-01/frame-000003"));
  const NegativeTally& without = (*tallies)[1];
  EXPECT_FALSE(without.with_depth);
  EXPECT_EQ(without.images, 4);
  EXPECT_EQ(without.refused, 4);
  EXPECT_EQ(without.accepted, 0);
}

TEST(AskForeign, AsksWithTheRecordingsCamerasWhereSizesDiffer) {
  // The scene's pictures are 32 x 24, the recording's 8 x 6.
  const tools::SmallRecording recording(1, {});
  const tools::FunctionLocalizer localizer(
      SmallModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&) {
        EXPECT_TRUE(frame.calibration.has_value());
        EXPECT_EQ(frame.calibration->color.width(), 8);
        return localizer::PoseEstimate{};
      });
  EXPECT_TRUE(AskForeign(localizer,
                         {{.name = "r", .dataset = recording.options()}}, 0.9,
                         Quiet())
                  .ok());
}

TEST(AskForeign, CountsPicturesThatVanishAndGoesOn) {
  const tools::SmallRecording recording(3, {});
  const tools::FunctionLocalizer localizer(
      SmallModel(),
      [&](const image::Frame&, const localizer::LocalizeOptions&) {
        std::filesystem::remove(recording.ColorPath(2));
        return localizer::PoseEstimate{};
      });
  const auto tallies = AskForeign(
      localizer, {{.name = "r", .dataset = recording.options()}}, 0.9, Quiet());
  ASSERT_TRUE(tallies.ok()) << tallies.status();
  EXPECT_EQ((*tallies)[0].unreadable, 1);
  EXPECT_EQ((*tallies)[0].not_localized, 2);
  EXPECT_THAT((*tallies)[0].problems, ElementsAre(HasSubstr("frame-000002")));
}

TEST(AskForeign, StopsWhenInterrupted) {
  std::stop_source source;
  source.request_stop();
  EvaluationOptions options = Quiet();
  options.stop = source.get_token();
  const tools::FunctionLocalizer localizer(
      SmallModel(), [](const image::Frame&, const localizer::LocalizeOptions&) {
        return localizer::PoseEstimate{};
      });
  EXPECT_EQ(
      AskForeign(localizer, {*ParseForeignSource("builtin,3")}, 0.9, options)
          .status()
          .code(),
      absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline::accuracy

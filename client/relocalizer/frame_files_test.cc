#include "client/relocalizer/frame_files.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <variant>

#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::relocalizer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FrameFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("frames-" + std::to_string(getpid()) + "-" +
             testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  std::string Put(const std::string& name, const std::string& content) {
    const fs::path path = root_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path.string();
  }
  absl::StatusOr<std::vector<FrameFiles>> List(const std::string& text) {
    return ReadFrameList(Put("list.txt", text), root_.string());
  }

  fs::path root_;
};

TEST_F(FrameFilesTest, ListsFindTheirImages) {
  Put("seq-01/frame-000000.color.jpg", "x");
  Put("seq-01/frame-000000.depth.png", "x");
  Put("seq-01/frame-000001.color.png", "x");
  const auto list =
      List("# held out\nseq-01/frame-000000\r\n\n  seq-01/frame-000001  # b\n");
  ASSERT_TRUE(list.ok()) << list.status();
  ASSERT_EQ(list->size(), 2u);
  const std::string root = root_.string();
  EXPECT_EQ((*list)[0].stem, "seq-01/frame-000000");
  EXPECT_EQ((*list)[0].color, root + "/seq-01/frame-000000.color.jpg");
  EXPECT_EQ((*list)[0].depth, root + "/seq-01/frame-000000.depth.png");
  EXPECT_EQ((*list)[1].color, root + "/seq-01/frame-000001.color.png");
  EXPECT_EQ((*list)[1].depth, "");
}

TEST_F(FrameFilesTest, ListsNameTheFrameThatIsMissing) {
  Put("a.color.jpg", "x");
  const auto list = List("a\nb\n");
  EXPECT_EQ(list.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(list.status().message()), HasSubstr("b.color.jpg"));
}

TEST_F(FrameFilesTest, ListsWithoutFramesAreRefused) {
  EXPECT_EQ(List("# nothing\n\n").status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadFrameList((root_ / "none.txt").string(), "").status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(FrameFilesTest, ImagesAreSentAsTheyAre) {
  const FrameFiles files{
      .stem = "", .color = Put("c", "color"), .depth = Put("d", "depth")};
  const auto frame = ReadFrame(files, {.depth_unit_m = 0.0002});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(std::get<wire::EncodedImage>(frame->color).bytes, "color");
  EXPECT_EQ(std::get<wire::EncodedImage>(frame->depth->image).bytes, "depth");
  EXPECT_EQ(frame->depth->unit_m, 0.0002);
  EXPECT_EQ(frame->depth->registration,
            wire::DepthRegistration::kSceneCalibration);
  EXPECT_FALSE(frame->camera.has_value());
}

TEST_F(FrameFilesTest, RegisteredDepthIsStated) {
  const FrameFiles files{
      .stem = "", .color = Put("c", "color"), .depth = Put("d", "depth")};
  const auto frame = ReadFrame(files, {.depth_is_registered = true});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->depth->registration,
            wire::DepthRegistration::kRegisteredToColor);
}

TEST_F(FrameFilesTest, NoDepthFileNoDepth) {
  const auto frame =
      ReadFrame({.stem = "", .color = Put("c", "color"), .depth = ""}, {});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_FALSE(frame->depth.has_value());
}

TEST_F(FrameFilesTest, TheCameraTakesItsSizeFromTheImage) {
  const image::ColorImage image{
      .width = 24, .height = 16, .rgb = std::vector<uint8_t>(24 * 16 * 3)};
  const FrameFiles files{.stem = "",
                         .color = Put("c.png", image::EncodePng(image).value()),
                         .depth = ""};
  const auto frame = ReadFrame(files, {.camera = "SIMPLE_PINHOLE,20,12,8"});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->camera,
            *camera::Camera::Parse("SIMPLE_PINHOLE,20,12,8", 24, 16));
}

TEST_F(FrameFilesTest, ACameraThatIsNoneNamesTheOption) {
  const image::ColorImage image{
      .width = 24, .height = 16, .rgb = std::vector<uint8_t>(24 * 16 * 3)};
  const FrameFiles files{.stem = "",
                         .color = Put("c.png", image::EncodePng(image).value()),
                         .depth = ""};
  for (const char* camera : {"PINHOLE,20,12,8", "PINHOLE,nan,20,12,8", "x"}) {
    const auto frame = ReadFrame(files, {.camera = camera});
    EXPECT_EQ(frame.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(frame.status().message()), HasSubstr("--camera"));
  }
}

TEST_F(FrameFilesTest, MissingFilesAreNamed) {
  const std::string color = Put("c", "color");
  const auto no_color = ReadFrame({.stem = "", .color = "nowhere.jpg"}, {});
  EXPECT_EQ(no_color.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(no_color.status().message()),
              HasSubstr("nowhere.jpg"));
  const auto no_depth =
      ReadFrame({.stem = "", .color = color, .depth = "nowhere.png"}, {});
  EXPECT_THAT(std::string(no_depth.status().message()),
              HasSubstr("nowhere.png"));
}

}  // namespace
}  // namespace treeline::relocalizer

#include "server/tools/photographs/photographs.h"

#include <algorithm>
#include <filesystem>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/testing_captures.h"

namespace treeline::photographs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class PhotographsTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_.Path("out"));
  }

  void PutJpeg(const std::string& name, int width, int height) {
    image::ColorImage picture{width, height, {}};
    picture.rgb.assign(static_cast<size_t>(3 * width * height), 90);
    folder_.Write("photos/" + name, *image::EncodeJpeg(picture, 90));
  }
  absl::StatusOr<CopiedPictures> Copy(const std::string& source,
                                      const PictureOptions& options = {},
                                      const std::stop_token& stop = {}) {
    done_ = 0;
    return CopyPictures(
        folder_.Path(source), folder_.Path("out"), options, [this] { ++done_; },
        stop);
  }
  image::ImageSize SizeOf(const std::string& name) const {
    const auto bytes = base::ReadFile(folder_.Path("out/" + name));
    EXPECT_TRUE(bytes.ok()) << bytes.status();
    return image::ReadImageSize(*bytes).value_or(image::ImageSize{});
  }

  const base::TestingFolder folder_;
  int done_ = 0;
};

// A server would refuse it: image::DecodeLimits ends at 8192 pixels.
TEST_F(PhotographsTest, PicturesOfLargeSensorsAreMadeSmaller) {
  PutJpeg("panorama.jpg", 12000, 90);
  const auto copied = Copy("photos");
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_THAT(copied->left_out, SizeIs(0));
  EXPECT_EQ(SizeOf("panorama.jpg"), (image::ImageSize{1600, 12}));
}

TEST_F(PhotographsTest, AFolderOfPicturesIsKnown) {
  PutJpeg("a.jpg", 8, 6);
  PutJpeg("b.JPG", 8, 6);
  EXPECT_FALSE(IsPhotographs(folder_.Path("photos"))) << "two are too few";
  PutJpeg("c.jpeg", 8, 6);
  EXPECT_TRUE(IsPhotographs(folder_.Path("photos")));
  EXPECT_FALSE(IsPhotographs(folder_.Path("nowhere")));
  folder_.Write("walk.MP4", "x");
  EXPECT_TRUE(IsVideo(folder_.Path("walk.MP4")));
  EXPECT_FALSE(IsVideo(folder_.Path("photos")));
  EXPECT_FALSE(IsVideo(folder_.Path("missing.mp4")));
}

TEST_F(PhotographsTest, LargePicturesBecomeSmallerInTheirOrder) {
  PutJpeg("img_10.jpg", 200, 100);
  PutJpeg("img_9.jpg", 200, 100);
  PutJpeg("img_11.png", 200, 100);
  const auto copied = Copy("photos", {.max_side_px = 64});
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_THAT(copied->names,
              ElementsAre("img_9.jpg", "img_10.jpg", "img_11.jpg"));
  EXPECT_TRUE(copied->is_one_size);
  EXPECT_EQ(SizeOf("img_11.jpg"), (image::ImageSize{64, 32}));
  EXPECT_EQ(done_, 3);
}

TEST_F(PhotographsTest, ABrokenPictureIsLeftOutAndNamed) {
  PutJpeg("a.jpg", 20, 10);
  PutJpeg("b.jpg", 10, 20);
  folder_.Write("photos/c.jpg", "no picture");
  const auto copied = Copy("photos");
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_THAT(copied->names, SizeIs(2));
  EXPECT_FALSE(copied->is_one_size);
  EXPECT_THAT(copied->left_out, ElementsAre(HasSubstr("photos/c.jpg")));
}

// A phone that was held upright stores its photographs on their side, too.
TEST_F(PhotographsTest, PhotographsAreTurnedAsTheirExifSays) {
  image::ColorImage stored{64, 48, {}};
  stored.rgb.assign(size_t{3} * 64 * 48, 20);
  for (size_t y = 0; y < 16; ++y) {
    std::fill_n(stored.rgb.begin() + static_cast<ptrdiff_t>(3 * 64 * y), 48,
                uint8_t{230});
  }
  std::string jpeg = *image::EncodeJpeg(stored, 90);
  // The tag Orientation, 6: a quarter turn clockwise makes it upright.
  jpeg.insert(2, std::string("\xff\xe1\0\x22"
                             "Exif\0\0"
                             "MM\0\x2a\0\0\0\x08"
                             "\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0"
                             "\0\0\0\0",
                             36));
  folder_.Write("photos/a.jpg", jpeg);
  ASSERT_TRUE(Copy("photos").ok());
  const image::ColorImage shown =
      *image::DecodeColor(*base::ReadFile(folder_.Path("out/a.jpg")));
  ASSERT_EQ(shown.width, 48);
  ASSERT_EQ(shown.height, 64);
  EXPECT_LT(shown.rgb[size_t{3} * (48 * 6 + 6)], 80) << "top left";
  EXPECT_GT(shown.rgb[size_t{3} * (48 * 6 + 42)], 180) << "top right";
}

// An iPhone leaves both kinds in one folder.
TEST_F(PhotographsTest, HeicPicturesAreReadWhereTheirProgramIs) {
  PutJpeg("a.jpg", 20, 10);
  PutJpeg("b.HEIC", 20, 10);
  folder_.Write("photos/c.HEIC", "broken");
  EXPECT_TRUE(IsPhotographs(folder_.Path("photos")));
  // A program in its place, to which these are pictures.
  const std::string program = folder_.Write(
      "heif-convert", "#!/bin/sh\ngrep -q broken \"$1\" || cp \"$1\" \"$2\"\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const auto copied = Copy("photos", {.heif_convert = program});
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_THAT(copied->names, ElementsAre("a.jpg", "b.jpg"));
  EXPECT_THAT(copied->left_out, ElementsAre(HasSubstr("c.HEIC")));
  EXPECT_EQ(done_, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out-heic")));
}

TEST_F(PhotographsTest, WithoutTheirProgramHeicPicturesAreLeftOutWithWhatToDo) {
  PutJpeg("a.jpg", 20, 10);
  PutJpeg("b.HEIC", 20, 10);
  PutJpeg("c.HEIC", 20, 10);
  const auto copied = Copy("photos", {.heif_convert = "no-such-program"});
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_THAT(copied->names, ElementsAre("a.jpg"));
  EXPECT_THAT(copied->left_out,
              ElementsAre(testing::AllOf(HasSubstr("2 pictures are HEIC"),
                                         HasSubstr("libheif-examples"))));
  EXPECT_EQ(done_, 3);
}

TEST_F(PhotographsTest, FramesOfAVideoAreTakenEvenly) {
  capture::WriteStrayVideo(capture::MakeTrueScene(10), folder_.Path("stray"));
  const auto copied = Copy("stray/rgb.mp4", {.every = 4});
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_THAT(copied->names, ElementsAre("frame-000000.jpg", "frame-000004.jpg",
                                         "frame-000008.jpg"));
  EXPECT_EQ(CountPictures(folder_.Path("stray/rgb.mp4"), {.every = 5}).value(),
            2);
  EXPECT_FALSE(Copy("stray/odometry.csv").ok() && done_ > 0);
}

// A phone that was held upright stores its pictures on their side.
TEST_F(PhotographsTest, FramesOfAVideoAreTurnedAsPlayersShowThem) {
  // White in the top left corner of what is stored.
  image::ColorImage stored{64, 48, {}};
  stored.rgb.assign(size_t{3} * 64 * 48, 20);
  for (size_t y = 0; y < 16; ++y) {
    std::fill_n(stored.rgb.begin() + static_cast<ptrdiff_t>(3 * 64 * y), 48,
                uint8_t{230});
  }
  for (const image::QuarterTurn turn : image::kQuarterTurns) {
    const std::string name =
        absl::StrCat("turn-", static_cast<int>(turn), ".mp4");
    capture::WriteVideo({stored}, turn, folder_.Path(name));
    std::filesystem::remove(folder_.Path("out/frame-000000.jpg"));
    ASSERT_TRUE(Copy(name).ok());
    const image::ColorImage shown = *image::DecodeColor(
        *base::ReadFile(folder_.Path("out/frame-000000.jpg")));
    const bool is_on_side = turn == image::QuarterTurn::kClockwise ||
                            turn == image::QuarterTurn::kCounterclockwise;
    EXPECT_EQ(shown.width, is_on_side ? 48 : 64);
    const camera::Pixel white =
        image::Turned(camera::Pixel{6, 6}, 64, 48, turn);
    const auto value = [&](double x, double y) {
      return static_cast<int>(
          shown.rgb[3 *
                    (static_cast<size_t>(y) * static_cast<size_t>(shown.width) +
                     static_cast<size_t>(x))]);
    };
    EXPECT_GT(value(white.x, white.y), 180) << name;
    EXPECT_LT(value(shown.width - 1 - white.x, shown.height - 1 - white.y), 80)
        << name;
  }
}

TEST_F(PhotographsTest, StoppingStops) {
  PutJpeg("a.jpg", 20, 10);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(Copy("photos", {}, stop.get_token()).status()));
}

}  // namespace
}  // namespace treeline::photographs

#include "server/tools/photographs/heic.h"

#include <sys/stat.h>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/child_process.h"
#include "common/base/testing_folder.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::photographs {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// 160 x 120, black, white in the top left 60 x 40; then what a phone says of a
// picture that was held upright: turned clockwise, and EXIF's way up beside it.
// Made by libheif 1.15.
constexpr const char* kPhone =
    "AAAAHGZ0eXBoZWljAAAAAG1pZjFoZWljbWlhZgAAAY1tZXRhAAAAAAAAACFoZGxyAAAAAAAA"
    "AABwaWN0AAAAAAAAAAAAAAAAAAAAAA5waXRtAAAAAAABAAAANGlsb2MAAAAAREAAAgABAAAA"
    "AAGxAAEAAAAAAAABeAACAAAAAAMpAAEAAAAAAAAAJAAAADhpaW5mAAAAAAACAAAAFWluZmUC"
    "AAAAAAEAAGh2YzEAAAAAFWluZmUCAAABAAIAAEV4aWYAAAAAzGlwcnAAAACtaXBjbwAAAHho"
    "dmNDAQNwAAAAAAAAAAAAHvAA/P34+AAADwMgAAEAGEABDAH//wNwAAADAJAAAAMAAAMAHroC"
    "QCEAAQArQgEBA3AAAAMAkAAAAwAAAwAeoBQgeWW6kkprm4EBAwIAAAMAAgAAAwACECIAAQAH"
    "RAHBcrBiQAAAAAlpcm90AwAAABRpc3BlAAAAAAAAAHgAAACgAAAAEHBpeGkAAAAAAwgICAAA"
    "ABdpcG1hAAAAAAAAAAEAAQSBAgOEAAAAGmlyZWYAAAAAAAAADmNkc2MAAgABAAEAAAGkbWRh"
    "dAAAAXQoAa8GNCahW4jl4r/wcxRd1YwkIcH0Enxd/raBrHfeC/Tl3LSXYv88b/IU/tKH7Q7Z"
    "/xQH/H0f9w+/5mLlMbxI5dv12w13wRaY+toXON9c9zs9YHvAs2SWS9HKdRmjjle9xZPk6AJN"
    "p/03eEUi6/8viuvhYjGc7m/1x9bts8dAaM/8R3aTdTuN/g3MWnbOwd8+L60G/JGNcFHMZvnM"
    "kb8Sc+SrsDDDgwzCYT+N6N0Q1BTxiXjoDPaQFckbVcE5+oC8TnTzWERC9QrDPHZWwFXD34R4"
    "VKRvxIYYWNNFriupUQyf/r/1v2foeL4v/SI1Zt6TjVcE3SIcZzJG/Efzn1B+R/HnLt+mBYH8"
    "D2gi0P/o1GIjHdt4G/oiIPutvL8bTDyKzzECMJmvwFfcXVvvvr3RlkCZnISvMC2iHw9ogawb"
    "LEOj0Pl5P40BsKnpSDuWs9qrqI3lTBgaEFOBAA+m+TYBVAAHoAAAAwAAAwAAAwAAAwAADmgA"
    "AAAGRXhpZgAATU0AKgAAAAgAAQESAAMAAAABAAYAAAAAAAA=";

class HeicTest : public testing::Test {
 protected:
  // A program in heif-convert's place that runs this shell script.
  std::string Program(const std::string& script) const {
    const std::string program =
        folder_.Write("heif-convert", "#!/bin/sh\n" + script + "\n");
    chmod(program.c_str(), 0755);
    return program;
  }
  absl::StatusOr<image::ColorImage> Read(const std::string& program,
                                         std::stop_token stop = {}) const {
    return ReadHeic(folder_.Path("a.HEIC"), program, folder_.Path("work"),
                    stop);
  }

  const base::TestingFolder folder_;
};

TEST_F(HeicTest, NamesAreKnown) {
  EXPECT_TRUE(IsHeicName("IMG_0001.HEIC"));
  EXPECT_TRUE(IsHeicName("a.heif"));
  EXPECT_TRUE(IsHeicName("a.hif"));
  EXPECT_FALSE(IsHeicName("heic"));
  EXPECT_FALSE(IsHeicName("heic.jpg"));
}

// EXIF must not turn it again.
TEST_F(HeicTest, AnUprightPhonesPictureIsUpright) {
  const std::string program = base::FindProgram("heif-convert");
  if (program.empty()) GTEST_SKIP() << "no heif-convert: install-deps --tools";
  std::string bytes;
  ASSERT_TRUE(absl::Base64Unescape(kPhone, &bytes));
  folder_.Write("a.HEIC", bytes);
  const auto picture = Read(program);
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(picture->width, 120);
  EXPECT_EQ(picture->height, 160);
  EXPECT_LT(picture->rgb[0], 60) << "top left";
  EXPECT_GT(picture->rgb[3 * 119], 200) << "top right";
}

TEST_F(HeicTest, TheFirstOfSeveralPicturesIsTaken) {
  image::ColorImage picture{8, 6, {}};
  picture.rgb.assign(size_t{3} * 8 * 6, 90);
  const std::string png = folder_.Write("x.png", *image::EncodePng(picture));
  const auto read = Read(Program(absl::StrCat(
      "cp ", png, " ${2%.png}-1.png; cp ", png, " ${2%.png}-2.png")));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->width, 8);
}

TEST_F(HeicTest, AFileThatCannotBeReadIsNamedWithWhy) {
  for (const char* script :
       {"echo no such brand; exit 1", "echo no such brand"}) {
    const absl::Status status = Read(Program(script)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << script;
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr("a.HEIC"), HasSubstr("no such brand")));
  }
  EXPECT_THAT(
      std::string(Read(Program("echo no picture >\"$2\"")).status().message()),
      AllOf(HasSubstr("a.HEIC"), HasSubstr("neither JPEG nor PNG")));
}

// What an earlier file left must not be taken for this one.
TEST_F(HeicTest, NothingOfAnEarlierFileIsTaken) {
  folder_.Write("work/picture.png", "of another");
  EXPECT_THAT(std::string(Read(Program("exit 0")).status().message()),
              HasSubstr("cannot read it"));
}

TEST_F(HeicTest, StoppingStopsTheProgram) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(
      Read(Program("exec sleep 60"), stop.get_token()).status()));
}

}  // namespace
}  // namespace treeline::photographs

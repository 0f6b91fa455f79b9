#include "common/dataset/frame_times.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/testing_folder.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::ElementsAre;

class FrameTimesTest : public ::testing::Test {
 protected:
  // Of a recording with a camera for pictures of one pixel.
  std::vector<Time_ns> TimesOf(const std::string& format,
                               const std::string& frame_list = "") const {
    const auto dataset = Dataset::Open({.uri = absl::StrCat(format, Root()),
                                        .frame_list = frame_list,
                                        .color_camera = "PINHOLE,1,1,0,0"});
    EXPECT_TRUE(dataset.ok()) << dataset.status();
    return dataset.ok() ? FrameTimes(*dataset) : std::vector<Time_ns>();
  }
  const std::string& Root() const { return folder_.path(); }
  void WritePicture(const std::string& name) const {
    const image::ColorImage pixel{.width = 1, .height = 1, .rgb = {9, 9, 9}};
    folder_.Write(name, *image::EncodePng(pixel));
  }

  const base::TestingFolder folder_;
};

TEST_F(FrameTimesTest, NumbersCountThirtiethsOfASecondWithTheirGaps) {
  for (const char* stem :
       {"seq-01/frame-000010", "seq-01/frame-000011", "seq-01/frame-000041",
        "seq-02/frame-000000", "seq-02/frame-000002"}) {
    WritePicture(absl::StrCat(stem, ".color.png"));
  }
  // The second sequence follows on.
  EXPECT_THAT(TimesOf("7scenes:"),
              ElementsAre(333'333'333, 366'666'666, 1'366'666'666,
                          1'400'000'000, 1'466'666'666));
}

TEST_F(FrameTimesTest, TimeStampsAreTheTimesInTheOrderOfTheList) {
  folder_.Write("rgb.txt",
                "1305031910.765238 a.png\n1305031911.000000001 a.png\n");
  folder_.Write("depth.txt", "");
  WritePicture("a.png");
  EXPECT_THAT(TimesOf("tum:"),
              ElementsAre(1305031910765238000, 1305031911000000001));
  EXPECT_THAT(TimesOf("tum:", folder_.Write("list.txt",
                                            "1305031911.000000001\n"
                                            "1305031910.765238\n")),
              ElementsAre(1305031911000000001, 1305031910765238000));
}

}  // namespace
}  // namespace treeline::dataset

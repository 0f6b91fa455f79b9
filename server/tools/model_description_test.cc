#include "server/tools/model_description.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(DescribeModel, ShowsWhatAPersonAsksFor) {
  forest::ModelInfo model;
  model.method = "rgbd";
  model.format_version = 1;
  model.trees = 5;
  model.leaves = 482025;
  model.file_bytes = 48200000;
  model.options = {{"trees", "5"}, {"poses", ""}};
  model.calibration.color_from_depth.translation = {-0.0235, 0.005, 0};
  const std::string text = DescriptionText(DescribeModel(model));
  EXPECT_THAT(text, HasSubstr("482,025"));
  EXPECT_THAT(text, HasSubstr("48.2 MB"));
  EXPECT_THAT(text, HasSubstr("-2.350  0.500  0.000 cm"));
  EXPECT_THAT(text, HasSubstr("PINHOLE 585 585 320 240, 640 x 480"));
  EXPECT_THAT(text, Not(HasSubstr("shutter")));
  model.shutter = {.readout_s = 0.0275, .offset_s = -0.0055};
  EXPECT_THAT(DescriptionText(DescribeModel(model)),
              HasSubstr("rows are read in 27.5 ms, the middle one -5.5 ms"));
}

TEST(DescribeSizes, NamesWhatTakesTheFile) {
  const std::vector<forest::SectionSize> sections = {
      {.kind = 1, .file_bytes = 2000, .memory_bytes = 2000},
      {.kind = 4, .file_bytes = 300000, .memory_bytes = 700000},
      {.kind = 4, .forest = 1, .file_bytes = 100000, .memory_bytes = 200000},
      {.kind = 99, .file_bytes = 1000, .memory_bytes = 1000}};
  const DescriptionSection described = DescribeSizes(sections);
  EXPECT_THAT(
      described.rows,
      testing::ElementsAre(
          DescriptionRow{"splits of trees", "400.0 kB, in memory 900.0 kB"},
          DescriptionRow{"information", "3.0 kB"}));
}

TEST(Format, WritesCountsBytesAndOddNumbers) {
  EXPECT_EQ(FormatCount(0), "0");
  EXPECT_EQ(FormatCount(999), "999");
  EXPECT_EQ(FormatCount(1000), "1,000");
  EXPECT_EQ(FormatCount(-1234567), "-1,234,567");
  EXPECT_EQ(FormatBytes(999), "999 B");
  EXPECT_EQ(FormatBytes(1000), "1.0 kB");
  EXPECT_EQ(FormatBytes(34200000), "34.2 MB");
  EXPECT_EQ(FormatNumber("%.1f", std::nan("")), "-");
}

}  // namespace
}  // namespace treeline::tools

#include "client/fusion/drift_options.h"

#include <limits>

#include "client/fusion/drift_options_fields.h"
#include "gmock/gmock.h"

namespace treeline::drift {
namespace {

using ::testing::StartsWith;

TEST(DriftOptionsTest, TheDefaultsMakeSense) {
  EXPECT_TRUE(DriftOptions().Validate().ok());
}

TEST(DriftOptionsTest, EveryFieldMustBePositive) {
  DriftOptions options;
  ForEachField(options, [&options](const char* name, auto& field) {
    const auto before = field;
    for (const auto bad : {decltype(before){0}, decltype(before){-1}}) {
      field = bad;
      const absl::Status status = options.Validate();
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
      EXPECT_THAT(std::string(status.message()), StartsWith(name));
    }
    field = before;
  });
}

TEST(DriftOptionsTest, WhatIsNoNumberIsRefused) {
  EXPECT_FALSE(DriftOptions{.snap_m = std::numeric_limits<double>::quiet_NaN()}
                   .Validate()
                   .ok());
  EXPECT_FALSE(
      DriftOptions{.history_s = std::numeric_limits<double>::infinity()}
          .Validate()
          .ok());
  EXPECT_FALSE(DriftOptions{.min_confidence = 1.1}.Validate().ok());
}

}  // namespace
}  // namespace treeline::drift

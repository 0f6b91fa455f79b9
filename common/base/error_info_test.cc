#include "common/base/error_info.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::base {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

TEST(ErrorInfo, ReasonAndDetailsTravelWithTheStatus) {
  const absl::Status status =
      WithReason(absl::NotFoundError("no scene 'attic'"), "SCENE_NOT_FOUND",
                 {{"scene", "attic"}});
  EXPECT_EQ(status.message(), "no scene 'attic'");
  EXPECT_EQ(ErrorInfoOf(status).reason, "SCENE_NOT_FOUND");
  EXPECT_THAT(ErrorInfoOf(status).metadata,
              ElementsAre(Pair("scene", "attic")));
}

TEST(ErrorInfo, TheInnermostReasonWins) {
  const absl::Status inner =
      WithReason(absl::DataLossError("short"), "MODEL_CORRUPT");
  const absl::Status outer = WithReason(inner, "INTERNAL", {{"a", "b"}});
  EXPECT_EQ(ErrorInfoOf(outer).reason, "MODEL_CORRUPT");
  EXPECT_TRUE(ErrorInfoOf(outer).metadata.empty());
}

TEST(ErrorInfo, OkHasNone) {
  EXPECT_TRUE(WithReason(absl::OkStatus(), "X").ok());
  EXPECT_EQ(ErrorInfoOf(absl::OkStatus()).reason, "");
  EXPECT_EQ(RetryAfterOf(absl::OkStatus()), std::nullopt);
}

TEST(ErrorInfo, RetryTimesAreKeptToTheMillisecond) {
  const auto wait = std::chrono::milliseconds(120);
  EXPECT_EQ(RetryAfterOf(WithRetryAfter(absl::UnavailableError("x"), wait)),
            wait);
  EXPECT_EQ(RetryAfterOf(absl::UnavailableError("x")), std::nullopt);
}

}  // namespace
}  // namespace treeline::base

#include "nav_agent/service/driver_seat.h"

#include <chrono>

#include "gtest/gtest.h"

namespace treeline::agent_service {
namespace {

class DriverSeatTest : public ::testing::Test {
 protected:
  absl::StatusCode Take(const std::string& driver, uint64_t sequence,
                        int64_t at_ms) {
    return seat_
        .Take(driver, sequence,
              base::MonotonicTime() + std::chrono::milliseconds(1000 + at_ms))
        .code();
  }

  DriverSeat seat_;
};

TEST_F(DriverSeatTest, CommandsCountInTheirOrder) {
  EXPECT_EQ(Take("a", 5, 0), absl::StatusCode::kOk);
  EXPECT_EQ(Take("a", 7, 100), absl::StatusCode::kOk);
  EXPECT_EQ(Take("a", 6, 110), absl::StatusCode::kAborted);
  EXPECT_EQ(Take("a", 7, 120), absl::StatusCode::kAborted);
  // However long ago.
  EXPECT_EQ(Take("a", 7, 100'000), absl::StatusCode::kAborted);
  EXPECT_EQ(Take("a", 8, 100'010), absl::StatusCode::kOk);
}

TEST_F(DriverSeatTest, OneDrivesAtATime) {
  EXPECT_EQ(Take("a", 1, 0), absl::StatusCode::kOk);
  EXPECT_EQ(Take("b", 1, 290), absl::StatusCode::kUnavailable);
  EXPECT_EQ(Take("b", 1, 310), absl::StatusCode::kOk);
  EXPECT_EQ(Take("a", 2, 320), absl::StatusCode::kUnavailable);
}

TEST_F(DriverSeatTest, ADriverHasAName) {
  EXPECT_EQ(Take("", 1, 0), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Take(std::string(65, 'x'), 1, 0),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::agent_service

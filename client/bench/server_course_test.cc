#include "client/bench/server_course.h"

#include <atomic>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using ::testing::HasSubstr;

TEST(ServerCourse, HasThePointsBetweenLooks) {
  std::atomic<int> looks = 0;
  absl::Notification enough;
  ServerCourse course(
      [&]() -> absl::StatusOr<std::string> {
        const int look = looks++;
        if (look == 5) enough.Notify();
        return absl::StrCat("treeline_queue_depth ", look,
                            "\ntreeline_outcomes_total{scene=\"a\"} ",
                            100 * look, "\n");
      },
      0.01);
  enough.WaitForNotification();
  const Course found = course.Finish();
  ASSERT_EQ(found.points.size(), static_cast<size_t>(looks) - 1);
  EXPECT_EQ(found.missed, 0);
  double last_s = 0;
  for (size_t i = 0; i < found.points.size(); ++i) {
    EXPECT_EQ(found.points[i].figures.queue_depth, i + 1);
    EXPECT_GT(found.points[i].figures.answers_per_s, 0);
    EXPECT_GT(found.points[i].at_unix_s, last_s);
    last_s = found.points[i].at_unix_s;
  }
}

TEST(ServerCourse, CountsWhatItMissed) {
  int look = 0;
  absl::Notification enough;
  ServerCourse course(
      [&]() -> absl::StatusOr<std::string> {
        ++look;
        if (look == 6) enough.Notify();
        if (look == 2) return absl::UnavailableError("gone");
        if (look == 3) return "no metrics";
        return "up 1\n";
      },
      0.01);
  enough.WaitForNotification();
  const Course found = course.Finish();
  EXPECT_EQ(found.missed, 2);
  EXPECT_THAT(found.last_error, HasSubstr("line 1"));
  EXPECT_EQ(found.points.size(), static_cast<size_t>(look) - 3);
}

}  // namespace
}  // namespace treeline::bench

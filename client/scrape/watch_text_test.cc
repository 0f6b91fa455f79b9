#include "client/scrape/watch_text.h"

#include <cmath>
#include <limits>
#include <string>

#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::scrape {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

ServerFigures Busy() {
  ServerFigures figures;
  figures.answers_per_s = 84.25;
  figures.localized_share = 0.937;
  figures.shed_per_s = 3;
  figures.p50_ms = 11.25;
  figures.p99_ms = 30.1;
  figures.stage_ms = {{"queue", 0.25}, {"pose", 2}};
  figures.queue_depth = 16;
  figures.queue_capacity = 64;
  figures.in_flight = 2;
  figures.workers = 2;
  figures.processors = 1.9;
  figures.resident_bytes = 123e6;
  figures.scenes = {{"READY", 2}, {"FAILED", 1}};
  figures.answers_per_s_by_scene = {{"kitchen", 84.25}};
  figures.version = "0.1.0";
  figures.up_s = 7325;
  return figures;
}

TEST(WatchScreen, SaysHowTheServerDoes) {
  const std::string screen = WatchScreen("http://host:8080", {Busy()}, 80);
  EXPECT_THAT(
      screen,
      AllOf(HasSubstr("http://host:8080   treeline-server 0.1.0, up 2 h 2 min"),
            HasSubstr("84.2/s, localized 94 %"),
            HasSubstr("3.0/s shed, 0.0/s failed"),
            HasSubstr("p50 11.2 ms, p99 30.1 ms"), HasSubstr("mean 2.0 ms"),
            HasSubstr("[####################] 2 of 2"),
            HasSubstr("[#####               ] 16 of 64"),
            HasSubstr("1 FAILED, 2 READY"), HasSubstr("kitchen 84.2/s"),
            HasSubstr("123 MB")));
}

TEST(WatchScreen, KeepsToItsWidth) {
  std::deque<ServerFigures> history(500, Busy());
  for (const int columns : {40, 80, 200}) {
    const std::string screen = WatchScreen("host", history, columns);
    for (const absl::string_view line : absl::StrSplit(screen, '\n')) {
      int shown = 0;
      for (const char c : line) shown += (c & 0xc0) != 0x80;
      EXPECT_LE(shown, std::max(columns, 52)) << std::string(line);
    }
  }
}

TEST(WatchScreen, IsNotSteeredByWhatAServerSays) {
  ServerFigures evil = Busy();
  evil.version = "\x1b[2J";
  evil.answers_per_s_by_scene = {{"a\x07\nb", 1}};
  evil.scenes = {{"\x7f", 1}};
  EXPECT_THAT(WatchScreen("host", {evil}, 80),
              AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\x07")),
                    Not(HasSubstr("\x7f")), HasSubstr("a??b")));
}

TEST(WatchScreen, HasNoNumberWhereThereIsNone) {
  ServerFigures quiet;
  quiet.localized_share = std::numeric_limits<double>::quiet_NaN();
  quiet.p50_ms = quiet.localized_share;
  quiet.p99_ms = quiet.localized_share;
  EXPECT_THAT(WatchScreen("host", {quiet}, 80),
              AllOf(HasSubstr("p50 -, p99 -"), Not(HasSubstr("nan"))));
  EXPECT_THAT(WatchLine(quiet), Not(HasSubstr("nan")));
}

TEST(Sparkline, GrowsToItsLargest) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Sparkline({0, 0.001, 4, 8, none}, 10), " ▁▄█ ");
  EXPECT_EQ(Sparkline({9, 9, 1, 8}, 2), "▁█");
  EXPECT_EQ(Sparkline({}, 10), "");
  EXPECT_EQ(Sparkline({0, 0}, 10), "  ");
}

}  // namespace
}  // namespace treeline::scrape

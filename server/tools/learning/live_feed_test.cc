#include "server/tools/learning/live_feed.h"

#include <memory>
#include <string>

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::learning {
namespace {

using ::testing::HasSubstr;

// So many frames, all of the same pictures; every third one is no frame if
// `some_are_none`.
class SameFrames final : public LiveSource {
 public:
  SameFrames(int frames, std::string picture, bool some_are_none = false)
      : frames_(frames),
        picture_(std::move(picture)),
        some_are_none_(some_are_none) {}

  absl::StatusOr<std::optional<LiveItem>> Next(
      const std::stop_token& stop) override {
    if (given_ == frames_ || stop.stop_requested()) return std::nullopt;
    if (++given_ % 3 == 0 && some_are_none_) {
      return absl::InvalidArgumentError("no frame");
    }
    return LiveItem(LiveFrame{picture_, picture_, {}});
  }

 private:
  const int frames_;
  const std::string picture_;
  const bool some_are_none_;
  int given_ = 0;
};

class LiveFeedTest : public testing::Test {
 protected:
  LiveFeedTest() { folder_.Write("picture", "bytes"); }
  std::unique_ptr<LiveSource> Frames(int count, bool some_are_none = false) {
    return std::make_unique<SameFrames>(count, folder_.Path("picture"),
                                        some_are_none);
  }
  static int TakeAll(LiveFeed& feed) {
    int taken = 0;
    while (feed.Next()) ++taken;
    return taken;
  }
  // The source has given all that it has.
  static void WaitForArrivals(const LiveFeed& feed, int64_t count) {
    while (feed.counts().arrived < count) std::this_thread::yield();
  }

  const base::TestingFolder folder_;
};

TEST_F(LiveFeedTest, GivesFramesInTheirOrderWithTheirPictures) {
  LiveFeed feed(Frames(3), {}, {});
  const auto frame = feed.Next();
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(std::get<ArrivedFrame>(*frame).color, "bytes");
  EXPECT_EQ(std::get<ArrivedFrame>(*frame).depth, "bytes");
  EXPECT_EQ(TakeAll(feed), 2);
  EXPECT_EQ(feed.counts().arrived, 3);
  EXPECT_EQ(feed.counts().skipped, 0);
  EXPECT_TRUE(feed.status().ok());
}

TEST_F(LiveFeedTest, SkipsAndCountsWhatASlowLearnerHasNoRoomFor) {
  LiveFeed feed(Frames(50), {.capacity = 4}, {});
  WaitForArrivals(feed, 50);
  EXPECT_EQ(TakeAll(feed), 4);
  EXPECT_EQ(feed.counts().skipped, 46);
}

// One frame, so many corrections of it, and the end of frames.
class Corrected final : public LiveSource {
 public:
  Corrected(int corrections, std::string picture)
      : corrections_(corrections), picture_(std::move(picture)) {}
  absl::StatusOr<std::optional<LiveItem>> Next(
      const std::stop_token& stop) override {
    const int item = given_++;
    if (item > corrections_ + 1 || stop.stop_requested()) return std::nullopt;
    if (item == 0) return LiveItem(LiveFrame{picture_, picture_, {}});
    if (item > corrections_) return LiveItem(EndOfFrames());
    return LiveItem(PoseCorrection{picture_, {{}, {1.0 * item, 0, 0}}});
  }

 private:
  const int corrections_;
  const std::string picture_;
  int given_ = 0;
};

// However many they are, and in their order.
TEST_F(LiveFeedTest, SkipsNoCorrections) {
  LiveFeed feed(std::make_unique<Corrected>(50, folder_.Path("picture")),
                {.capacity = 2}, {});
  ASSERT_TRUE(std::holds_alternative<ArrivedFrame>(feed.Next().value()));
  for (int i = 1; i <= 50; ++i) {
    const auto correction = std::get<PoseCorrection>(feed.Next().value());
    EXPECT_EQ(correction.world_from_sensor.translation.x, i);
  }
  EXPECT_TRUE(std::holds_alternative<EndOfFrames>(feed.Next().value()));
  EXPECT_FALSE(feed.Next().has_value());
  EXPECT_EQ(feed.counts().arrived, 1);
}

TEST_F(LiveFeedTest, WaitsForTheLearnerWhereItMay) {
  LiveFeed feed(Frames(50), {.waits = true, .capacity = 4}, {});
  EXPECT_EQ(TakeAll(feed), 50);
  EXPECT_EQ(feed.counts().skipped, 0);
}

TEST_F(LiveFeedTest, CountsWhatCannotBeRead) {
  LiveFeed wrong_lines(Frames(9, /*some_are_none=*/true), {}, {});
  EXPECT_EQ(TakeAll(wrong_lines), 6);
  EXPECT_EQ(wrong_lines.counts().unreadable, 3);

  LiveFeed no_files(std::make_unique<SameFrames>(2, folder_.Path("nowhere")),
                    {}, {});
  EXPECT_EQ(TakeAll(no_files), 0);
  EXPECT_EQ(no_files.counts().unreadable, 2);
  EXPECT_THAT(no_files.counts().first_unreadable.message(),
              HasSubstr("nowhere"));
}

TEST_F(LiveFeedTest, KeepsThePace) {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  LiveFeed feed(Frames(5), {.rate_hz = 50}, {});
  EXPECT_EQ(TakeAll(feed), 5);
  EXPECT_GE(base::SecondsBetween(start, clock.Now()), 4 / 50.0);
}

TEST_F(LiveFeedTest, EndsWhenItIsToStop) {
  std::stop_source stop;
  // The second frame would come in an hour.
  LiveFeed feed(Frames(2), {.rate_hz = 1 / 3600.0}, stop.get_token());
  EXPECT_TRUE(feed.Next().has_value());
  stop.request_stop();
  EXPECT_FALSE(feed.Next().has_value());
  EXPECT_TRUE(feed.status().ok());
}

}  // namespace
}  // namespace treeline::learning

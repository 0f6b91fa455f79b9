#include "nav_agent/drivers/camera/frame_queue.h"

#include "gtest/gtest.h"

namespace treeline::camera_driver {
namespace {

core::RgbdFrame Numbered(int64_t sequence) {
  return {.stamp = {}, .sequence = sequence, .frame = {}};
}

TEST(FrameQueue, HandsOverInOrderAndOnce) {
  FrameQueue queue(4);
  EXPECT_EQ(queue.Health().state, core::DeviceState::kStarting);
  for (int i = 0; i < 3; ++i) queue.Push(Numbered(i));
  const auto frames = queue.Take();
  ASSERT_EQ(frames.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[static_cast<size_t>(i)].sequence, i);
  }
  EXPECT_TRUE(queue.Take().empty());
  EXPECT_EQ(queue.Health().state, core::DeviceState::kRunning);
  EXPECT_EQ(queue.Health().received, 3);
}

TEST(FrameQueue, KeepsTheLatest) {
  FrameQueue queue(4);
  for (int i = 0; i < 10; ++i) queue.Push(Numbered(i));
  EXPECT_EQ(queue.Health().dropped, 6);
  EXPECT_EQ(queue.Take().front().sequence, 6);
}

TEST(FrameQueue, ALossIsCountedOnceAndEndsWithTheNextFrame) {
  FrameQueue queue(4);
  queue.SetLost(absl::NotFoundError("none"));
  EXPECT_EQ(queue.Health().state, core::DeviceState::kStarting);
  EXPECT_EQ(queue.Health().losses, 0);
  queue.Push(Numbered(0));
  queue.SetLost(absl::UnavailableError("unplugged"));
  queue.SetLost(absl::NotFoundError("none"));
  EXPECT_EQ(queue.Health().state, core::DeviceState::kLost);
  EXPECT_EQ(queue.Health().losses, 1);
  EXPECT_EQ(queue.Health().cause, absl::NotFoundError("none"));
  queue.Push(Numbered(1));
  EXPECT_TRUE(queue.Health().cause.ok());
}

}  // namespace
}  // namespace treeline::camera_driver

#include "server/service/frame_queue.h"

#include <memory>

#include "common/base/byte_budget.h"
#include "common/base/error_info.h"
#include "common/wire/status.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::service {
namespace {

FrameQueue::FramePtr FrameOf(uint64_t id, int max_pending = 0,
                             bool drop_oldest = false) {
  auto frame = std::make_shared<FrameQueue::Frame>();
  frame->request.set_id(id);
  frame->request.mutable_settings()->set_max_pending(max_pending);
  frame->request.mutable_settings()->set_drop_oldest(drop_oldest);
  return frame;
}

uint64_t IdOf(const FrameQueue::FramePtr& frame) {
  return frame == nullptr ? 0 : frame->answer.id();
}

TEST(FrameQueueTest, AnswersInTheOrderOfArrival) {
  FrameQueue queue;
  EXPECT_TRUE(queue.MayRead());
  EXPECT_TRUE(queue.Accept(FrameOf(7)).ok());
  EXPECT_TRUE(queue.Accept(FrameOf(5)).ok());
  const FrameQueue::FramePtr first = queue.NextToDispatch();
  const FrameQueue::FramePtr second = queue.NextToDispatch();
  EXPECT_EQ(IdOf(first), 7u);
  EXPECT_EQ(IdOf(second), 5u);
  EXPECT_EQ(queue.NextToDispatch(), nullptr);
  FrameQueue::Answer(*second, v1::LocalizeResponse());
  EXPECT_EQ(queue.NextAnswered(), nullptr);
  FrameQueue::Answer(*first, absl::NotFoundError("no such scene"));
  const FrameQueue::FramePtr answered = queue.NextAnswered();
  EXPECT_EQ(IdOf(answered), 7u);
  EXPECT_TRUE(absl::IsNotFound(wire::FromProto(answered->answer.error())));
  EXPECT_EQ(IdOf(queue.NextAnswered()), 5u);
  EXPECT_TRUE(queue.empty());
}

TEST(FrameQueueTest, HoldsNoMoreThanTheSettingsSay) {
  FrameQueue queue;
  EXPECT_TRUE(queue.Accept(FrameOf(1, 2)).ok());
  EXPECT_TRUE(queue.MayRead());
  EXPECT_TRUE(queue.Accept(FrameOf(2)).ok());
  EXPECT_FALSE(queue.MayRead());
  EXPECT_EQ(queue.DropOldest(), nullptr);
  const FrameQueue::FramePtr first = queue.NextToDispatch();
  queue.LeaveDispatcher();
  FrameQueue::Answer(*first, v1::LocalizeResponse());
  // An answer that is not taken holds its place.
  EXPECT_FALSE(queue.MayRead());
  EXPECT_EQ(IdOf(queue.NextAnswered()), 1u);
  EXPECT_TRUE(queue.MayRead());
}

TEST(FrameQueueTest, OldFramesGiveWayWhereTheyShould) {
  FrameQueue queue;
  for (uint64_t id = 1; id <= 2; ++id) {
    EXPECT_TRUE(queue.Accept(FrameOf(id, 1, true)).ok());
    EXPECT_EQ(IdOf(queue.NextToDispatch()), id);
  }
  // Two are computed; one may wait.
  EXPECT_TRUE(queue.Accept(FrameOf(3)).ok());
  EXPECT_EQ(queue.NextToDispatch(), nullptr);
  EXPECT_EQ(queue.DropOldest(), nullptr);
  EXPECT_TRUE(queue.MayRead());
  EXPECT_TRUE(queue.Accept(FrameOf(4)).ok());
  const FrameQueue::FramePtr dropped = queue.DropOldest();
  EXPECT_EQ(IdOf(dropped), 3u);
  EXPECT_EQ(queue.DropOldest(), nullptr);
  EXPECT_EQ(base::ErrorInfoOf(FrameQueue::DroppedStatus()).reason,
            "FRAME_DROPPED");
  queue.LeaveDispatcher();
  EXPECT_EQ(IdOf(queue.NextToDispatch()), 4u);
}

TEST(FrameQueueTest, AnAnswerLetsItsPicturesGo) {
  base::ByteBudget budget(100);
  FrameQueue queue;
  FrameQueue::FramePtr frame = FrameOf(1);
  frame->lease = base::ByteLease(&budget);
  ASSERT_TRUE(frame->lease.Resize(60));
  frame->request.mutable_localize()->mutable_frame()->mutable_color();
  EXPECT_TRUE(queue.Accept(frame).ok());
  FrameQueue::Answer(*frame, v1::LocalizeResponse());
  EXPECT_EQ(budget.used_bytes(), 0u);
  EXPECT_FALSE(frame->request.has_localize());
}

TEST(FrameQueueTest, RefusesAbsurdSettings) {
  for (const int max_pending : {-1, 65}) {
    FrameQueue queue;
    EXPECT_TRUE(absl::IsInvalidArgument(queue.Accept(FrameOf(1, max_pending))));
    EXPECT_TRUE(queue.empty());
  }
}

}  // namespace
}  // namespace treeline::service

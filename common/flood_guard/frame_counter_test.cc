#include "common/flood_guard/frame_counter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/flood_guard/testing_frames.h"

namespace treeline::flood_guard {
namespace {

// What is counted when the bytes come in pieces of this size.
FrameCounts CountOf(absl::string_view bytes, size_t step,
                    bool goes_on_expected) {
  FrameCounter counter;
  FrameCounts counts;
  bool goes_on = true;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(step, bytes.size()))) {
    goes_on = counter.Count(bytes.substr(0, step), counts);
  }
  EXPECT_EQ(goes_on, goes_on_expected);
  return counts;
}

FrameCounts CountOf(const std::string& bytes, bool goes_on = true) {
  const FrameCounts counts = CountOf(bytes, bytes.size(), goes_on);
  for (const size_t step : {1u, 2u, 5u, 9u, 24u, 100u}) {
    EXPECT_EQ(CountOf(bytes, step, goes_on), counts) << step;
  }
  return counts;
}

std::string AfterPreface(const std::string& frames) {
  return kTestPreface + frames;
}

TEST(FrameCounter, APayloadIsNotAFrame) {
  const std::string payload =
      TestFrame(kTestHeaders, 4, 3, "xyz") + std::string(200, 'x');
  EXPECT_EQ(CountOf(AfterPreface(TestFrame(kTestData, 0, 1, payload))),
            FrameCounts{.payload_bytes = static_cast<int64_t>(payload.size())});
}

TEST(FrameCounter, ACallWithItsMessageIsOneCallAndLittleElse) {
  EXPECT_EQ(
      CountOf(AfterPreface(TestFrame(kTestHeaders, 4, 1, "block") +
                           TestFrame(kTestData, 0, 1, std::string(16384, 'x')) +
                           TestFrame(kTestData, 1, 1, "end"))),
      (FrameCounts{.calls = 1, .frames = 1, .payload_bytes = 16387}));
}

TEST(FrameCounter, WhatIsOnlyAnnouncedIsNoPayload) {
  const std::string frame = TestFrame(kTestData, 0, 1, std::string(1000, 'x'));
  EXPECT_EQ(CountOf(AfterPreface(frame.substr(0, 109))),
            FrameCounts{.payload_bytes = 100});
  EXPECT_EQ(CountOf(AfterPreface(
                TestFrame(kTestSettings, 0, 0, std::string(1000, 'x')))),
            FrameCounts{.frames = 1});
}

TEST(FrameCounter, EveryFrameThatBringsNothingCounts) {
  std::string frames;
  for (int type = 0; type < 256; ++type) {
    if (type != kTestHeaders) frames += TestFrame(type, 0, 1, "");
  }
  EXPECT_EQ(CountOf(AfterPreface(frames)),
            (FrameCounts{.calls = 0, .frames = 255}));
}

TEST(FrameCounter, LongHeadersCountAsSeveralCalls) {
  const std::string quarter(10000, 'h');
  EXPECT_EQ(CountOf(AfterPreface(TestFrame(kTestHeaders, 0, 1, quarter) +
                                 TestFrame(kTestContinuation, 0, 1, quarter) +
                                 TestFrame(kTestContinuation, 4, 1, quarter))),
            (FrameCounts{.calls = 1 + 30000 / 4096, .frames = 2}));
}

TEST(FrameCounter, HeadersWithoutEndEndIt) {
  std::string frames = TestFrame(kTestHeaders, 0, 1, "");
  const std::string piece =
      TestFrame(kTestContinuation, 0, 1, std::string(16384, 'h'));
  for (int i = 0; i < 4; ++i) frames += piece;
  CountOf(AfterPreface(frames));
  CountOf(AfterPreface(frames + TestFrame(kTestContinuation, 4, 1, "h")),
          false);
}

TEST(FrameCounter, HeadersOfOneCallSayNothingOfTheNext) {
  std::string frames;
  for (int i = 0; i < 100; ++i) {
    frames += TestFrame(kTestHeaders, 4, 2 * i + 1, std::string(16000, 'h'));
  }
  CountOf(AfterPreface(frames));
}

TEST(FrameCounter, WhatIsNoHttp2IsNotCounted) {
  const std::string frames = TestFrame(kTestHeaders, 4, 1, "block");
  EXPECT_EQ(CountOf(frames), FrameCounts());
  EXPECT_EQ(CountOf("GET / HTTP/1.1\r\n\r\n" + frames), FrameCounts());
  EXPECT_EQ(CountOf("PRI * HTTP/2.0\r\n\r\nSM\r\n\rX" + frames), FrameCounts());
}

}  // namespace
}  // namespace treeline::flood_guard

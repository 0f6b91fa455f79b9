#include "nav_agent/behavior/server_question.h"

#include <memory>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

class ServerQuestionTest : public testing::Test {
 protected:
  ServerQuestionTest() {
    tracker_.now = At(100);
    server_.answers = {[] { return core::RelocalizationAnswer(); }};
  }
  void Ask() {
    question_.Ask(std::make_shared<const core::RgbdFrame>(), *tracker_.Motion(),
                  tracker_.now);
  }
  std::optional<ServerQuestion::Answer> TakeAfter(double seconds) {
    tracker_.now = At(100 + seconds);
    return question_.Take(tracker_.now);
  }

  ScriptedTracker tracker_;
  FakeServer server_{tracker_};
  ServerQuestion question_{&server_, 3};
};

TEST_F(ServerQuestionTest, IsOpenUntilItIsAnswered) {
  EXPECT_FALSE(question_.is_open());
  Ask();
  EXPECT_TRUE(question_.is_open());
  EXPECT_FALSE(TakeAfter(0.1).has_value());
  EXPECT_TRUE(question_.is_open());
  const auto answer = TakeAfter(0.3);
  ASSERT_TRUE(answer.has_value());
  EXPECT_TRUE(answer->ok());
  EXPECT_FALSE(question_.is_open());
}

TEST_F(ServerQuestionTest, AServerThatSaysNothingHasFailedInTheEnd) {
  // The port itself does not keep its deadline.
  server_.delay_s = 1e9;
  ServerQuestion patient(&server_, 1e8);
  patient.Ask(std::make_shared<const core::RgbdFrame>(), *tracker_.Motion(),
              tracker_.now);
  EXPECT_FALSE(patient.Take(At(100 + 1e7)).has_value());
  const auto answer = patient.Take(At(100 + 1.1e8));
  ASSERT_TRUE(answer.has_value());
  EXPECT_TRUE(absl::IsDeadlineExceeded(answer->status()));
  EXPECT_FALSE(patient.is_open());
  EXPECT_FALSE(server_.IsAsking());
}

TEST_F(ServerQuestionTest, RemembersWhatItWasOf) {
  EXPECT_EQ(question_.frame(), nullptr);
  tracker_.odom_from_base = {{1, 2}, 0.5};
  Ask();
  tracker_.odom_from_base = {{3, 4}, 0.7};
  ASSERT_TRUE(TakeAfter(0.3).has_value());
  EXPECT_EQ(question_.motion().odom_from_base, (geometry::Rigid2{{1, 2}, 0.5}));
  EXPECT_NE(question_.frame(), nullptr);
}

TEST_F(ServerQuestionTest, ACancelledOneIsNotAnswered) {
  Ask();
  question_.Cancel();
  EXPECT_FALSE(question_.is_open());
  EXPECT_FALSE(server_.IsAsking());
}

TEST(ServerQuestionWithoutServer, MayBeCancelled) {
  ServerQuestion question(nullptr, 3);
  EXPECT_FALSE(question.has_server());
  question.Cancel();
  EXPECT_FALSE(question.is_open());
}

}  // namespace
}  // namespace treeline::behavior

#include "nav_agent/bridge/dds/node.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/testing_domain.h"

namespace treeline::dds {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// A name of a message; its bytes mean nothing here.
constexpr char kType[] = "std_msgs/msg/Header";

std::vector<uint8_t> Bytes(size_t size, uint8_t first) {
  std::vector<uint8_t> bytes(size);
  std::iota(bytes.begin(), bytes.end(), first);
  if (size >= 4) bytes[0] = bytes[1] = bytes[2] = bytes[3] = 0;
  return bytes;
}

// Two nodes in a domain of their own, over loopback alone.
class NodeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto domain = Domain::Join({.id = TestingDomain(), .interface = "lo"});
    ASSERT_TRUE(domain.ok()) << domain.status();
    domain_ = *std::move(domain);
    auto a = Node::Create(*domain_, {.node = "a", .remappings = {}});
    auto b = Node::Create(*domain_, {.node = "b", .remappings = {}});
    ASSERT_TRUE(a.ok() && b.ok());
    a_ = *std::move(a);
    b_ = *std::move(b);
  }

  // False: they have not found each other within ten seconds.
  static bool WaitForMatch(Node& node, const Publisher& publisher) {
    for (int i = 0; i < 1000 && publisher.matched() == 0; ++i) {
      node.Wait(milliseconds(10));
    }
    return publisher.matched() > 0;
  }

  std::unique_ptr<Domain> domain_;
  std::unique_ptr<Node> a_;
  std::unique_ptr<Node> b_;
};

TEST_F(NodeTest, SamplesArriveByteByByteAndInOrder) {
  auto publisher = *a_->Advertise("scan", kType, {.depth = 10});
  auto subscription = *b_->Subscribe("/scan", kType, kSensorData);
  EXPECT_EQ(publisher->topic(), "/scan");
  ASSERT_TRUE(WaitForMatch(*b_, *publisher));
  // Sizes that are no multiple of four, and one that takes several packets.
  for (const size_t size : std::array<size_t, 5>{8, 9, 10, 11, 100'001}) {
    const std::vector<uint8_t> sent = Bytes(size, 7);
    ASSERT_TRUE(publisher->Publish(sent).ok());
    ASSERT_TRUE(b_->Wait(seconds(10)));
    const std::vector<Sample> samples = subscription->Take();
    ASSERT_EQ(samples.size(), 1U);
    EXPECT_GT(samples[0].written_ns, 0);
    // The last of the four in front tells the padding.
    std::vector<uint8_t> expected = sent;
    expected[3] = static_cast<uint8_t>((4 - size % 4) % 4);
    EXPECT_EQ(samples[0].bytes, expected) << size;
  }
  EXPECT_TRUE(subscription->Take().empty());
}

TEST_F(NodeTest, WhoComesLateGetsWhatIsLatched) {
  auto publisher = *a_->Advertise("map", kType, kLatched);
  ASSERT_TRUE(publisher->Publish(Bytes(8, 1)).ok());
  ASSERT_TRUE(publisher->Publish(Bytes(8, 2)).ok());
  auto subscription = *b_->Subscribe("map", kType, kLatched);
  ASSERT_TRUE(b_->Wait(seconds(10)));
  const std::vector<Sample> samples = subscription->Take();
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].bytes, Bytes(8, 2));
}

TEST_F(NodeTest, OtherTypesAndQualitiesDoNotMatch) {
  auto publisher = *a_->Advertise("x", kType, kSensorData);
  auto other_type = *b_->Subscribe("x", "std_msgs/msg/Empty", kSensorData);
  auto too_demanding = *b_->Subscribe("x", kType, {.is_reliable = true});
  auto good = *b_->Subscribe("x", kType, kSensorData);
  ASSERT_TRUE(WaitForMatch(*b_, *publisher));
  // All three readers were made before; what matches has matched.
  ASSERT_TRUE(publisher->Publish(Bytes(8, 1)).ok());
  ASSERT_TRUE(b_->Wait(seconds(10)));
  EXPECT_EQ(good->Take().size(), 1U);
  EXPECT_EQ(other_type->matched(), 0);
  EXPECT_EQ(too_demanding->matched(), 0);
  EXPECT_EQ(publisher->matched(), 1);
}

TEST_F(NodeTest, WaitingEndsWithoutASample) {
  auto subscription = *b_->Subscribe("silence", kType, kSensorData);
  EXPECT_FALSE(b_->Wait(milliseconds(20)));
  EXPECT_TRUE(subscription->Take().empty());
}

// Who takes is not kept by who writes faster.
TEST_F(NodeTest, AFloodIsTakenInParts) {
  auto publisher = *a_->Advertise("flood", kType, {.depth = 1000});
  auto subscription = *b_->Subscribe("flood", kType, {.depth = 1000});
  ASSERT_TRUE(WaitForMatch(*b_, *publisher));
  for (int i = 0; i < 900; ++i) {
    ASSERT_TRUE(publisher->Publish(Bytes(8, 1)).ok());
  }
  size_t taken = 0;
  for (int i = 0; i < 100 && taken < 900; ++i) {
    b_->Wait(seconds(1));
    const size_t part = subscription->Take().size();
    EXPECT_LE(part, 256U);
    taken += part;
  }
  EXPECT_EQ(taken, 900U);
}

TEST_F(NodeTest, BadNamesAreErrors) {
  EXPECT_EQ(a_->Advertise("a b", kType, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Node::Create(*domain_, {.node = "a/b c", .remappings = {}})
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(DomainTest, ErrorsSayWhatIsWrong) {
  EXPECT_EQ(Domain::Join({.id = 233, .interface = ""}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Domain::Join({.id = 1, .interface = "\"/>"}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(NodeTest, WhyNobodyIsThereIsSaid) {
  const auto listens = *b_->Subscribe("scan", kType, {.is_reliable = true});
  const auto offers = *a_->Advertise("front/scan", kType, kSensorData);
  const auto says = [this, &listens](const std::string& what) {
    for (int i = 0; i < 1000; ++i) {
      if (listens->WhyNobody().find(what) != std::string::npos) return true;
      b_->Wait(milliseconds(10));
    }
    return false;
  };
  EXPECT_TRUE(says("of type std_msgs/msg/Header there is /front/scan"))
      << listens->WhyNobody();
  {
    const auto best_effort = *a_->Advertise("scan", kType, kSensorData);
    EXPECT_TRUE(says("published as best effort")) << listens->WhyNobody();
    EXPECT_EQ(listens->matched(), 0);
  }
  // Who has left is named no more.
  EXPECT_TRUE(says("nobody publishes /scan")) << listens->WhyNobody();
  const auto reliable = *a_->Advertise("scan", kType, {});
  ASSERT_TRUE(WaitForMatch(*b_, *reliable));
  for (int i = 0; i < 1000 && listens->matched() == 0; ++i) {
    b_->Wait(milliseconds(10));
  }
  EXPECT_EQ(listens->WhyNobody(), "");
  EXPECT_EQ(reliable->WhyNobody(), "");
}

}  // namespace
}  // namespace treeline::dds

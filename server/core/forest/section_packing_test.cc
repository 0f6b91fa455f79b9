#include "server/core/forest/section_packing.h"

#include <cstring>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/forest/forest.h"

namespace treeline::forest {
namespace {

template <typename T>
absl::string_view BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(T)};
}

absl::StatusOr<std::string> Unpacked(absl::string_view packed) {
  const absl::StatusOr<uint64_t> bytes = UnpackedBytes(packed);
  if (!bytes.ok()) return bytes.status();
  std::string out(*bytes, 'x');
  const absl::Status status = UnpackSection(
      packed, {reinterpret_cast<uint8_t*>(out.data()), out.size()});
  if (!status.ok()) return status;
  return out;
}

// Two fields of two bytes, one of four, one of one: values near those before.
std::string SomeRecords(size_t count) {
  base::Random random(7, 0);
  std::string records;
  for (size_t i = 0; i < count; ++i) {
    const std::array<uint16_t, 2> small = {
        static_cast<uint16_t>(65530 + i + random.NextBelow(4)),
        static_cast<uint16_t>(random.NextBelow(9))};
    const uint32_t large = 0xfffffff0u + static_cast<uint32_t>(3 * i);
    const auto byte = static_cast<uint8_t>(random.NextBelow(3));
    records.append(reinterpret_cast<const char*>(small.data()), 4);
    records.append(reinterpret_cast<const char*>(&large), 4);
    records.append(reinterpret_cast<const char*>(&byte), 1);
  }
  return records;
}

const RecordFields kSomeFields = {{.width = 2, .is_delta = true},
                                  {.width = 2, .is_delta = false},
                                  {.width = 4, .is_delta = true},
                                  {.width = 1, .is_delta = false}};

// A random tree with `leaves` leaves, each with up to `max_modes` modes.
void AppendTree(base::Random& random, uint32_t leaves, uint32_t max_modes,
                uint32_t& next_mode, std::vector<Node>& nodes) {
  if (leaves == 1) {
    const uint32_t modes = 1 + random.NextBelow(max_modes);
    nodes.push_back(Node::Leaf(next_mode, modes));
    next_mode += modes;
    return;
  }
  const size_t self = nodes.size();
  nodes.emplace_back();
  const uint32_t left = 1 + random.NextBelow(leaves - 1);
  AppendTree(random, left, max_modes, next_mode, nodes);
  const auto delta = [&] {
    return static_cast<int16_t>(static_cast<int>(random.NextBelow(1024)) - 512);
  };
  nodes[self] =
      Node::Split({delta(), delta(), static_cast<uint8_t>(random.NextBelow(3)),
                   static_cast<uint8_t>(random.NextBelow(3))},
                  static_cast<int>(random.NextBelow(512)) - 256,
                  static_cast<uint32_t>(nodes.size() - self));
  AppendTree(random, leaves - left, max_modes, next_mode, nodes);
}

std::vector<Node> SomeTrees() {
  base::Random random(3, 0);
  std::vector<Node> nodes;
  uint32_t next_mode = 0;
  for (const uint32_t leaves : {1u, 200u, 57u, 1u}) {
    AppendTree(random, leaves, 3, next_mode, nodes);
  }
  return nodes;
}

TEST(SectionPackingTest, RecordsComeBackToTheBit) {
  const std::string records = SomeRecords(1000);
  const std::string packed = PackRecords(records, kSomeFields);
  ASSERT_FALSE(packed.empty());
  EXPECT_LT(packed.size(), records.size() / 3);
  EXPECT_EQ(*Unpacked(packed), records);
  EXPECT_EQ(PackRecords(records, kSomeFields), packed);
}

TEST(SectionPackingTest, WhatCannotBeShorterIsNotPacked) {
  EXPECT_EQ(PackRecords("", kSomeFields), "");
  EXPECT_EQ(PackRecords(SomeRecords(1), kSomeFields), "");
  // Not a whole number of records, and no fields at all.
  EXPECT_EQ(PackRecords(SomeRecords(1000).substr(1), kSomeFields), "");
  EXPECT_EQ(PackRecords(SomeRecords(1000), {}), "");
  base::Random random(1, 0);
  std::string noise(4096, '\0');
  for (char& c : noise) c = static_cast<char>(random.NextBelow(256));
  EXPECT_EQ(PackRecords(noise, {{.width = 1, .is_delta = false}}), "");
  EXPECT_EQ(PackNodes(""), "");
}

TEST(SectionPackingTest, NodesComeBackToTheBit) {
  const std::vector<Node> nodes = SomeTrees();
  const std::string packed = PackNodes(BytesOf(nodes));
  // A bit a node, 33 a split and 2 a leaf, of random ones; of 64 a node.
  EXPECT_LT(packed.size(), nodes.size() * 4);
  EXPECT_EQ(*Unpacked(packed), BytesOf(nodes));
}

TEST(SectionPackingTest, NodesLinkedInAnotherWayComeBackToo) {
  std::vector<Node> nodes = SomeTrees();
  // As in a base for --adapt: all leaves are one.
  for (Node& node : nodes) {
    if (node.is_leaf()) node = Node::Leaf(0);
  }
  const std::string packed = PackNodes(BytesOf(nodes));
  ASSERT_FALSE(packed.empty());
  EXPECT_EQ(*Unpacked(packed), BytesOf(nodes));
  std::vector<Node> other = SomeTrees();
  other[1].hi += 1u << 9;
  const std::string packed_other = PackNodes(BytesOf(other));
  ASSERT_FALSE(packed_other.empty());
  EXPECT_EQ(*Unpacked(packed_other), BytesOf(other));
}

// The sizes that it declares are checked before memory is asked for.
TEST(SectionPackingTest, AShortSectionThatSaysItIsLongIsRefused) {
  std::string packed = PackRecords(SomeRecords(1000), kSomeFields);
  for (const uint64_t bytes : {uint64_t{1} << 21, ~uint64_t{0}}) {
    std::memcpy(packed.data(), &bytes, sizeof(bytes));
    EXPECT_TRUE(absl::IsDataLoss(UnpackedBytes(packed).status())) << bytes;
  }
  // Nothing that is packed is refused later: zeros shrink by more than that.
  const std::string zeros(8u << 20, '\0');
  EXPECT_EQ(PackRecords(zeros, {{.width = 1, .is_delta = false}}), "");
  const std::string few(1u << 20, '\0');
  const std::string packed_few =
      PackRecords(few, {{.width = 1, .is_delta = false}});
  EXPECT_LT(packed_few.size(), 200u);
  EXPECT_EQ(*Unpacked(packed_few), few);
}

TEST(SectionPackingTest, DamagedSectionsAreRefusedOrAreNodesAndRecords) {
  for (const std::string& good : {PackRecords(SomeRecords(300), kSomeFields),
                                  PackNodes(BytesOf(SomeTrees()))}) {
    ASSERT_FALSE(good.empty());
    for (size_t length = 0; length < good.size(); ++length) {
      EXPECT_FALSE(Unpacked(good.substr(0, length)).ok()) << length;
    }
    EXPECT_FALSE(Unpacked(good + "x").ok());
    for (size_t i = 0; i < good.size(); ++i) {
      for (const int bit : {0, 3, 7}) {
        std::string bad = good;
        bad[i] = static_cast<char>(bad[i] ^ (1 << bit));
        const absl::StatusOr<std::string> out = Unpacked(bad);
        if (!out.ok()) {
          EXPECT_TRUE(absl::IsDataLoss(out.status())) << i << out.status();
        }
      }
    }
  }
}

TEST(SectionPackingTest, TreesThatDoNotEndAreRefused) {
  // Splits alone: each waits for a child.
  const std::vector<Node> nodes(64, Node::Split({1, 2, 0, 1}, 5, 2));
  EXPECT_NE(PackNodes(BytesOf(nodes)), "");  // as records
  std::string packed = PackNodes(BytesOf(SomeTrees()));
  uint64_t length = 0;
  std::memcpy(&length, packed.data() + 16, sizeof(length));
  // The first column says which nodes are leaves; it is stored as it is.
  const size_t last = 16 + sizeof(length) + length - 1;
  packed[last] = '\0';
  EXPECT_TRUE(absl::IsDataLoss(Unpacked(packed).status()));
}

}  // namespace
}  // namespace treeline::forest

#include "server/core/forest/model_memory.h"

#include <cstdint>
#include <limits>
#include <utility>

#include "gtest/gtest.h"

namespace treeline::forest {
namespace {

TEST(ModelMemory, HoldsWhatIsWrittenUntilItIsSealed) {
  auto memory = ModelMemory::Allocate(5000);
  ASSERT_TRUE(memory.ok()) << memory.status();
  ASSERT_EQ(memory->writable().size(), 5000u);
  memory->writable()[4999] = 7;
  memory->Seal();
  EXPECT_EQ(memory->bytes()[4999], 7);
  EXPECT_EQ(memory->bytes()[0], 0);
}

TEST(ModelMemory, SectionsCanBeAlignedInIt) {
  const auto memory = ModelMemory::Allocate(64);
  ASSERT_TRUE(memory.ok()) << memory.status();
  EXPECT_EQ(reinterpret_cast<uintptr_t>(memory->bytes().data()) % 4096, 0u);
}

TEST(ModelMemory, MovesWithItsBytes) {
  auto memory = ModelMemory::Allocate(3);
  ASSERT_TRUE(memory.ok()) << memory.status();
  memory->writable()[1] = 9;
  ModelMemory moved(std::move(*memory));
  ModelMemory assigned;
  assigned = std::move(moved);
  EXPECT_EQ(assigned.bytes()[1], 9);
}

TEST(ModelMemory, NoBytesNeedNoMemory) {
  auto memory = ModelMemory::Allocate(0);
  ASSERT_TRUE(memory.ok()) << memory.status();
  memory->Seal();
  EXPECT_TRUE(memory->bytes().empty());
}

TEST(ModelMemory, WhatTheSystemDoesNotHaveIsRefused) {
  EXPECT_TRUE(absl::IsResourceExhausted(
      ModelMemory::Allocate(std::numeric_limits<uint64_t>::max() / 2)
          .status()));
}

}  // namespace
}  // namespace treeline::forest

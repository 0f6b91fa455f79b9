#include "common/base/disjoint_sets.h"

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

TEST(DisjointSets, AreOneEachAtFirst) {
  DisjointSets sets(3);
  for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(sets.Find(i), i);
}

TEST(DisjointSets, AreNamedByTheirLeastNumberWhateverTheOrder) {
  DisjointSets up(6);
  up.Join(1, 3);
  up.Join(3, 5);
  DisjointSets down(6);
  down.Join(5, 3);
  down.Join(3, 1);
  for (DisjointSets* sets : {&up, &down}) {
    for (uint32_t i : {1u, 3u, 5u}) EXPECT_EQ(sets->Find(i), 1u);
    for (uint32_t i : {0u, 2u, 4u}) EXPECT_EQ(sets->Find(i), i);
  }
}

TEST(DisjointSets, JoinWhatIsJoinedAlready) {
  DisjointSets sets(4);
  sets.Join(0, 1);
  sets.Join(2, 3);
  sets.Join(1, 3);
  sets.Join(3, 0);
  sets.Join(2, 2);
  for (uint32_t i = 0; i < 4; ++i) EXPECT_EQ(sets.Find(i), 0u);
}

}  // namespace
}  // namespace treeline::base

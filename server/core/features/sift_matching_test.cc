#include "server/core/features/sift_matching.h"

#include <algorithm>
#include <vector>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

std::vector<SiftDescriptor> RandomDescriptors(size_t count,
                                              base::Random& random) {
  std::vector<SiftDescriptor> descriptors(count);
  for (SiftDescriptor& d : descriptors) {
    for (uint8_t& v : d.values) v = static_cast<uint8_t>(random.NextBelow(256));
  }
  return descriptors;
}

int32_t SquaredDistance(const SiftDescriptor& a, const SiftDescriptor& b) {
  int32_t sum = 0;
  for (size_t i = 0; i < a.values.size(); ++i) {
    const int32_t difference = a.values[i] - b.values[i];
    sum += difference * difference;
  }
  return sum;
}

SiftDescriptorView ViewOf(const std::vector<SiftDescriptor>& descriptors) {
  return {.data = descriptors[0].values.data(), .size = descriptors.size()};
}

TEST(FindNearestSiftTest, FindsTheNearestAndTheSecondDistance) {
  base::Random random(1, 0);
  const std::vector<SiftDescriptor> queries = RandomDescriptors(23, random);
  const std::vector<SiftDescriptor> known = RandomDescriptors(57, random);
  std::vector<NearestSift> nearest(queries.size());
  FindNearestSift(queries, ViewOf(known), nearest);
  for (size_t q = 0; q < queries.size(); ++q) {
    std::vector<int32_t> distances;
    for (const SiftDescriptor& d : known) {
      distances.push_back(SquaredDistance(queries[q], d));
    }
    EXPECT_EQ(distances[nearest[q].index], nearest[q].squared_distance);
    std::ranges::sort(distances);
    EXPECT_EQ(nearest[q].squared_distance, distances[0]);
    EXPECT_EQ(nearest[q].second_squared_distance, distances[1]);
  }
}

TEST(FindNearestSiftTest, AllVectorInstructionsFindTheSame) {
  base::Random random(2, 0);
  const std::vector<SiftDescriptor> queries = RandomDescriptors(9, random);
  base::WithEachVectorTarget([&] {
    for (const size_t size : {1u, 2u, 15u, 16u, 17u, 50u}) {
      std::vector<SiftDescriptor> known = RandomDescriptors(size, random);
      // One that is there twice: the first counts, the second is as near.
      known.back() = known.front();
      std::vector<NearestSift> nearest(queries.size());
      FindNearestSift(queries, ViewOf(known), nearest);
      for (size_t q = 0; q < queries.size(); ++q) {
        NearestSift expected;
        for (uint32_t i = 0; i < size; ++i) {
          const int32_t distance = SquaredDistance(queries[q], known[i]);
          if (distance < expected.squared_distance) {
            expected = {i, distance, expected.squared_distance};
          } else if (distance < expected.second_squared_distance) {
            expected.second_squared_distance = distance;
          }
        }
        EXPECT_EQ(nearest[q].index, expected.index);
        EXPECT_EQ(nearest[q].squared_distance, expected.squared_distance);
        EXPECT_EQ(nearest[q].second_squared_distance,
                  expected.second_squared_distance);
      }
    }
  });
}

TEST(FindNearestSiftTest, DistancesDoNotOverflow) {
  std::vector<SiftDescriptor> query(1);
  std::vector<SiftDescriptor> known(1);
  known[0].values.fill(255);
  std::vector<NearestSift> nearest(1);
  FindNearestSift(query, ViewOf(known), nearest);
  EXPECT_EQ(nearest[0].squared_distance, 128 * 255 * 255);
  EXPECT_EQ(nearest[0].second_squared_distance, INT32_MAX);
}

TEST(FindNearestSiftTest, TiesGoToTheFirst) {
  std::vector<SiftDescriptor> query(1);
  const std::vector<SiftDescriptor> known(3);
  std::vector<NearestSift> nearest(1);
  FindNearestSift(query, ViewOf(known), nearest);
  EXPECT_EQ(nearest[0].index, 0u);
  EXPECT_EQ(nearest[0].second_squared_distance, 0);
}

}  // namespace
}  // namespace treeline::features

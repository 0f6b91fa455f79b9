// Nearest neighbours among SIFT descriptors, by brute force.
#ifndef SERVER_CORE_FEATURES_SIFT_MATCHING_H_
#define SERVER_CORE_FEATURES_SIFT_MATCHING_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "server/core/features/sift_descriptor.h"

namespace treeline::features {

// Descriptors inside records: descriptor i begins at data + i * stride_bytes.
struct SiftDescriptorView {
  const uint8_t* data = nullptr;
  size_t stride_bytes = sizeof(SiftDescriptor);
  size_t size = 0;
};

struct NearestSift {
  uint32_t index = 0;
  // Squared distances to it and to the second nearest; INT32_MAX where there
  // is none.
  int32_t squared_distance = INT32_MAX;
  int32_t second_squared_distance = INT32_MAX;
};

// For query i the nearest reference in nearest[i]; ties go to the lower index.
// queries and nearest have the same size.
void FindNearestSift(std::span<const SiftDescriptor> queries,
                     const SiftDescriptorView& references,
                     std::span<NearestSift> nearest);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SIFT_MATCHING_H_

// Choosing the few best of many.
#ifndef SERVER_CORE_KEYFRAMES_LEAST_FIRST_H_
#define SERVER_CORE_KEYFRAMES_LEAST_FIRST_H_

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace treeline::keyframes {

// The indices (second) of the up to `count` least values (first), least first;
// of equal ones those of lower index.
template <typename Value>
std::vector<size_t> LeastFirst(std::vector<std::pair<Value, size_t>> values,
                               size_t count) {
  count = std::min(count, values.size());
  std::partial_sort(values.begin(),
                    values.begin() + static_cast<std::ptrdiff_t>(count),
                    values.end());
  std::vector<size_t> indices;
  indices.reserve(count);
  for (size_t i = 0; i < count; ++i) indices.push_back(values[i].second);
  return indices;
}

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_LEAST_FIRST_H_

// Data parallelism with results that do not depend on the thread count: slot
// i of the output belongs to index i, whichever thread computes it.
#ifndef COMMON_BASE_PARALLEL_FOR_H_
#define COMMON_BASE_PARALLEL_FOR_H_

#include <cstdint>
#include <functional>

namespace treeline::base {

// Calls body(i) for every i in [0, count) on up to `threads` threads, the
// calling one included. Indices are handed out one at a time in ascending
// order. Returns when all calls have returned. body must not throw.
// threads < 1 means HardwareThreads().
void ParallelFor(int64_t count, int threads,
                 const std::function<void(int64_t)>& body);

// The processors this process may run on, at least 1.
int HardwareThreads();

}  // namespace treeline::base

#endif  // COMMON_BASE_PARALLEL_FOR_H_

// True poses of recorded frames.
#ifndef CLIENT_BENCH_TRUTH_FILE_H_
#define CLIENT_BENCH_TRUTH_FILE_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"

namespace treeline::bench {

// The pose in ROOT/STEM.pose.txt as 7-Scenes and `treeline synth record` write
// it: the 16 numbers of the matrix world_from_camera (m), row by row. nullopt:
// there is no such file, or no pose in it (NaN). INVALID_ARGUMENT: something
// else is in it.
absl::StatusOr<std::optional<geometry::Rigid3>> ReadTruth(
    const std::string& root, const std::string& stem);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_TRUTH_FILE_H_

// The samples of frames, on disk, for when they are needed again.
#ifndef SERVER_CORE_TRAINING_SAMPLE_MEMORY_H_
#define SERVER_CORE_TRAINING_SAMPLE_MEMORY_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/descriptor.h"
#include "server/core/training/leaf_filler.h"

namespace treeline::training {

// A file without a name: it is gone with whoever has opened it, however that
// ends. 80 bytes a sample. Reading is thread-safe, adding is not.
class SampleMemory {
 public:
  // UNAVAILABLE if `folder` takes no file.
  static absl::StatusOr<std::unique_ptr<SampleMemory>> Open(
      const std::string& folder);

  // What one frame sends down each tree. UNAVAILABLE: there is no room; then
  // what was added before is still there.
  absl::Status Add(std::span<const RoutedSamples> by_tree);
  // Frames that were added.
  size_t size() const { return frames_.size(); }
  // Of the i-th of them. DATA_LOSS: the file has not what was written.
  absl::StatusOr<RoutedSamples> Read(size_t i, int tree) const;

 private:
  // Where the samples of one tree lie.
  struct Place {
    int64_t offset = 0;
    size_t samples = 0;
  };

  explicit SampleMemory(int file) : file_(file) {}

  const base::Descriptor file_;
  int64_t end_ = 0;
  std::vector<std::vector<Place>> frames_;  // by frame and tree
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SAMPLE_MEMORY_H_

#include "server/core/training/training_options.h"

#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::training {

absl::Status TrainingOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("threads", threads, 0, 1024));
  TL_RETURN_IF_ERROR(base::CheckRange("trees", trees, 1, 64));
  TL_RETURN_IF_ERROR(
      base::CheckRange("frames per tree", frames_per_tree, 1, 65535));
  TL_RETURN_IF_ERROR(
      base::CheckRange("samples per frame", samples_per_frame, 1, 20000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("balanced levels", balanced_levels, 0, 40));
  TL_RETURN_IF_ERROR(base::CheckRange("maximum depth", max_depth, 1, 40));
  TL_RETURN_IF_ERROR(
      base::CheckRange("minimum leaf samples", min_leaf_samples, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("minimum kept samples", min_kept_samples, 0, 1000));
  TL_RETURN_IF_ERROR(base::CheckRange("minimum spread", min_spread_m, 0, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("split candidates", split_candidates, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("maximum offset", max_offset_px_m, 1, 127));
  TL_RETURN_IF_ERROR(
      base::CheckRange("mode bandwidth", mode_bandwidth_m, 0, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("maximum split samples", max_split_samples, 10, 60000));
  return base::CheckRange("image memory",
                          static_cast<double>(image_memory_bytes), 1, 1e15);
}

}  // namespace treeline::training

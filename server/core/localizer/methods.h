// The methods that a model may name, as policies of the pipeline.
#ifndef SERVER_CORE_LOCALIZER_METHODS_H_
#define SERVER_CORE_LOCALIZER_METHODS_H_

#include "absl/status/statusor.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/pipeline.h"
#include "server/core/localizer/query_options.h"

namespace treeline::localizer {

// The method of `model`, which must outlive it; docs/explanation/methods.md
// describes them.
//
//   method        steps, in order              depth     verified by
//   rgbd          points with depth            required  keyframes
//   points-lines  points and lines with depth  required  keyframes
//   rgb           rays                         ignored   keyframes
//   hybrid        features of the keyframes     ignored   keyframes
//                 where the pose is expected
//                 (a shortcut), rays (a
//                 fallback), features of the
//                 keyframes near their pose, of
//                 those most like the frame
//   universal     points with depth, features   where     keyframes
//                 of the keyframes where the    given
//                 pose is expected (a
//                 shortcut), of those most like
//                 the frame, of those near their
//                 pose: each only where the
//                 earlier do not suffice
//   sift          SIFT features                ignored   inliers alone
//
// DATA_LOSS for a model that lacks what its method needs, or with corrupt
// keyframes; UNIMPLEMENTED for a method that is not known.
absl::StatusOr<Method> MakeMethod(const forest::ModelFile& model,
                                  const QueryOptions& options);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_METHODS_H_

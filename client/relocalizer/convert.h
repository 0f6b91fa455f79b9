// Proto <-> the client's own types.
#ifndef CLIENT_RELOCALIZER_CONVERT_H_
#define CLIENT_RELOCALIZER_CONVERT_H_

#include "absl/status/statusor.h"
#include "client/relocalizer/relocalizer.h"
#include "common/wire/camera.h"
#include "common/wire/frame.h"
#include "common/wire/geometry.h"
#include "treeline/v1/relocalization.pb.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::relocalizer {

using wire::FromProto;
using wire::ToProto;

v1::LocalizeRequest ToProto(const LocalizeQuery& query);

// INTERNAL: the server breaks the contract (localized without a pose or with a
// covariance that is none, an outcome that this client does not know).
absl::StatusOr<LocalizeAnswer> FromProto(const v1::LocalizeResponse& response);
absl::StatusOr<SceneDescription> FromProto(const v1::SceneInfo& info);

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_CONVERT_H_

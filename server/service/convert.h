// The server's own types -> proto. What only needs common types is in
// common/wire.
#ifndef SERVER_SERVICE_CONVERT_H_
#define SERVER_SERVICE_CONVERT_H_

#include "common/wire/camera.h"
#include "common/wire/geometry.h"
#include "server/core/forest/model_info.h"
#include "server/core/localizer/localizer.h"
#include "server/core/recognition/localize_among.h"
#include "server/repository/scene.h"
#include "server/service/call_observer.h"
#include "treeline/v1/relocalization.pb.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::service {

using wire::ToProto;

v1::Outcome ToProto(localizer::Outcome outcome);
v1::NotLocalizedReason ToProto(localizer::NotLocalizedReason reason);
v1::Timings ToProto(const CallTimings& timings);

// All of the answer but for scene, version and timings. Pose and covariance
// are left out unless the frame was localized: there is no pose to misuse.
v1::LocalizeResponse ToProto(const localizer::PoseEstimate& estimate,
                             camera::RgbdSensor pose_sensor);

v1::SceneCandidate ToProto(const recognition::ConsideredScene& scene);
v1::SceneState ToProto(repository::SceneState state);
v1::ModelInfo ToProto(const forest::ModelInfo& info);
v1::GeoAnchor ToProto(const repository::GeoAnchor& anchor);
v1::SceneInfo ToProto(const repository::SceneStatus& status);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_CONVERT_H_

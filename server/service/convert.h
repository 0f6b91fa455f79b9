// The server's own types -> proto. What only needs common types is in
// common/wire.
#ifndef SERVER_SERVICE_CONVERT_H_
#define SERVER_SERVICE_CONVERT_H_

#include "server/core/forest/model_info.h"
#include "server/core/localizer/localizer.h"
#include "server/repository/scene.h"
#include "server/service/call_observer.h"
#include "treeline/v1/relocalization.pb.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline {

v1::Outcome ToProto(Outcome outcome);
v1::NotLocalizedReason ToProto(NotLocalizedReason reason);
v1::Timings ToProto(const CallTimings& timings);

// All of the answer but for scene, version and timings. Pose and covariance
// are left out unless the frame was localized: there is no pose to misuse.
v1::LocalizeResponse ToProto(const PoseEstimate& estimate,
                             RgbdSensor pose_sensor);

v1::SceneCandidate ToProto(const ConsideredScene& scene);
v1::SceneState ToProto(SceneState state);
v1::ModelInfo ToProto(const ModelInfo& info);
v1::GeoAnchor ToProto(const GeoAnchor& anchor);
v1::SceneInfo ToProto(const SceneStatus& status);

}  // namespace treeline

#endif  // SERVER_SERVICE_CONVERT_H_

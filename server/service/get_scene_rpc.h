// SceneService.GetScene, without gRPC around it.
#ifndef SERVER_SERVICE_GET_SCENE_RPC_H_
#define SERVER_SERVICE_GET_SCENE_RPC_H_

#include "absl/status/statusor.h"
#include "server/repository/scene_repository.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline {

// INVALID_ARGUMENT: not a scene name. NOT_FOUND: no such scene.
absl::StatusOr<v1::GetSceneResponse> GetScene(
    const SceneRepository& repository, const v1::GetSceneRequest& request);

}  // namespace treeline

#endif  // SERVER_SERVICE_GET_SCENE_RPC_H_

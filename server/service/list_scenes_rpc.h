// SceneService.ListScenes, without gRPC around it.
#ifndef SERVER_SERVICE_LIST_SCENES_RPC_H_
#define SERVER_SERVICE_LIST_SCENES_RPC_H_

#include "server/repository/scene_repository.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline {

v1::ListScenesResponse ListScenes(const SceneRepository& repository);

}  // namespace treeline

#endif  // SERVER_SERVICE_LIST_SCENES_RPC_H_

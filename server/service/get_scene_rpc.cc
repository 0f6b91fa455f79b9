#include "server/service/get_scene_rpc.h"

#include "common/base/status_macros.h"
#include "server/service/convert.h"

namespace treeline {

absl::StatusOr<v1::GetSceneResponse> GetScene(
    const SceneRepository& repository, const v1::GetSceneRequest& request) {
  TL_ASSIGN_OR_RETURN(const SceneStatus status,
                      repository.Get(request.scene()));
  v1::GetSceneResponse response;
  *response.mutable_scene() = ToProto(status);
  return response;
}

}  // namespace treeline

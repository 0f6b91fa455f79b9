#include "server/service/list_scenes_rpc.h"

#include "server/service/convert.h"

namespace treeline {

v1::ListScenesResponse ListScenes(const SceneRepository& repository) {
  v1::ListScenesResponse response;
  for (const SceneStatus& status : repository.List()) {
    *response.add_scenes() = ToProto(status);
  }
  return response;
}

}  // namespace treeline

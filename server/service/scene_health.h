// grpc.health.v1 of the scenes.
#ifndef SERVER_SERVICE_SCENE_HEALTH_H_
#define SERVER_SERVICE_SCENE_HEALTH_H_

#include <map>
#include <string>
#include <thread>

#include "server/repository/scene_repository.h"
#include "server/service/health_service.h"

namespace treeline::service {

// Tells the health service about every scene, twice a second, from
// construction to destruction. Scenes that are gone become NOT_SERVING.
class SceneHealth {
 public:
  SceneHealth(const repository::SceneRepository& repository,
              HealthGrpcService& health);

 private:
  void Update();

  const repository::SceneRepository& repository_;
  HealthGrpcService& health_;
  // What was told; of the thread.
  std::map<std::string, bool> told_;
  std::jthread thread_;
};

// "treeline.scene.kitchen".
std::string HealthServiceOf(const std::string& scene);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_SCENE_HEALTH_H_

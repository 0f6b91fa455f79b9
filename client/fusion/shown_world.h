// The world_from_device that content is drawn with: it follows what is known
// without steps that people see.
#ifndef CLIENT_FUSION_SHOWN_WORLD_H_
#define CLIENT_FUSION_SHOWN_WORLD_H_

#include <optional>

#include "client/fusion/drift_options.h"
#include "common/geometry/rigid3.h"

namespace treeline::drift {

class ShownWorld {
 public:
  // `options` outlives this.
  explicit ShownWorld(const DriftOptions& options) : options_(options) {}

  // nullopt: nothing is shown.
  const std::optional<geometry::Rigid3>& world_from_device() const {
    return world_from_device_;
  }

  void Clear() { world_from_device_.reset(); }

  // One step of `passed_s` towards `world_from_camera`, which is where the
  // camera at `device_from_camera` is known to be. The motion is measured where
  // people see it: at the camera. Returns whether it snapped.
  bool Step(const geometry::Rigid3& world_from_camera,
            const geometry::Rigid3& device_from_camera, double passed_s);

 private:
  const DriftOptions& options_;
  std::optional<geometry::Rigid3> world_from_device_;
};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_SHOWN_WORLD_H_

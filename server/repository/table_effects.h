// What a decision of the table leaves to be done when its lock has been let go.
#ifndef SERVER_REPOSITORY_TABLE_EFFECTS_H_
#define SERVER_REPOSITORY_TABLE_EFFECTS_H_

#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "server/repository/repository_event.h"
#include "server/repository/scene.h"

namespace treeline::repository {

using SceneAnswer = absl::StatusOr<std::shared_ptr<const Scene>>;
using AcquireDone = std::function<void(SceneAnswer)>;

struct TableEffects {
  // Let go; their memory is free when they are destroyed, unless a query still
  // has them.
  std::vector<std::shared_ptr<const Scene>> released;
  std::vector<RepositoryEvent> events;
  std::vector<std::function<void()>> answers;

  bool empty() const {
    return released.empty() && events.empty() && answers.empty();
  }
  // `done` will be called with `answer`, which is moved on, so that nobody but
  // the one who asked holds the scene.
  void Answer(AcquireDone done, SceneAnswer answer) {
    answers.push_back(
        [done = std::move(done), answer = std::move(answer)]() mutable {
          done(std::move(answer));
        });
  }
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_TABLE_EFFECTS_H_

// What the localizers on pixel-difference forests share: working memory of a
// query, and scene coordinates from the forest.
#ifndef SERVER_CORE_LOCALIZER_FOREST_QUERY_H_
#define SERVER_CORE_LOCALIZER_FOREST_QUERY_H_

#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/image/frame.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/forest/backtracking.h"
#include "server/core/localizer/query_options.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::localizer {

// Objects that one query uses and the next one uses again.
template <typename T>
class Pool {
 public:
  // Borrows one for as long as it lives.
  class Lease {
   public:
    explicit Lease(Pool& pool) : pool_(pool) {
      {
        absl::MutexLock lock(&pool_.mutex_);
        if (!pool_.idle_.empty()) {
          object_ = std::move(pool_.idle_.back());
          pool_.idle_.pop_back();
        }
      }
      if (object_ == nullptr) object_ = std::make_unique<T>();
    }
    ~Lease() {
      absl::MutexLock lock(&pool_.mutex_);
      pool_.idle_.push_back(std::move(object_));
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    T& operator*() { return *object_; }
    T* operator->() { return object_.get(); }

   private:
    Pool& pool_;
    std::unique_ptr<T> object_;
  };

 private:
  absl::Mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_ ABSL_GUARDED_BY(mutex_);
};

// Working memory of one query.
struct ForestScratch {
  features::PlanarImage image;
  features::GrayPyramid pyramid;
  features::RgbdSamples samples;
  std::vector<features::WhtDescriptor> descriptors;
  forest::BacktrackingScratch backtracking;
  std::vector<forest::LeafMatch> matches;
};

// INVALID_ARGUMENT unless the colour image has the size of its camera.
absl::Status CheckColor(const image::Frame& frame,
                        const camera::Camera& camera);
// INVALID_ARGUMENT unless the frame has depth, of the size of its camera.
absl::Status CheckDepth(const image::Frame& frame, const camera::Camera& camera,
                        absl::string_view method);

// The next samples to predict for: those after the first `begin`, up to
// options.first_samples of them at first, and all that are left then.
struct SampleBatch {
  size_t begin = 0;
  size_t end = 0;
};
SampleBatch NextBatch(const QueryOptions& options, size_t begin,
                      size_t samples);

// Whether so many inliers settle a pose, so that no more samples are needed.
bool IsSettled(const QueryOptions& options, int inliers);

// Appends the scene coordinates that `forest` predicts at samples [begin, end)
// of scratch.samples in scratch.image, for each sample the best match of every
// tree, nearest descriptor first; leaf covariances are widened for leaves of
// few samples. CANCELLED after `stop`.
absl::Status PredictScene(const forest::ForestView& forest,
                          const QueryOptions& options, const SampleBatch& batch,
                          const std::stop_token& stop, ForestScratch& scratch,
                          std::vector<pose::ScenePrediction>& predictions);

// A leaf's mode as a prediction.
pose::ScenePrediction PredictionOf(const forest::ForestView& forest,
                                   uint32_t mode);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_FOREST_QUERY_H_

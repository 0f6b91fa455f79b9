// Objects that one query uses and the next one uses again.
#ifndef SERVER_CORE_LOCALIZER_POOL_H_
#define SERVER_CORE_LOCALIZER_POOL_H_

#include <memory>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace treeline::localizer {

// Thread-safe. Must outlive its leases.
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

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POOL_H_

// Tells ThreadSanitizer about Abseil's locks.
//
// Debian's Abseil is built without ThreadSanitizer, so that what its locks
// order looks like a race. The preset `tsan` links every program with --wrap
// for the functions that are named below: each calls the real one and says what
// it orders. cmake/TreelineThreadSanitizer.cmake reads their names from here.
//
// Whoever gives a lock away looks, inside of the real function, whether the
// conditions hold that others wait for (Mutex::Await and its like). It holds
// the lock meanwhile, but has said already that it does not: such reads are not
// looked at.
#include <sanitizer/tsan_interface.h>

#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

extern "C" void AnnotateIgnoreReadsBegin(const char* file, int line);
extern "C" void AnnotateIgnoreReadsEnd(const char* file, int line);

namespace {

// Inside of a function that gives a lock away.
class Releasing {
 public:
  explicit Releasing(void* lock) {
    __tsan_release(lock);
    AnnotateIgnoreReadsBegin(__FILE__, __LINE__);
  }
  Releasing(const Releasing&) = delete;
  Releasing& operator=(const Releasing&) = delete;
  ~Releasing() { AnnotateIgnoreReadsEnd(__FILE__, __LINE__); }
};

// Inside of one that takes a lock, whether or not in the end.
class Taking {
 public:
  explicit Taking(void* lock) : lock_(lock) {
    AnnotateIgnoreReadsBegin(__FILE__, __LINE__);
  }
  Taking(const Taking&) = delete;
  Taking& operator=(const Taking&) = delete;
  ~Taking() {
    AnnotateIgnoreReadsEnd(__FILE__, __LINE__);
    __tsan_acquire(lock_);
  }

 private:
  void* const lock_;
};

// Inside of one that gives it away, waits, and takes it again.
class Waiting {
 public:
  explicit Waiting(void* lock) : releasing_(lock), taking_(lock) {}

 private:
  const Releasing releasing_;
  const Taking taking_;
};

}  // namespace

// NOLINTBEGIN: names are the mangled ones that the linker wraps.

#define WRAP(scope, lock, result, name, parameters, arguments) \
  extern "C" result __real_##name parameters;                  \
  extern "C" result __wrap_##name parameters {                 \
    const scope inside(lock);                                  \
    return __real_##name arguments;                            \
  }
#define WRAP_LOCK(name) WRAP(Taking, self, void, name, (void* self), (self))
#define WRAP_UNLOCK(name) \
  WRAP(Releasing, self, void, name, (void* self), (self))
#define WRAP_WHEN(scope, name) \
  WRAP(scope, self, void, name, (void* self, void* when), (self, when))
#define WRAP_WHEN_UNTIL(scope, name, type)                            \
  WRAP(scope, self, bool, name, (void* self, void* when, type until), \
       (self, when, until))

WRAP_LOCK(_ZN4absl7debian35Mutex4LockEv)
WRAP_LOCK(_ZN4absl7debian35Mutex10ReaderLockEv)
WRAP_UNLOCK(_ZN4absl7debian35Mutex6UnlockEv)
WRAP_UNLOCK(_ZN4absl7debian35Mutex12ReaderUnlockEv)

// (Reader)LockWhen, ...WithTimeout, ...WithDeadline: held in the end, also if
// the condition is not true.
WRAP_WHEN(Taking, _ZN4absl7debian35Mutex8LockWhenERKNS0_9ConditionE)
WRAP_WHEN(Taking, _ZN4absl7debian35Mutex14ReaderLockWhenERKNS0_9ConditionE)
WRAP_WHEN_UNTIL(
    Taking,
    _ZN4absl7debian35Mutex19LockWhenWithTimeoutERKNS0_9ConditionENS0_8DurationE,
    absl::Duration)
WRAP_WHEN_UNTIL(
    Taking,
    _ZN4absl7debian35Mutex20LockWhenWithDeadlineERKNS0_9ConditionENS0_4TimeE,
    absl::Time)
WRAP_WHEN_UNTIL(
    Taking,
    _ZN4absl7debian35Mutex25ReaderLockWhenWithTimeoutERKNS0_9ConditionENS0_8DurationE,
    absl::Duration)
WRAP_WHEN_UNTIL(
    Taking,
    _ZN4absl7debian35Mutex26ReaderLockWhenWithDeadlineERKNS0_9ConditionENS0_4TimeE,
    absl::Time)

// Await, ...WithTimeout, ...WithDeadline.
WRAP_WHEN(Waiting, _ZN4absl7debian35Mutex5AwaitERKNS0_9ConditionE)
WRAP_WHEN_UNTIL(
    Waiting,
    _ZN4absl7debian35Mutex16AwaitWithTimeoutERKNS0_9ConditionENS0_8DurationE,
    absl::Duration)
WRAP_WHEN_UNTIL(
    Waiting,
    _ZN4absl7debian35Mutex17AwaitWithDeadlineERKNS0_9ConditionENS0_4TimeE,
    absl::Time)

// CondVar::Wait, WaitWithTimeout, WaitWithDeadline.
WRAP(Waiting, lock, void, _ZN4absl7debian37CondVar4WaitEPNS0_5MutexE,
     (void* self, void* lock), (self, lock))
WRAP(Waiting, lock, bool,
     _ZN4absl7debian37CondVar15WaitWithTimeoutEPNS0_5MutexENS0_8DurationE,
     (void* self, void* lock, absl::Duration until), (self, lock, until))
WRAP(Waiting, lock, bool,
     _ZN4absl7debian37CondVar16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE,
     (void* self, void* lock, absl::Time until), (self, lock, until))

#define WRAP_TRY(name)                         \
  extern "C" bool __real_##name(void*);        \
  extern "C" bool __wrap_##name(void* self) {  \
    const bool is_taken = __real_##name(self); \
    if (is_taken) __tsan_acquire(self);        \
    return is_taken;                           \
  }
WRAP_TRY(_ZN4absl7debian35Mutex7TryLockEv)
WRAP_TRY(_ZN4absl7debian35Mutex13ReaderTryLockEv)

// What was done before Notify is seen by whoever knows of it: by waiting, or by
// looking at the flag, which stands behind the notification's mutex.
WRAP_LOCK(_ZNK4absl7debian312Notification19WaitForNotificationEv)
WRAP(
    Taking, self, bool,
    _ZNK4absl7debian312Notification30WaitForNotificationWithTimeoutENS0_8DurationE,
    (void* self, absl::Duration until), (self, until))
WRAP(
    Taking, self, bool,
    _ZNK4absl7debian312Notification31WaitForNotificationWithDeadlineENS0_4TimeE,
    (void* self, absl::Time until), (self, until))
WRAP_TRY(_ZN4absl7debian312Notification23HasBeenNotifiedInternalEPKSt6atomicIbE)
extern "C" void __real__ZN4absl7debian312Notification6NotifyEv(void*);
extern "C" void __wrap__ZN4absl7debian312Notification6NotifyEv(void* self) {
  __tsan_release(static_cast<char*>(self) + sizeof(absl::Mutex));
  const Releasing inside(self);
  __real__ZN4absl7debian312Notification6NotifyEv(self);
}

WRAP_LOCK(_ZN4absl7debian315BlockingCounter4WaitEv)
WRAP(Releasing, self, bool, _ZN4absl7debian315BlockingCounter14DecrementCountEv,
     (void* self), (self))

// NOLINTEND

// What other libraries do inside is out of our sight as well: their calls of
// malloc, memcpy and so on are not looked at, and neither is what gRPC orders
// between its own threads and ours.
extern "C" const char* __tsan_default_options() {
  return "ignore_noninstrumented_modules=1";
}

extern "C" const char* __tsan_default_suppressions() {
  return "race:grpc::\n"
         "race:grpc_core::\n";
}

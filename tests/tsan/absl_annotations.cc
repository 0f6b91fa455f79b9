// Tells ThreadSanitizer about Abseil's locks.
//
// Debian's Abseil is built without ThreadSanitizer, so that what its locks
// order looks like a race. The preset `tsan` links every program with --wrap
// for the functions below: each calls the real one and says what it orders.
// Condition critical sections (Mutex::Await and its like) are not covered: use
// CondVar where such a program is to be checked.
#include <sanitizer/tsan_interface.h>

// NOLINTBEGIN: names are the mangled ones that the linker wraps.

#define WRAP_LOCK(name)                       \
  extern "C" void __real_##name(void*);       \
  extern "C" void __wrap_##name(void* self) { \
    __real_##name(self);                      \
    __tsan_acquire(self);                     \
  }

#define WRAP_UNLOCK(name)                     \
  extern "C" void __real_##name(void*);       \
  extern "C" void __wrap_##name(void* self) { \
    __tsan_release(self);                     \
    __real_##name(self);                      \
  }

WRAP_LOCK(_ZN4absl7debian35Mutex4LockEv)
WRAP_LOCK(_ZN4absl7debian35Mutex10ReaderLockEv)
WRAP_UNLOCK(_ZN4absl7debian35Mutex6UnlockEv)
WRAP_UNLOCK(_ZN4absl7debian35Mutex12ReaderUnlockEv)
WRAP_LOCK(_ZNK4absl7debian312Notification19WaitForNotificationEv)
WRAP_UNLOCK(_ZN4absl7debian312Notification6NotifyEv)
WRAP_LOCK(_ZN4absl7debian315BlockingCounter4WaitEv)

extern "C" bool __real__ZN4absl7debian35Mutex7TryLockEv(void*);
extern "C" bool __wrap__ZN4absl7debian35Mutex7TryLockEv(void* self) {
  const bool locked = __real__ZN4absl7debian35Mutex7TryLockEv(self);
  if (locked) __tsan_acquire(self);
  return locked;
}

extern "C" void __real__ZN4absl7debian37CondVar4WaitEPNS0_5MutexE(void*, void*);
extern "C" void __wrap__ZN4absl7debian37CondVar4WaitEPNS0_5MutexE(void* self,
                                                                  void* mutex) {
  __tsan_release(mutex);
  __real__ZN4absl7debian37CondVar4WaitEPNS0_5MutexE(self, mutex);
  __tsan_acquire(mutex);
}

extern "C" bool __real__ZN4absl7debian315BlockingCounter14DecrementCountEv(
    void*);
extern "C" bool __wrap__ZN4absl7debian315BlockingCounter14DecrementCountEv(
    void* self) {
  __tsan_release(self);
  return __real__ZN4absl7debian315BlockingCounter14DecrementCountEv(self);
}

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

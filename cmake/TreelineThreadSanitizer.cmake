# Debian's Abseil was not built for ThreadSanitizer: without help, every use of
# absl::Mutex looks like a race. See tests/tsan/absl_annotations.cc.
add_library(treeline_tsan STATIC
  ${CMAKE_SOURCE_DIR}/tests/tsan/absl_annotations.cc)
target_link_libraries(treeline_tsan PRIVATE absl::synchronization)

foreach(function IN ITEMS
    _ZN4absl7debian35Mutex4LockEv
    _ZN4absl7debian35Mutex6UnlockEv
    _ZN4absl7debian35Mutex7TryLockEv
    _ZN4absl7debian35Mutex10ReaderLockEv
    _ZN4absl7debian35Mutex12ReaderUnlockEv
    _ZN4absl7debian37CondVar4WaitEPNS0_5MutexE
    _ZN4absl7debian312Notification6NotifyEv
    _ZNK4absl7debian312Notification19WaitForNotificationEv
    _ZN4absl7debian315BlockingCounter14DecrementCountEv
    _ZN4absl7debian315BlockingCounter4WaitEv)
  target_link_options(treeline_options INTERFACE LINKER:--wrap=${function})
endforeach()
target_link_libraries(treeline_options INTERFACE treeline_tsan)

# Debian's Abseil was not built for ThreadSanitizer: without help, every use of
# absl::Mutex looks like a race. The source below stands for those of its
# functions that it names.
set(annotations ${CMAKE_SOURCE_DIR}/tests/tsan/absl_annotations.cc)
add_library(treeline_tsan STATIC ${annotations})
target_link_libraries(treeline_tsan PRIVATE absl::synchronization)

file(STRINGS ${annotations} lines REGEX "_ZNK?4absl")
string(REGEX MATCHALL "_ZNK?4absl[A-Za-z0-9_]+" functions "${lines}")
list(REMOVE_DUPLICATES functions)
foreach(function IN LISTS functions)
  target_link_options(treeline_options INTERFACE LINKER:--wrap=${function})
endforeach()
target_link_libraries(treeline_options INTERFACE treeline_tsan)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${annotations})

// The version of this software.
#ifndef COMMON_BASE_VERSION_H_
#define COMMON_BASE_VERSION_H_

namespace treeline {

// "0.1.0": the version of the top CMakeLists.txt.
const char* Version();

}  // namespace treeline

#endif  // COMMON_BASE_VERSION_H_

// The version of this software.
#ifndef COMMON_BASE_VERSION_H_
#define COMMON_BASE_VERSION_H_

namespace treeline::base {

// "0.1.0": the version of the top CMakeLists.txt.
const char* Version();

}  // namespace treeline::base

#endif  // COMMON_BASE_VERSION_H_

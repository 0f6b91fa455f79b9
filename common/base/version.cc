#include "common/base/version.h"

namespace treeline {

const char* Version() { return TREELINE_VERSION; }

}  // namespace treeline

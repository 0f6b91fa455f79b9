#include "common/base/version.h"

namespace treeline::base {

const char* Version() { return TREELINE_VERSION; }

}  // namespace treeline::base

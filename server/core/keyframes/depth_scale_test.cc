#include "server/core/keyframes/depth_scale.h"

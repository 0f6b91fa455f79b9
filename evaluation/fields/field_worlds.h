// Which worlds a name on the command line stands for.
#ifndef EVALUATION_FIELDS_FIELD_WORLDS_H_
#define EVALUATION_FIELDS_FIELD_WORLDS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace treeline::fields {

// A folder's files that are worlds (.world, .sdf, .yaml), world_2 before
// world_10; NOT_FOUND if there are none. Of anything else the name itself.
absl::StatusOr<std::vector<std::string>> WorldsCalled(const std::string& name);

}  // namespace treeline::fields

#endif  // EVALUATION_FIELDS_FIELD_WORLDS_H_

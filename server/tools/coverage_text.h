// Where a scene will work, in words and as JSON.
#ifndef SERVER_TOOLS_COVERAGE_TEXT_H_
#define SERVER_TOOLS_COVERAGE_TEXT_H_

#include <string>

#include "server/core/keyframes/coverage.h"
#include "server/tools/model_description.h"

namespace treeline::tools {

// The section of DescribeModel's kind.
DescriptionSection DescribeCoverage(const keyframes::CoverageMap& coverage);

// One JSON object with a trailing newline; docs/reference/coverage.md has its
// fields.
std::string CoverageJson(const keyframes::CoverageMap& coverage);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_COVERAGE_TEXT_H_

// Results frame by frame for spreadsheets and scripts.
#ifndef SERVER_TOOLS_EVALUATION_CSV_H_
#define SERVER_TOOLS_EVALUATION_CSV_H_

#include <string>
#include <vector>

#include "server/tools/evaluated_method.h"

namespace treeline {

// A header, then a line a frame and method (RFC 4180, lines end with \n):
// lengths in metres, angles in degrees, times in milliseconds. What is
// undefined, or not finite, is empty. A method that failed has no lines.
std::string EvaluationCsv(const std::vector<EvaluatedMethod>& methods);

}  // namespace treeline

#endif  // SERVER_TOOLS_EVALUATION_CSV_H_

// Files that others on the machine should not read.
#ifndef SERVER_ACCESS_SECRET_FILE_H_
#define SERVER_ACCESS_SECRET_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/access/trust_log.h"

namespace treeline::access {

// The bytes of a file, at most 1 MiB (errors of ReadFile). Warns if
// everyone on the machine may read it.
absl::StatusOr<std::string> ReadSecretFile(const std::string& path,
                                           const TrustLog& log);

// The warning of ReadSecretFile alone.
void WarnIfOthersMayRead(const std::string& path, const TrustLog& log);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_SECRET_FILE_H_

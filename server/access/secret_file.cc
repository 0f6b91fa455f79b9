#include "server/access/secret_file.h"

#include <sys/stat.h>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"

namespace treeline::access {

absl::StatusOr<std::string> ReadSecretFile(const std::string& path,
                                           const TrustLog& log) {
  WarnIfOthersMayRead(path, log);
  return base::ReadFile(path, /*max_bytes=*/1 << 20);
}

void WarnIfOthersMayRead(const std::string& path, const TrustLog& log) {
  struct stat status = {};
  if (log == nullptr || stat(path.c_str(), &status) != 0) return;
  if ((status.st_mode & S_IROTH) == 0) return;
  log(TrustSeverity::kWarning,
      absl::StrCat(path,
                   " holds a secret that everyone on this machine may "
                   "read; chmod 600 it"));
}

}  // namespace treeline::access

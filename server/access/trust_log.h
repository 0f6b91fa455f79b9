// What operators should hear about keys and certificates.
#ifndef SERVER_ACCESS_TRUST_LOG_H_
#define SERVER_ACCESS_TRUST_LOG_H_

#include <functional>
#include <string>

namespace treeline::access {

enum class TrustSeverity { kInfo, kWarning };

// Called from any thread, with no lock held. Messages name files and the
// reason, never a key or a token.
using TrustLog =
    std::function<void(TrustSeverity severity, const std::string& message)>;

}  // namespace treeline::access

#endif  // SERVER_ACCESS_TRUST_LOG_H_

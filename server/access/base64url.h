// Base64 with the alphabet for URLs, without padding (RFC 4648, section 5; RFC
// 7515, appendix C).
#ifndef SERVER_ACCESS_BASE64URL_H_
#define SERVER_ACCESS_BASE64URL_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::access {

std::string EncodeBase64Url(absl::string_view bytes);

// Strict, so that no two texts mean the same bytes: nullopt for any other
// character, padding, a length that cannot be, or bits that are left over and
// not zero.
std::optional<std::string> DecodeBase64Url(absl::string_view text);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_BASE64URL_H_

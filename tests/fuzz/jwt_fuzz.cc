// Tokens as arbitrary bytes: no crash, and none that nobody signed is taken.
//
// The input is a token, or else, since no fuzzer finds a signature, the claims
// of one (after a newline at the start), which are read as if it had been
// verified.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "server/access/jwt.h"
#include "server/access/jwt_keys.h"
#include "server/access/token_claims.h"

namespace treeline {
namespace {

// Whose private keys were thrown away.
constexpr char kKeys[] =
    R"({"keys":[{"kty":"RSA","kid":"r","n":"yCSpSrRfwWu-nqPcsdomjHPK98WHd)"
    R"(lo0ylHMiTyqhoBo890_O_GmLLjqENYz-jvsXb9T0N4iUou5utwzKYXoDmG-VrLoZIt)"
    R"(TmL2kKwGgMdJ4gbdQe-NYCVoC5snghvRw1VBCLTXAjbWpP1bJLM5s4L_crfjuyt0Ub)"
    R"(aB0EOkjUe-LdeD4jq04Vq2pULRVZx1BBtqKqwEK7ibiOtNcdd5bMWbHB3-cjUEZDYh)"
    R"(MhV7p565gGeu5YuWE26u1K2ABPXxjUiVF9SvDMFsVVFEI5sOcRNEHGxdjpfplJopTp)"
    R"(IXx1k1JE1UIo6Z859Z0D5voUPckp0cx2J_Lr5ZQWgs9ODKpuw","e":"AQAB"},{"k)"
    R"(ty":"EC","crv":"P-256","kid":"e","x":"4Yno6LSNKli0GgTJf2g3mFzOBzHk)"
    R"(vRJdt3x0Yec0VUo","y":"rQqhxz4ruT2S7-1DVjReuAOhTJj82_G9kIpHT72ILrw")"
    R"(},{"kty":"OKP","crv":"Ed25519","kid":"d","x":")"
    R"(11qYAYKxCrfVS_7TyWQHOg7hcvPapiMlrwIaaPcHURo"},{"kty":"oct","kid":"h","k":"XxNuVIzChYN7uIFyeIhKSgUvlhe3zwJDXGU0)"
    R"(X8XgBq4"}]})";

void CheckClaims(absl::string_view json) {
  constexpr int64_t kNow = 1'800'000'000;
  const access::ClaimRules rules = {};
  const auto claims = access::ParseTokenClaims(json, rules, kNow);
  if (!claims.ok()) return;
  if (claims->subject.empty() || claims->subject.size() > 256 ||
      claims->expires_unix_s + rules.leeway_s <= kNow ||
      !(claims->rate_per_s >= 0)) {
    std::abort();
  }
}

void CheckToken(absl::string_view token) {
  static const access::JwtKeySet* const keys = [] {
    auto parsed = access::ParseJwks(
        kKeys, {access::JwtAlgorithm::kRs256, access::JwtAlgorithm::kEs256,
                access::JwtAlgorithm::kEdDsa, access::JwtAlgorithm::kHs256});
    if (!parsed.ok()) std::abort();
    return new access::JwtKeySet(*std::move(parsed));
  }();
  if (access::VerifyJwtSignature(token, *keys).ok()) std::abort();
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  absl::string_view text(reinterpret_cast<const char*>(data), size);
  if (absl::ConsumePrefix(&text, "\n")) {
    treeline::CheckClaims(text);
  } else {
    treeline::CheckToken(text);
  }
  return 0;
}

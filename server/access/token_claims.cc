#include "server/access/token_claims.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"

namespace treeline::access {
namespace {

using Json = nlohmann::json;

constexpr size_t kLongestSubject = 256;
// Times beyond the year 30000 are taken for nonsense.
constexpr double kLatestTime = 1e12;

absl::Status Invalid(absl::string_view what) {
  return base::WithReason(
      absl::UnauthenticatedError(absl::StrCat("the token is invalid: ", what)),
      "TOKEN_INVALID");
}

// A time (RFC 7519, "NumericDate"): whole seconds, rounded down. nullopt: not
// there.
absl::StatusOr<std::optional<int64_t>> Time(const Json& claims,
                                            const char* name) {
  const auto claim = claims.find(name);
  if (claim == claims.end()) return std::nullopt;
  const double value = claim->is_number() ? claim->get<double>() : NAN;
  if (!(std::abs(value) <= kLatestTime)) {
    return Invalid(absl::StrCat("'", name, "' is no time"));
  }
  return static_cast<int64_t>(std::floor(value));
}

absl::Status CheckTimes(const Json& claims, const ClaimRules& rules,
                        int64_t now, TokenClaims* result) {
  TL_ASSIGN_OR_RETURN(const std::optional<int64_t> expires,
                      Time(claims, "exp"));
  TL_ASSIGN_OR_RETURN(const std::optional<int64_t> begins, Time(claims, "nbf"));
  TL_ASSIGN_OR_RETURN(const std::optional<int64_t> issued, Time(claims, "iat"));
  if (!expires) return Invalid("it never expires ('exp' is missing)");
  if (begins && *begins > now + rules.leeway_s) {
    return Invalid("it is not valid yet ('nbf')");
  }
  if (issued && *issued > now + rules.leeway_s) {
    return Invalid("it was issued in the future ('iat')");
  }
  result->expires_unix_s = *expires;
  return CheckExpiry(*expires, rules, now);
}

bool HoldsText(const Json& texts, const std::string& wanted) {
  if (texts.is_string()) return texts.get_ref<const std::string&>() == wanted;
  if (!texts.is_array()) return false;
  return std::any_of(texts.begin(), texts.end(), [&](const Json& text) {
    return text.is_string() && text.get_ref<const std::string&>() == wanted;
  });
}

absl::Status CheckParties(const Json& claims, const ClaimRules& rules) {
  const auto issuer = claims.find("iss");
  if (!rules.issuer.empty() &&
      (issuer == claims.end() || !issuer->is_string() ||
       issuer->get_ref<const std::string&>() != rules.issuer)) {
    return Invalid("another issuer ('iss')");
  }
  const auto audience = claims.find("aud");
  if (audience == claims.end() || !HoldsText(*audience, rules.audience)) {
    return Invalid("made for another service ('aud')");
  }
  return absl::OkStatus();
}

void AddScope(absl::string_view scope, TokenClaims* result) {
  if (scope == "localize") result->may_localize = true;
  if (scope == "admin") result->may_administer = true;
  if (scope == "inspect") result->may_inspect = true;
}

void AddScopes(const Json& claims, TokenClaims* result) {
  for (const char* name : {"scope", "scp"}) {
    const auto claim = claims.find(name);
    if (claim == claims.end()) continue;
    if (claim->is_string()) {
      const std::string& words = claim->get_ref<const std::string&>();
      for (const absl::string_view word : absl::StrSplit(words, ' ')) {
        AddScope(word, result);
      }
    }
    if (!claim->is_array()) continue;
    for (const Json& word : *claim) {
      if (word.is_string()) {
        AddScope(word.get_ref<const std::string&>(), result);
      }
    }
  }
}

}  // namespace

absl::Status ClaimRules::Validate() const {
  if (audience.empty()) {
    return absl::InvalidArgumentError("no audience that tokens are made for");
  }
  if (leeway_s < 0 || leeway_s > 300) {
    return absl::InvalidArgumentError(
        absl::StrCat("leeway is ", leeway_s, " s; it must be 0..300"));
  }
  return absl::OkStatus();
}

absl::Status CheckExpiry(int64_t expires_unix_s, const ClaimRules& rules,
                         int64_t now_unix_s) {
  if (now_unix_s < expires_unix_s + rules.leeway_s) return absl::OkStatus();
  return base::WithReason(absl::UnauthenticatedError("the token has expired"),
                          "TOKEN_EXPIRED");
}

absl::StatusOr<TokenClaims> ParseTokenClaims(absl::string_view json,
                                             const ClaimRules& rules,
                                             int64_t now_unix_s) {
  const Json claims = Json::parse(json.begin(), json.end(), nullptr,
                                  /*allow_exceptions=*/false);
  if (!claims.is_object()) return Invalid("its claims are malformed");
  TokenClaims result;
  // Whom it is for comes first: a stranger's token is invalid, not expired.
  TL_RETURN_IF_ERROR(CheckParties(claims, rules));
  TL_RETURN_IF_ERROR(CheckTimes(claims, rules, now_unix_s, &result));
  const auto subject = claims.find("sub");
  if (subject == claims.end() || !subject->is_string()) {
    return Invalid("it does not say who calls ('sub')");
  }
  result.subject = subject->get<std::string>();
  if (result.subject.empty() || result.subject.size() > kLongestSubject) {
    return Invalid("'sub' must have 1 to 256 bytes");
  }
  if (const auto rate = claims.find("rate"); rate != claims.end()) {
    result.rate_per_s = rate->is_number() ? rate->get<double>() : NAN;
    if (!(result.rate_per_s > 0) || !std::isfinite(result.rate_per_s)) {
      return Invalid("'rate' must be a number above 0");
    }
  }
  AddScopes(claims, &result);
  return result;
}

}  // namespace treeline::access

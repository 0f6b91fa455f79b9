// What trust adds to a call, in time.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "benchmark/benchmark.h"
#include "common/base/file.h"
#include "server/access/jwt.h"
#include "server/access/rate_limited_access.h"
#include "server/access/token_access.h"
#include "server/access/token_maker.h"

namespace treeline::access {
namespace {

constexpr char kClaims[] =
    R"({"sub":"robot-7","aud":"treeline","exp":99999999999,)"
    R"("scope":"localize"})";

void VerifySignature(benchmark::State& state, JwtAlgorithm algorithm,
                     const std::string& private_key,
                     const std::string& material) {
  const auto keys = JwtKeySet::Make({{"k", algorithm, material}});
  const std::string token = MakeToken(algorithm, private_key, "k", kClaims);
  for (auto _ : state) {
    if (!VerifyJwtSignature(token, *keys).ok()) std::abort();
  }
}

void VerifyRs256(benchmark::State& state) {
  const std::string key = MakeRsaPrivateKey();
  VerifySignature(state, JwtAlgorithm::kRs256, key, PublicKeyOf(key));
}
BENCHMARK(VerifyRs256);

void VerifyEs256(benchmark::State& state) {
  const std::string key = MakeEcPrivateKey();
  VerifySignature(state, JwtAlgorithm::kEs256, key, PublicKeyOf(key));
}
BENCHMARK(VerifyEs256);

void VerifyHs256(benchmark::State& state) {
  const std::string secret(32, 's');
  VerifySignature(state, JwtAlgorithm::kHs256, secret, secret);
}
BENCHMARK(VerifyHs256);

// A token that has been seen, and a rate that is not exceeded: what every call
// but the first costs. The files of keys are polled once a second.
void AdmitKnownToken(benchmark::State& state) {
  const std::string key = MakeEcPrivateKey();
  const std::string path = absl::StrCat(
      std::filesystem::temp_directory_path().string(), "/jwks-", getpid());
  if (!base::WriteFileAtomically(path, Jwks({EcJwk(key, "k")})).ok())
    std::abort();
  const base::SteadyClock clock;
  const SystemWallClock wall;
  const auto keys = KeyStore::Open({.path = path}, clock, nullptr);
  if (!keys.ok()) std::abort();
  TokenVerifier verifier({}, **keys, wall);
  TokenAccess tokens({}, &verifier);
  RateLimitedAccess access(tokens, {.rate_per_s = 1e6, .burst = 1000000},
                           clock);
  service::CallInfo call;
  call.credentials.bearer_token =
      MakeToken(JwtAlgorithm::kEs256, key, "k", kClaims);
  for (auto _ : state) {
    if (!access.Admit(call, service::Scope::kLocalize).ok()) std::abort();
  }
  std::filesystem::remove(path);
}
BENCHMARK(AdmitKnownToken);

}  // namespace
}  // namespace treeline::access

BENCHMARK_MAIN();

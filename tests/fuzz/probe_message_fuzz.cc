// Requests of health and of reflection as arbitrary bytes: no crash, and an
// answer that is not out of proportion.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/grpc_server/reflection_service.h"
#include "server/service/health_service.h"

namespace {

// All files of ours.
constexpr size_t kMaxBytes = 1 << 20;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto name = treeline::service::DecodeHealthRequest(bytes);
  if (name.ok() && name->size() > size) std::abort();
  if (!name.ok() && !absl::IsInvalidArgument(name.status())) std::abort();
  const std::vector<std::string> services = {"a.B"};
  const std::string answer =
      treeline::grpc_server::AnswerReflection(bytes, services);
  if (answer.empty() || answer.size() > size + kMaxBytes) std::abort();
  return 0;
}

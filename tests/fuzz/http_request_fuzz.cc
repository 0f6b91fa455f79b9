// Requests of HTTP as arbitrary bytes: no crash; what is accepted as a head
// says in one way where its body ends; a body stays within its limits, and
// within the memory that it has leased.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/http/body_reader.h"
#include "common/http/request_head.h"

namespace {

constexpr size_t kMaxBytes = 1 << 20;

void Check(bool holds) {
  if (!holds) std::abort();
}

class BytesSource final : public treeline::http::ByteSource {
 public:
  explicit BytesSource(absl::string_view bytes) : bytes_(bytes) {}
  ssize_t Read(char* to, size_t size) override {
    const size_t taken = std::min(size, bytes_.size());
    if (taken > 0) std::memcpy(to, bytes_.data(), taken);
    bytes_.remove_prefix(taken);
    return static_cast<ssize_t>(taken);
  }

 private:
  absl::string_view bytes_;
};

void CheckHead(const treeline::http::RequestHead& head) {
  Check(!head.method.empty() && !head.target.empty());
  Check(!head.is_chunked || !head.content_length.has_value());
  for (const auto& [name, value] : head.headers) {
    Check(!name.empty());
    Check(value.find_first_of("\r\n\0", 0, 3) == std::string::npos);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  treeline::http::HeadScanner scanner;
  if (scanner.Scan(bytes) != treeline::http::HeadScanner::Verdict::kComplete) {
    return 0;
  }
  const auto head =
      treeline::http::ParseRequestHead(bytes.substr(0, scanner.end()));
  if (!head.has_value()) return 0;
  CheckHead(*head);
  BytesSource source(bytes.substr(scanner.end()));
  treeline::base::ByteBudget budget(4 * kMaxBytes);
  treeline::base::ByteLease lease(&budget);
  treeline::http::BodyReader reader(source, {.max_bytes = kMaxBytes}, lease);
  std::string body;
  const int status = reader.Read(*head, body);
  Check(status == 0 || status == 400 || status == 413);
  Check(body.size() <= kMaxBytes);
  // Short ones are held in the string itself.
  Check(body.size() <= std::max<size_t>(lease.bytes(), 32));
  return 0;
}

#include "common/tracing/otlp_message.h"

#include <bit>
#include <cstdint>

#include "absl/strings/escaping.h"

namespace treeline::tracing {
namespace {

constexpr size_t kLongestText = 1024;
// Parent and trace are known to be sampled, as is W3C's flag.
constexpr uint32_t kSampledFlag = 1;
constexpr uint64_t kStatusError = 2;

// What a field's tag says about the bytes behind it.
enum class WireType : uint8_t {
  kVarint = 0,
  kFixed64 = 1,
  kBytes = 2,
  kFixed32 = 5
};

// One message, field by field.
class Message {
 public:
  void Varint(int field, uint64_t value) {
    Tag(field, WireType::kVarint);
    Raw(value);
  }
  void Fixed64(int field, uint64_t value) {
    Tag(field, WireType::kFixed64);
    Little(value, 8);
  }
  void Fixed32(int field, uint32_t value) {
    Tag(field, WireType::kFixed32);
    Little(value, 4);
  }
  void Bytes(int field, absl::string_view bytes) {
    Tag(field, WireType::kBytes);
    Raw(bytes.size());
    bytes_.append(bytes.data(), bytes.size());
  }
  void Sub(int field, const Message& message) { Bytes(field, message.bytes_); }
  std::string Take() { return std::move(bytes_); }

 private:
  void Tag(int field, WireType type) {
    Raw(static_cast<uint64_t>(field) << 3 | static_cast<uint64_t>(type));
  }
  void Raw(uint64_t value) {
    for (; value >= 0x80; value >>= 7) {
      bytes_.push_back(static_cast<char>(value | 0x80));
    }
    bytes_.push_back(static_cast<char>(value));
  }
  void Little(uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      bytes_.push_back(static_cast<char>(value >> (8 * i)));
    }
  }

  std::string bytes_;
};

// Whatever is not ASCII may be broken UTF-8, or become so where it is cut.
std::string Text(absl::string_view text) {
  std::string result(text.substr(0, kLongestText));
  for (char& c : result) {
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  }
  return result;
}

struct AnyValue {
  Message operator()(bool value) const {
    Message message;
    message.Varint(2, value ? 1 : 0);
    return message;
  }
  Message operator()(int64_t value) const {
    Message message;
    message.Varint(3, static_cast<uint64_t>(value));
    return message;
  }
  Message operator()(double value) const {
    Message message;
    message.Fixed64(4, std::bit_cast<uint64_t>(value));
    return message;
  }
  Message operator()(const std::string& value) const {
    Message message;
    message.Bytes(1, Text(value));
    return message;
  }
};

void AddAttributes(int field, const Attributes& attributes, Message& to) {
  for (const auto& [name, value] : attributes) {
    Message pair;
    pair.Bytes(1, Text(name));
    pair.Sub(2, std::visit(AnyValue(), value));
    to.Sub(field, pair);
  }
}

uint64_t UnixNanoseconds(WallTime time) {
  return static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(
          time.time_since_epoch())
          .count());
}

Message SpanMessage(const Span& span) {
  Message message;
  message.Bytes(1, absl::HexStringToBytes(span.context.trace_id));
  message.Bytes(2, absl::HexStringToBytes(span.context.span_id));
  if (!span.parent_span_id.empty()) {
    message.Bytes(4, absl::HexStringToBytes(span.parent_span_id));
  }
  message.Bytes(5, Text(span.name));
  message.Varint(6, static_cast<uint64_t>(span.kind));
  message.Fixed64(7, UnixNanoseconds(span.start));
  message.Fixed64(8, UnixNanoseconds(span.end));
  AddAttributes(9, span.attributes, message);
  if (span.is_error) {
    Message status;
    status.Bytes(2, Text(span.error));
    status.Varint(3, kStatusError);
    message.Sub(15, status);
  }
  message.Fixed32(16, span.context.sampled ? kSampledFlag : 0);
  return message;
}

}  // namespace

std::string OtlpMessage(const Attributes& resource, absl::string_view version,
                        const std::vector<Span>& spans) {
  Message resource_message;
  AddAttributes(1, resource, resource_message);
  Message scope;
  scope.Bytes(1, "treeline");
  scope.Bytes(2, Text(version));
  Message scope_spans;
  scope_spans.Sub(1, scope);
  for (const Span& span : spans) scope_spans.Sub(2, SpanMessage(span));
  Message resource_spans;
  resource_spans.Sub(1, resource_message);
  resource_spans.Sub(2, scope_spans);
  Message request;
  request.Sub(1, resource_spans);
  return request.Take();
}

}  // namespace treeline::tracing

#include "common/wire/message_shape.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/wire_format_lite.h>

#include <climits>
#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"

namespace treeline::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

absl::Status Refused(const std::string& message) {
  return base::WithReason(absl::InvalidArgumentError(message),
                          "INVALID_REQUEST");
}

absl::Status NoMessage(const Descriptor& type) {
  return Refused(absl::StrCat("the request is not a ", type.full_name(),
                              " in protobuf's binary format"));
}

class Walk {
 public:
  Walk(google::protobuf::io::ZeroCopyInputStream& bytes,
       const MessageLimits& limits)
      : input_(&bytes), limits_(limits) {}

  absl::Status Fields(const Descriptor& type, int depth) {
    if (depth > limits_.max_depth) {
      return Refused(absl::StrCat("the request has messages more than ",
                                  limits_.max_depth, " deep"));
    }
    while (const uint32_t tag = input_.ReadTag()) {
      if (absl::Status counted = Count(1); !counted.ok()) return counted;
      const FieldDescriptor* field =
          type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag));
      if (absl::Status one = Field(type, tag, field, depth); !one.ok()) {
        return one;
      }
    }
    // Tag 0 is none; neither is one that is cut off.
    return input_.ConsumedEntireMessage() ? absl::OkStatus() : NoMessage(type);
  }

 private:
  absl::Status Count(int64_t fields) {
    fields_ += fields;
    if (fields_ <= limits_.max_fields) return absl::OkStatus();
    return Refused(absl::StrCat("the request has more than ",
                                limits_.max_fields, " fields"));
  }

  absl::Status Field(const Descriptor& type, uint32_t tag,
                     const FieldDescriptor* field, int depth) {
    uint64_t value = 0;
    uint32_t length = 0;
    switch (WireFormatLite::GetTagWireType(tag)) {
      case WireFormatLite::WIRETYPE_VARINT:
        return input_.ReadVarint64(&value) ? absl::OkStatus() : NoMessage(type);
      case WireFormatLite::WIRETYPE_FIXED64:
        return input_.Skip(8) ? absl::OkStatus() : NoMessage(type);
      case WireFormatLite::WIRETYPE_FIXED32:
        return input_.Skip(4) ? absl::OkStatus() : NoMessage(type);
      case WireFormatLite::WIRETYPE_LENGTH_DELIMITED:
        if (!input_.ReadVarint32(&length) || length > INT_MAX) {
          return NoMessage(type);
        }
        return Delimited(type, field, static_cast<int>(length), depth);
      default:
        return NoMessage(type);
    }
  }

  absl::Status Delimited(const Descriptor& type, const FieldDescriptor* field,
                         int length, int depth) {
    if (field != nullptr && field->type() == FieldDescriptor::TYPE_MESSAGE) {
      const CodedInputStream::Limit outer = input_.PushLimit(length);
      if (input_.BytesUntilLimit() != length) return NoMessage(type);
      absl::Status within = Fields(*field->message_type(), depth + 1);
      if (within.ok() && input_.BytesUntilLimit() != 0) return NoMessage(type);
      input_.PopLimit(outer);
      return within;
    }
    if (field != nullptr && field->is_packable()) {
      if (absl::Status counted = Count(length / SizeOf(*field));
          !counted.ok()) {
        return counted;
      }
    }
    return input_.Skip(length) ? absl::OkStatus() : NoMessage(type);
  }

  // The fewest bytes that an element of a packed field takes.
  static int SizeOf(const FieldDescriptor& field) {
    switch (WireFormatLite::WireTypeForFieldType(
        static_cast<WireFormatLite::FieldType>(field.type()))) {
      case WireFormatLite::WIRETYPE_FIXED64:
        return 8;
      case WireFormatLite::WIRETYPE_FIXED32:
        return 4;
      default:
        return 1;
    }
  }

  CodedInputStream input_;
  const MessageLimits limits_;
  int64_t fields_ = 0;
};

}  // namespace

absl::Status CheckMessageShape(google::protobuf::io::ZeroCopyInputStream& bytes,
                               const Descriptor& type,
                               const MessageLimits& limits) {
  return Walk(bytes, limits).Fields(type, 1);
}

absl::Status ParseMessage(absl::string_view bytes, Message& message) {
  message.Clear();
  if (bytes.size() > INT_MAX) return NoMessage(*message.GetDescriptor());
  const int size = static_cast<int>(bytes.size());
  google::protobuf::io::ArrayInputStream stream(bytes.data(), size);
  absl::Status shape = CheckMessageShape(stream, *message.GetDescriptor());
  if (!shape.ok()) return shape;
  return message.ParseFromArray(bytes.data(), size)
             ? absl::OkStatus()
             : NoMessage(*message.GetDescriptor());
}

}  // namespace treeline::wire

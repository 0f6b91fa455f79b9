// Messages of clients as arbitrary bytes: no crash; what passes the check of
// its shape takes little more memory than its bytes.
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/wire/message_shape.h"
#include "treeline/v1/relocalization.pb.h"
#include "treeline/v1/scenes.pb.h"

namespace {

// Of a field that is as small as can be, with what arrays grow beyond it.
constexpr size_t kMaxBytesOfField = 512;
constexpr int kMaxFields = 1000;

template <typename Message>
void TryAs(const std::string& bytes) {
  google::protobuf::io::ArrayInputStream stream(bytes.data(),
                                                static_cast<int>(bytes.size()));
  const absl::Status shape = treeline::wire::CheckMessageShape(
      stream, *Message::descriptor(), {.max_fields = kMaxFields});
  if (!shape.ok()) {
    if (!absl::IsInvalidArgument(shape)) std::abort();
    return;
  }
  Message message;
  if (!treeline::wire::ParseMessage(bytes, message).ok()) return;
  if (message.SpaceUsedLong() >
      4 * bytes.size() + kMaxBytesOfField * (kMaxFields + 1)) {
    std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  TryAs<treeline::v1::LocalizeRequest>(bytes);
  TryAs<treeline::v1::LocalizeStreamRequest>(bytes);
  TryAs<treeline::v1::LoadSceneRequest>(bytes);
  return 0;
}

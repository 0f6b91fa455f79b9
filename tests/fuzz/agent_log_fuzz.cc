// Agent logs as arbitrary bytes: every entry that is read can be written and
// read again, and no byte is counted twice. The first byte chooses a kind, and
// the rest is also read as one payload of it, since no mutation would meet a
// checksum.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "absl/strings/string_view.h"
#include "nav_agent/recording/agent_log.h"
#include "nav_agent/recording/log_payload.h"

namespace treeline {
namespace {

void ReadAll(absl::string_view bytes) {
  auto reader = recording::AgentLogReader::Parse(bytes);
  if (!reader.ok()) return;
  while (auto entry = reader->Next()) {
    if (recording::DecodeLogFrame(
            std::holds_alternative<recording::LogFrame>(*entry)
                ? std::get<recording::LogFrame>(*entry)
                : recording::LogFrame{})
            .ok()) {
      continue;
    }
  }
  if (reader->damaged_bytes() < 0 ||
      static_cast<size_t>(reader->damaged_bytes()) > bytes.size() ||
      reader->end_of_last_entry() > bytes.size()) {
    std::abort();
  }
}

void ReadOne(uint16_t kind, absl::string_view payload) {
  const auto entry = recording::DecodeLogPayload(kind, 1, payload);
  if (!entry.has_value()) return;
  // What was understood is written in one way only.
  const recording::LogPayload written = recording::EncodeLogPayload(*entry);
  const auto again = recording::DecodeLogPayload(written.kind, written.stamp_ns,
                                                 written.bytes);
  if (!again.has_value() ||
      recording::EncodeLogPayload(*again).bytes != written.bytes ||
      written.kind != kind) {
    std::abort();
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  treeline::ReadAll(bytes);
  if (size > 0) treeline::ReadOne(data[0] % 32, bytes.substr(1));
  return 0;
}

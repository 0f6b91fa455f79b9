// Arbitrary bytes as MCAP: opening and reading end, read within the bytes, and
// what was read is read again by its place.
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/mcap/mcap_reader.h"

namespace {

namespace mcap = treeline::mcap;

// As many places are tried again.
constexpr size_t kPlaces = 20;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  auto reader =
      mcap::McapReader::Open({reinterpret_cast<const char*>(data), size});
  if (!reader.ok()) return 0;
  for (const auto& [id, channel] : reader->channels()) {
    if (channel.topic.size() + channel.schema_text.size() > (size_t{1} << 30)) {
      std::abort();
    }
  }
  std::vector<std::pair<mcap::McapPlace, std::string>> places;
  (void)reader->Read(0, std::numeric_limits<uint64_t>::max(),
                     [&](const mcap::McapMessage& message) {
                       if (places.size() < kPlaces) {
                         places.emplace_back(message.place,
                                             std::string(message.bytes));
                       }
                       return absl::OkStatus();
                     });
  for (const auto& [place, bytes] : places) {
    const auto again = reader->Fetch(place);
    if (!again.ok() || again->bytes != bytes) std::abort();
  }
  return 0;
}

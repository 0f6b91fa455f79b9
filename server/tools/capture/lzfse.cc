#include "server/tools/capture/lzfse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::capture {
namespace {

constexpr size_t kLengthSymbols = 20;
constexpr size_t kDistanceSymbols = 64;
constexpr size_t kLiteralSymbols = 256;
constexpr int kLengthStates = 64;
constexpr int kDistanceStates = 256;
constexpr int kLiteralStates = 1024;
constexpr uint32_t kMaxLiterals = 40000;
constexpr uint32_t kMaxMatches = 10000;
constexpr size_t kHeaderBytes = 32;  // before the tables of frequencies

absl::Status Damaged(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("the LZFSE stream is damaged: ", what));
}

uint64_t LittleEndian(absl::string_view bytes, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = 0; i < count; ++i) {
    value |= uint64_t{static_cast<uint8_t>(bytes[at + i])} << (8 * i);
  }
  return value;
}

uint32_t Field(uint64_t value, int from, int bits) {
  return static_cast<uint32_t>((value >> from) & ((uint64_t{1} << bits) - 1));
}

// The bits of a payload, the last ones first.
class BackwardBits {
 public:
  // unused: how many of the highest bits of the last byte say nothing.
  BackwardBits(absl::string_view bytes, uint32_t unused)
      : bytes_(bytes), left_(8 * bytes.size()) {
    is_good_ = unused <= left_;
    if (is_good_) left_ -= unused;
  }

  // 0 to 32 bits; 0 where there are not so many left.
  uint32_t Pull(int bits) {
    if (static_cast<size_t>(bits) > left_) is_good_ = false;
    if (!is_good_) return 0;
    left_ -= static_cast<size_t>(bits);
    const size_t byte = left_ / 8;
    const uint64_t window =
        LittleEndian(bytes_, byte, std::min<size_t>(5, bytes_.size() - byte));
    return Field(window, static_cast<int>(left_ % 8), bits);
  }
  bool is_good() const { return is_good_; }

 private:
  absl::string_view bytes_;
  size_t left_;
  bool is_good_;
};

// Values that a symbol stands for: base, and as many more bits.
struct ValueRange {
  uint32_t base = 0;
  int extra_bits = 0;
};

template <size_t kCount>
constexpr std::array<ValueRange, kCount> RangesOf(
    const std::array<int, kCount>& extra_bits) {
  std::array<ValueRange, kCount> ranges{};
  uint32_t base = 0;
  for (size_t i = 0; i < kCount; ++i) {
    ranges[i] = {base, extra_bits[i]};
    base += uint32_t{1} << extra_bits[i];
  }
  return ranges;
}

constexpr auto kLiteralRunRanges = RangesOf<kLengthSymbols>(
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 3, 5, 8});
constexpr auto kMatchRanges = RangesOf<kLengthSymbols>(
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 5, 8, 11});

constexpr std::array<int, kDistanceSymbols> DistanceBits() {
  std::array<int, kDistanceSymbols> bits{};
  for (size_t i = 0; i < bits.size(); ++i) bits[i] = static_cast<int>(i / 4);
  return bits;
}
constexpr auto kDistanceRanges = RangesOf<kDistanceSymbols>(DistanceBits());

// A finite state decoder. Each state is of one symbol; bits of the stream
// choose the next one.
class StateDecoder {
 public:
  static absl::StatusOr<StateDecoder> Create(
      int states, std::span<const uint16_t> frequencies) {
    StateDecoder decoder;
    const int leading = std::countl_zero(static_cast<uint32_t>(states));
    for (size_t symbol = 0; symbol < frequencies.size(); ++symbol) {
      const int f = frequencies[symbol];
      if (f == 0) continue;
      if (f > states - static_cast<int>(decoder.states_.size())) {
        return Damaged("its frequencies are too large");
      }
      // Bits, so that states <= f << k < 2 states.
      const int k = std::countl_zero(static_cast<uint32_t>(f)) - leading;
      const int with_k = (2 * states >> k) - f;
      for (int j = 0; j < f; ++j) {
        const bool is_long = j < with_k;
        decoder.states_.push_back({.symbol = static_cast<uint16_t>(symbol),
                                   .bits = is_long ? k : k - 1,
                                   .next = is_long ? ((f + j) << k) - states
                                                   : (j - with_k) << (k - 1)});
      }
    }
    return decoder;
  }

  // Whether `state` is one; what the methods below are called with must be.
  bool Has(uint32_t state) const { return state < states_.size(); }
  uint16_t Symbol(uint32_t state) const { return states_[state].symbol; }
  uint32_t Next(uint32_t state, BackwardBits& bits) const {
    const State& s = states_[state];
    return static_cast<uint32_t>(s.next) + bits.Pull(s.bits);
  }

 private:
  struct State {
    uint16_t symbol = 0;
    int bits = 0;
    int next = 0;
  };
  std::vector<State> states_;
};

// A compressed block's header, unpacked.
struct Header {
  uint32_t raw_bytes = 0;
  uint32_t literals = 0;
  uint32_t literal_payload = 0;
  uint32_t matches = 0;
  uint32_t match_payload = 0;
  uint32_t literal_unused = 0;
  uint32_t match_unused = 0;
  std::array<uint32_t, 4> literal_states{};
  uint32_t run_state = 0;
  uint32_t length_state = 0;
  uint32_t distance_state = 0;
  uint32_t header_bytes = 0;
  std::array<uint16_t, 2 * kLengthSymbols + kDistanceSymbols + kLiteralSymbols>
      frequencies{};
};

// The next frequency, of 2, 3, 5, 8 or 14 bits by its lowest ones.
struct Frequency {
  uint16_t value = 0;
  int bits = 0;
};
Frequency FrequencyOf(uint32_t bits) {
  if ((bits & 1) == 0) {
    return {static_cast<uint16_t>((bits & 2) != 0 ? 1 : 0), 2};
  }
  if ((bits & 2) == 0) {
    return {static_cast<uint16_t>((bits & 4) != 0 ? 3 : 2), 3};
  }
  if ((bits & 4) == 0) {
    return {static_cast<uint16_t>(4 + ((bits >> 3) & 3)), 5};
  }
  if ((bits & 8) == 0) {
    return {static_cast<uint16_t>(8 + ((bits >> 4) & 0xf)), 8};
  }
  return {static_cast<uint16_t>(24 + ((bits >> 4) & 0x3ff)), 14};
}

absl::Status ReadFrequencies(absl::string_view bytes, Header& header) {
  uint32_t window = 0;
  int held = 0;
  size_t at = 0;
  for (uint16_t& frequency : header.frequencies) {
    while (at < bytes.size() && held + 8 <= 32) {
      window |= uint32_t{static_cast<uint8_t>(bytes[at++])} << held;
      held += 8;
    }
    const Frequency read = FrequencyOf(window);
    if (read.bits > held) return Damaged("its tables end early");
    frequency = read.value;
    window >>= read.bits;
    held -= read.bits;
  }
  return held < 8 && at == bytes.size() ? absl::OkStatus()
                                        : Damaged("its tables are too long");
}

absl::StatusOr<Header> ReadHeader(absl::string_view block) {
  if (block.size() < kHeaderBytes) return Damaged("a block ends early");
  Header header;
  header.raw_bytes = static_cast<uint32_t>(LittleEndian(block, 4, 4));
  const uint64_t a = LittleEndian(block, 8, 8);
  const uint64_t b = LittleEndian(block, 16, 8);
  const uint64_t c = LittleEndian(block, 24, 8);
  header.literals = Field(a, 0, 20);
  header.literal_payload = Field(a, 20, 20);
  header.matches = Field(a, 40, 20);
  header.literal_unused = 7 - Field(a, 60, 3);
  for (size_t i = 0; i < 4; ++i) {
    header.literal_states[i] = Field(b, 10 * static_cast<int>(i), 10);
  }
  header.match_payload = Field(b, 40, 20);
  header.match_unused = 7 - Field(b, 60, 3);
  header.header_bytes = Field(c, 0, 32);
  header.run_state = Field(c, 32, 10);
  header.length_state = Field(c, 42, 10);
  header.distance_state = Field(c, 52, 10);
  if (header.header_bytes < kHeaderBytes ||
      header.header_bytes > block.size() || header.literals > kMaxLiterals ||
      header.literals % 4 != 0 || header.matches > kMaxMatches ||
      block.size() - header.header_bytes <
          size_t{header.literal_payload} + header.match_payload) {
    return Damaged("a block's header makes no sense");
  }
  TL_RETURN_IF_ERROR(ReadFrequencies(
      block.substr(kHeaderBytes, header.header_bytes - kHeaderBytes), header));
  return header;
}

absl::StatusOr<std::vector<uint8_t>> ReadLiterals(const Header& header,
                                                  absl::string_view payload) {
  TL_ASSIGN_OR_RETURN(
      const StateDecoder decoder,
      StateDecoder::Create(
          kLiteralStates, std::span(header.frequencies)
                              .subspan(2 * kLengthSymbols + kDistanceSymbols)));
  BackwardBits bits(payload, header.literal_unused);
  std::array<uint32_t, 4> states = header.literal_states;
  std::vector<uint8_t> literals;
  literals.reserve(header.literals);
  for (uint32_t i = 0; i < header.literals; ++i) {
    uint32_t& state = states[i % 4];
    if (!decoder.Has(state)) return Damaged("a literal has no symbol");
    literals.push_back(static_cast<uint8_t>(decoder.Symbol(state)));
    state = decoder.Next(state, bits);
  }
  if (!bits.is_good()) return Damaged("its literals end early");
  return literals;
}

// One of the three numbers of a match.
class ValueDecoder {
 public:
  ValueDecoder(StateDecoder decoder, std::span<const ValueRange> ranges,
               uint32_t state)
      : decoder_(std::move(decoder)), ranges_(ranges), state_(state) {}

  // nullopt: the stream is damaged. The bits of the next state come before
  // those of the value.
  std::optional<uint32_t> Read(BackwardBits& bits) {
    if (!decoder_.Has(state_)) return std::nullopt;
    const ValueRange& range = ranges_[decoder_.Symbol(state_)];
    state_ = decoder_.Next(state_, bits);
    const uint32_t value = range.base + bits.Pull(range.extra_bits);
    if (!bits.is_good()) return std::nullopt;
    return value;
  }

 private:
  const StateDecoder decoder_;
  const std::span<const ValueRange> ranges_;
  uint32_t state_;
};

absl::StatusOr<ValueDecoder> MakeValueDecoder(
    const Header& header, size_t first, int states,
    std::span<const ValueRange> ranges, uint32_t state) {
  TL_ASSIGN_OR_RETURN(
      StateDecoder decoder,
      StateDecoder::Create(
          states, std::span(header.frequencies).subspan(first, ranges.size())));
  return ValueDecoder(std::move(decoder), ranges, state);
}

// Appends what a block holds, `size` bytes in all at most. Returns its length.
absl::StatusOr<size_t> ReadCompressed(absl::string_view block, size_t size,
                                      std::vector<uint8_t>& out) {
  TL_ASSIGN_OR_RETURN(const Header header, ReadHeader(block));
  const absl::string_view payload = block.substr(header.header_bytes);
  TL_ASSIGN_OR_RETURN(
      const std::vector<uint8_t> literals,
      ReadLiterals(header, payload.substr(0, header.literal_payload)));
  BackwardBits bits(
      payload.substr(header.literal_payload, header.match_payload),
      header.match_unused);
  TL_ASSIGN_OR_RETURN(ValueDecoder runs,
                      MakeValueDecoder(header, 0, kLengthStates,
                                       kLiteralRunRanges, header.run_state));
  TL_ASSIGN_OR_RETURN(ValueDecoder lengths,
                      MakeValueDecoder(header, kLengthSymbols, kLengthStates,
                                       kMatchRanges, header.length_state));
  TL_ASSIGN_OR_RETURN(
      ValueDecoder distances,
      MakeValueDecoder(header, 2 * kLengthSymbols, kDistanceStates,
                       kDistanceRanges, header.distance_state));
  const size_t begin = out.size();
  size_t literal = 0;
  uint32_t distance = 0;
  for (uint32_t i = 0; i < header.matches; ++i) {
    const auto run = runs.Read(bits);
    const auto length = lengths.Read(bits);
    const auto new_distance = distances.Read(bits);
    if (!run || !length || !new_distance) return Damaged("a match is none");
    // 0: that of the match before.
    if (*new_distance != 0) distance = *new_distance;
    if (*run > literals.size() - literal ||
        size - out.size() < size_t{*run} + *length) {
      return Damaged("a match is too long");
    }
    const auto first = literals.begin() + static_cast<ptrdiff_t>(literal);
    out.insert(out.end(), first, first + static_cast<ptrdiff_t>(*run));
    literal += *run;
    if (*length > 0 && (distance == 0 || distance > out.size())) {
      return Damaged("a match is of what came before the beginning");
    }
    for (uint32_t j = 0; j < *length; ++j) {
      out.push_back(out[out.size() - distance]);
    }
  }
  if (out.size() - begin != header.raw_bytes) {
    return Damaged("a block holds another number of bytes than it says");
  }
  return header.header_bytes + size_t{header.literal_payload} +
         header.match_payload;
}

// The same of a block that is not compressed.
absl::StatusOr<size_t> ReadRaw(absl::string_view block, size_t size,
                               std::vector<uint8_t>& out) {
  constexpr size_t kRawHeaderBytes = 8;
  if (block.size() < kRawHeaderBytes) return Damaged("a block ends early");
  const uint64_t raw = LittleEndian(block, 4, 4);
  if (raw > block.size() - kRawHeaderBytes || raw > size - out.size()) {
    return Damaged("a raw block is too long");
  }
  const absl::string_view bytes = block.substr(kRawHeaderBytes, raw);
  out.insert(out.end(), bytes.begin(), bytes.end());
  return kRawHeaderBytes + raw;
}

}  // namespace

absl::StatusOr<std::vector<uint8_t>> DecodeLzfse(absl::string_view stream,
                                                 size_t size) {
  std::vector<uint8_t> out;
  out.reserve(size);
  for (;;) {
    const absl::string_view magic = stream.substr(0, 4);
    size_t length = 0;
    if (magic == "bvx$") break;
    if (magic == "bvx2") {
      TL_ASSIGN_OR_RETURN(length, ReadCompressed(stream, size, out));
    } else if (magic == "bvx-") {
      TL_ASSIGN_OR_RETURN(length, ReadRaw(stream, size, out));
    } else {
      return Damaged("a block is neither bvx2, bvx- nor bvx$");
    }
    stream.remove_prefix(length);
  }
  if (out.size() != size) {
    return Damaged(absl::StrCat("it holds ", out.size(), " bytes, not ", size));
  }
  return out;
}

}  // namespace treeline::capture

#include "common/http/body_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"

namespace treeline::http {
namespace {

constexpr int kBadRequest = 400;
constexpr int kTooLarge = 413;
constexpr int kUnavailable = 503;

constexpr size_t kPiece = 16384;
// What is leased at a time of a body whose size is known, and first of others.
constexpr size_t kStep = 65536;
constexpr size_t kLongestLine = 256;
constexpr size_t kMaxTrailers = 16;
constexpr size_t kMaxSizeDigits = 8;

// nullopt: not the line that begins a chunk.
std::optional<uint64_t> ParseChunkSize(absl::string_view line) {
  absl::string_view digits = line.substr(0, line.find(';'));
  digits = absl::StripTrailingAsciiWhitespace(digits);
  uint64_t size = 0;
  if (digits.empty() || digits.size() > kMaxSizeDigits ||
      !std::all_of(digits.begin(), digits.end(), absl::ascii_isxdigit) ||
      !absl::SimpleHexAtoi(digits, &size)) {
    return std::nullopt;
  }
  return size;
}

}  // namespace

int BodyReader::Read(const RequestHead& head, std::string& body) {
  // Also what an earlier body has left of capacity.
  std::string().swap(body);
  body_ = &body;
  max_bytes_ = options_.max_bytes;
  is_size_known_ = false;
  std::optional<Inflater> inflater;
  const auto encoding = head.headers.find("content-encoding");
  if (encoding != head.headers.end() &&
      absl::EqualsIgnoreCase(encoding->second, "gzip")) {
    inflater.emplace(options_.inflation);
    inflater_ = &*inflater;
  } else if (head.content_length.has_value()) {
    max_bytes_ = std::min<uint64_t>(max_bytes_, *head.content_length);
    is_size_known_ = true;
  }
  const int status = head.is_chunked
                         ? ReadChunked()
                         : ReadPlain(head.content_length.value_or(0));
  inflater_ = nullptr;
  if (status != 0) return status;
  const bool is_whole =
      !inflater.has_value() || inflater->is_complete() || raw_bytes_ == 0;
  return is_whole ? 0 : kBadRequest;
}

int BodyReader::ReadPlain(uint64_t bytes) {
  std::array<char, kPiece> piece;
  while (bytes > 0) {
    const ssize_t got = source_.Read(
        piece.data(), static_cast<size_t>(std::min<uint64_t>(bytes, kPiece)));
    if (got <= 0) return kBadRequest;
    bytes -= static_cast<uint64_t>(got);
    const int status =
        Take(absl::string_view(piece.data(), static_cast<size_t>(got)));
    if (status != 0) return status;
  }
  return 0;
}

int BodyReader::ReadChunked() {
  std::string line;
  for (;;) {
    if (const int status = ReadLine(line); status != 0) return status;
    const std::optional<uint64_t> size = ParseChunkSize(line);
    if (!size.has_value()) return kBadRequest;
    if (*size == 0) break;
    if (*size > options_.max_bytes) return kTooLarge;
    if (const int status = ReadPlain(*size); status != 0) return status;
    if (const int status = ReadLine(line); status != 0) return status;
    if (!line.empty()) return kBadRequest;
  }
  for (size_t trailers = 0; trailers <= kMaxTrailers; ++trailers) {
    if (const int status = ReadLine(line); status != 0) return status;
    if (line.empty()) return 0;
  }
  return kBadRequest;
}

int BodyReader::ReadLine(std::string& line) {
  line.clear();
  while (line.size() <= kLongestLine) {
    char byte = 0;
    if (source_.Read(&byte, 1) <= 0) return kBadRequest;
    line.push_back(byte);
    if (absl::EndsWith(line, "\r\n")) {
      line.resize(line.size() - 2);
      return 0;
    }
    // A line feed of its own, a carriage return of its own, NUL.
    const bool is_after_return =
        line.size() >= 2 && line[line.size() - 2] == '\r';
    if (is_after_return ||
        (absl::ascii_iscntrl(static_cast<unsigned char>(byte)) &&
         byte != '\r' && byte != '\t')) {
      return kBadRequest;
    }
  }
  return kBadRequest;
}

int BodyReader::Take(absl::string_view bytes) {
  raw_bytes_ += bytes.size();
  if (raw_bytes_ > options_.max_bytes) return kTooLarge;
  if (inflater_ == nullptr) return Keep(bytes);
  int status = 0;
  const Inflater::Verdict verdict =
      inflater_->Add(bytes, [&](absl::string_view inflated) {
        status = Keep(inflated);
        return status == 0;
      });
  switch (verdict) {
    case Inflater::Verdict::kOk:
    case Inflater::Verdict::kStopped:
      return status;
    case Inflater::Verdict::kTooLarge:
      return kTooLarge;
    case Inflater::Verdict::kBroken:
      break;
  }
  return kBadRequest;
}

int BodyReader::Keep(absl::string_view bytes) {
  if (bytes.size() > max_bytes_ - body_->size()) return kTooLarge;
  const size_t size = body_->size() + bytes.size();
  if (is_size_known_) {
    // Room for all of it costs nothing until it is written to.
    if (size > lease_.bytes() &&
        !lease_.Resize(std::min(max_bytes_, size + kStep), options_.patience)) {
      return kUnavailable;
    }
    if (body_->capacity() < max_bytes_) body_->reserve(max_bytes_);
  } else if (size > body_->capacity()) {
    // A string that is to hold more at least doubles.
    const size_t capacity = std::max({kStep, 2 * body_->capacity(), size});
    if (!lease_.Resize(capacity, options_.patience)) return kUnavailable;
    body_->reserve(capacity);
  }
  body_->append(bytes.data(), bytes.size());
  return 0;
}

}  // namespace treeline::http

#include "common/http/inflater.h"

#include <zlib.h>

#include <array>
#include <climits>

namespace treeline::http {
namespace {

constexpr size_t kPiece = 65536;
// The largest window, and gzip's frame alone.
constexpr int kGzipWindowBits = 15 + 16;

}  // namespace

struct Inflater::State {
  z_stream stream = {};
  bool is_ready = false;
  bool has_ended = false;
  size_t in = 0;
  size_t out = 0;
  std::array<char, kPiece> buffer;
};

Inflater::Inflater(const InflationLimit& limit)
    : limit_(limit), state_(std::make_unique<State>()) {
  state_->is_ready = inflateInit2(&state_->stream, kGzipWindowBits) == Z_OK;
}

Inflater::~Inflater() {
  if (state_->is_ready) inflateEnd(&state_->stream);
}

bool Inflater::is_complete() const { return state_->has_ended; }

Inflater::Verdict Inflater::Add(
    absl::string_view bytes,
    const std::function<bool(absl::string_view)>& sink) {
  if (bytes.empty()) return Verdict::kOk;
  if (!state_->is_ready || state_->has_ended || bytes.size() > UINT_MAX) {
    return Verdict::kBroken;
  }
  z_stream& stream = state_->stream;
  state_->in += bytes.size();
  // zlib does not write there.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  do {
    stream.next_out = reinterpret_cast<Bytef*>(state_->buffer.data());
    stream.avail_out = static_cast<uInt>(state_->buffer.size());
    const int result = inflate(&stream, Z_NO_FLUSH);
    // Z_BUF_ERROR: nothing was left to do.
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR) {
      return Verdict::kBroken;
    }
    const size_t got = state_->buffer.size() - stream.avail_out;
    state_->out += got;
    if (state_->out > limit_.floor_bytes + limit_.ratio * state_->in) {
      return Verdict::kTooLarge;
    }
    if (got > 0 && !sink(absl::string_view(state_->buffer.data(), got))) {
      return Verdict::kStopped;
    }
    if (result == Z_STREAM_END) {
      state_->has_ended = true;
      return stream.avail_in == 0 ? Verdict::kOk : Verdict::kBroken;
    }
  } while (stream.avail_in > 0 || stream.avail_out == 0);
  return Verdict::kOk;
}

}  // namespace treeline::http

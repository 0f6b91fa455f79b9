#include "common/tracing/otlp_client.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/base/status_macros.h"
#include "common/curl/curl_handles.h"

namespace treeline::tracing {
namespace {

// Of headers and body together: a collector's is a few bytes.
constexpr size_t kMaxAnswerBytes = 65536;
constexpr int kPoll_ms = 100;
constexpr std::chrono::seconds kLongestRetryAfter{60};

struct Answer {
  size_t bytes = 0;
  std::optional<std::chrono::milliseconds> retry_after;
};

size_t SkipBody(const char*, size_t size, size_t count, void* to) {
  auto* answer = static_cast<Answer*>(to);
  answer->bytes += size * count;
  // Anything else ends the transfer.
  return answer->bytes > kMaxAnswerBytes ? 0 : size * count;
}

size_t TakeHeader(const char* data, size_t size, size_t count, void* to) {
  constexpr absl::string_view kRetryAfter = "retry-after:";
  auto* answer = static_cast<Answer*>(to);
  absl::string_view line(data, size * count);
  answer->bytes += line.size();
  if (absl::StartsWithIgnoreCase(line, kRetryAfter)) {
    int seconds = 0;
    if (absl::SimpleAtoi(
            absl::StripAsciiWhitespace(line.substr(kRetryAfter.size())),
            &seconds) &&
        seconds >= 0) {
      answer->retry_after = std::min<std::chrono::seconds>(
          std::chrono::seconds(seconds), kLongestRetryAfter);
    }
  }
  return answer->bytes > kMaxAnswerBytes ? 0 : size * count;
}

absl::Status StatusOfHttp(long status) {
  if (status >= 200 && status < 300) return absl::OkStatus();
  const std::string message =
      absl::StrCat("the collector answers with HTTP status ", status);
  switch (status) {
    case 429:
    case 502:
    case 503:
    case 504:
      return absl::UnavailableError(message);
    default:
      return absl::FailedPreconditionError(message);
  }
}

}  // namespace

struct OtlpClient::Handles {
  curl::Multi multi;
  curl::Easy easy;
  curl::Headers headers;
  std::array<char, CURL_ERROR_SIZE> error{};
};

OtlpClient::OtlpClient(std::unique_ptr<Handles> handles)
    : handles_(std::move(handles)) {}

OtlpClient::~OtlpClient() = default;

absl::StatusOr<std::unique_ptr<OtlpClient>> OtlpClient::Open(
    const TracingOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  auto handles = std::make_unique<Handles>();
  handles->multi.reset(curl_multi_init());
  handles->easy.reset(curl_easy_init());
  if (handles->multi == nullptr || handles->easy == nullptr) {
    return absl::InternalError("libcurl gives no handle");
  }
  curl::AddHeader(handles->headers, "Content-Type: application/x-protobuf");
  // What is not asked for need not be waited for.
  curl::AddHeader(handles->headers, "Expect:");
  for (const auto& [name, value] : options.headers) {
    curl::AddHeader(handles->headers, absl::StrCat(name, ": ", value));
  }
  const auto set = [&](CURLoption option, auto value) {
    curl_easy_setopt(handles->easy.get(), option, value);
  };
  set(CURLOPT_URL, options.endpoint.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_POST, 1L);
  set(CURLOPT_HTTPHEADER, handles->headers.get());
  set(CURLOPT_ERRORBUFFER, handles->error.data());
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(options.timeout.count()));
  set(CURLOPT_WRITEFUNCTION, &SkipBody);
  set(CURLOPT_HEADERFUNCTION, &TakeHeader);
  if (!options.ca_file.empty()) set(CURLOPT_CAINFO, options.ca_file.c_str());
  return std::unique_ptr<OtlpClient>(new OtlpClient(std::move(handles)));
}

PostResult OtlpClient::Post(const std::string& message,
                            const std::function<bool()>& gives_up) {
  CURLM* const multi = handles_->multi.get();
  CURL* const easy = handles_->easy.get();
  Answer answer;
  handles_->error[0] = '\0';
  curl_easy_setopt(easy, CURLOPT_POSTFIELDS, message.data());
  curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE_LARGE,
                   static_cast<curl_off_t>(message.size()));
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, static_cast<void*>(&answer));
  curl_easy_setopt(easy, CURLOPT_HEADERDATA, static_cast<void*>(&answer));
  curl_multi_add_handle(multi, easy);
  int running = 1;
  bool gave_up = false;
  while (curl_multi_perform(multi, &running) == CURLM_OK && running > 0) {
    if (gives_up()) {
      gave_up = true;
      break;
    }
    curl_multi_poll(multi, nullptr, 0, kPoll_ms, nullptr);
  }
  CURLcode code = CURLE_OK;
  int left = 0;
  while (const CURLMsg* done = curl_multi_info_read(multi, &left)) {
    if (done->msg == CURLMSG_DONE) code = done->data.result;
  }
  long http_status = 0;
  curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &http_status);
  curl_multi_remove_handle(multi, easy);
  if (gave_up) return {absl::CancelledError("the program stops")};
  // It has said enough, where it says more than anybody reads.
  const bool has_answered = code == CURLE_OK || code == CURLE_WRITE_ERROR;
  if (has_answered && http_status > 0) {
    return {StatusOfHttp(http_status), answer.retry_after};
  }
  return {absl::UnavailableError(absl::StrCat(
      "the collector cannot be reached: ", handles_->error[0] != '\0'
                                               ? handles_->error.data()
                                               : curl_easy_strerror(code)))};
}

}  // namespace treeline::tracing

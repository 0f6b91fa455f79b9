#include "server/repository/http_get.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/curl/curl_handles.h"
#include "server/repository/web_url.h"

namespace treeline::repository {
namespace {

constexpr double kMinBytesPerMs = 1.024;
// So long at most between two looks at whether the transfer stalls.
constexpr std::chrono::milliseconds kLongestPoll{500};

absl::Status Unreachable(const std::string& url, absl::string_view why) {
  return base::WithReason(
      absl::UnavailableError(absl::StrCat(PublicUrl(url), ": ", why)),
      "SOURCE_UNREACHABLE");
}

// The first byte of "bytes 100-199/200".
std::optional<uint64_t> FirstByteOf(absl::string_view content_range) {
  uint64_t first = 0;
  if (!absl::ConsumePrefix(&content_range, "bytes ") ||
      !absl::SimpleAtoi(content_range.substr(0, content_range.find('-')),
                        &first)) {
    return std::nullopt;
  }
  return first;
}

// One request and its answer, without following redirects.
class Transfer {
 public:
  Transfer(const HttpGetRequest& request, const HttpOptions& options,
           const base::Clock& clock, HttpSink& sink)
      : request_(request), options_(options), clock_(clock), sink_(sink) {}

  absl::StatusOr<HttpGetResponse> Run(const std::stop_token& stop);
  // Where to look instead; empty: this is the answer.
  std::string Redirect() const;

 private:
  void SetUp();
  absl::Status Perform(const std::stop_token& stop);
  bool Stalled();
  absl::Status ErrorOf(CURLcode code) const;
  absl::Status StatusError(int status) const;
  absl::StatusOr<HttpGetResponse> Finish();

  absl::Status Begin(int status);
  static size_t OnBody(char* data, size_t size, size_t count, void* self);
  size_t Take(absl::string_view bytes);

  int StatusCode() const;
  std::string Header(const char* name) const;

  const HttpGetRequest& request_;
  const HttpOptions& options_;
  const base::Clock& clock_;
  HttpSink& sink_;
  std::array<char, CURL_ERROR_SIZE> error_{};
  curl::Headers headers_;
  curl::Easy easy_{curl_easy_init()};
  curl::Multi multi_{curl_multi_init()};
  bool begun_ = false;
  absl::Status sink_status_;
  base::MonotonicTime window_start_ = {};
  uint64_t window_bytes_ = 0;
};

void Transfer::SetUp() {
  CURL* easy = easy_.get();
  curl_easy_setopt(easy, CURLOPT_URL, request_.url.c_str());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, error_.data());
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS,
                   static_cast<long>(options_.connect_timeout.count()));
  curl_easy_setopt(easy, CURLOPT_USERAGENT,
                   absl::StrCat("treeline/", base::Version()).c_str());
  curl_easy_setopt(easy, CURLOPT_SSL_VERIFYPEER, 1L);
  curl_easy_setopt(easy, CURLOPT_SSL_VERIFYHOST, 2L);
  curl_easy_setopt(easy, CURLOPT_SSLVERSION, CURL_SSLVERSION_TLSv1_2);
  if (!options_.ca_file.empty()) {
    curl_easy_setopt(easy, CURLOPT_CAINFO, options_.ca_file.c_str());
    curl_easy_setopt(easy, CURLOPT_CAPATH, nullptr);
  }
  if (request_.offset > 0) {
    curl_easy_setopt(easy, CURLOPT_RANGE,
                     absl::StrCat(request_.offset, "-").c_str());
  }
  if (!request_.etag.empty()) {
    curl::AddHeader(headers_, absl::StrCat("If-None-Match: ", request_.etag));
    curl_easy_setopt(easy, CURLOPT_HTTPHEADER, headers_.get());
  }
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, &Transfer::OnBody);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, this);
  curl_multi_add_handle(multi_.get(), easy);
}

absl::StatusOr<HttpGetResponse> Transfer::Run(const std::stop_token& stop) {
  SetUp();
  const absl::Status performed = Perform(stop);
  if (performed.code() == absl::StatusCode::kCancelled) {
    // Do not wait for the thread that resolves the name.
    curl_easy_setopt(easy_.get(), CURLOPT_QUICK_EXIT, 1L);
  }
  curl_multi_remove_handle(multi_.get(), easy_.get());
  TL_RETURN_IF_ERROR(performed);
  return Finish();
}

absl::Status Transfer::Perform(const std::stop_token& stop) {
  const std::stop_callback wake(stop,
                                [this] { curl_multi_wakeup(multi_.get()); });
  window_start_ = clock_.Now();
  while (true) {
    if (stop.stop_requested()) return absl::CancelledError("cancelled");
    int running = 0;
    curl_multi_perform(multi_.get(), &running);
    int left = 0;
    if (const CURLMsg* message = curl_multi_info_read(multi_.get(), &left);
        message != nullptr) {
      return ErrorOf(message->data.result);
    }
    if (Stalled()) {
      return Unreachable(request_.url,
                         absl::StrCat("hardly anything came for ",
                                      options_.stall_timeout.count(), " ms"));
    }
    const auto wait = std::min(kLongestPoll, options_.stall_timeout / 4);
    curl_multi_poll(multi_.get(), nullptr, 0,
                    static_cast<int>(wait.count()) + 1, nullptr);
  }
}

bool Transfer::Stalled() {
  const base::MonotonicTime now = clock_.Now();
  const double window_ms = base::MillisecondsBetween(window_start_, now);
  if (window_ms < static_cast<double>(options_.stall_timeout.count())) {
    return false;
  }
  const bool stalled =
      static_cast<double>(window_bytes_) < kMinBytesPerMs * window_ms;
  window_start_ = now;
  window_bytes_ = 0;
  return stalled;
}

absl::Status Transfer::ErrorOf(CURLcode code) const {
  if (!sink_status_.ok()) return sink_status_;
  switch (code) {
    case CURLE_OK:
      return absl::OkStatus();
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
    case CURLE_SSL_ISSUER_ERROR:
    case CURLE_SSL_CRL_BADFILE:
      return base::WithReason(
          absl::FailedPreconditionError(
              absl::StrCat(PublicUrl(request_.url), ": ", error_.data())),
          "SOURCE_UNTRUSTED");
    default:
      return Unreachable(request_.url, error_[0] != '\0'
                                           ? error_.data()
                                           : curl_easy_strerror(code));
  }
}

int Transfer::StatusCode() const {
  long status = 0;
  curl_easy_getinfo(easy_.get(), CURLINFO_RESPONSE_CODE, &status);
  return static_cast<int>(status);
}

std::string Transfer::Header(const char* name) const {
  curl_header* header = nullptr;
  if (curl_easy_header(easy_.get(), name, 0, CURLH_HEADER, -1, &header) !=
      CURLHE_OK) {
    return "";
  }
  return header->value;
}

std::string Transfer::Redirect() const {
  const int status = StatusCode();
  char* location = nullptr;
  if (status < 301 || status > 308 || status == 304 ||
      curl_easy_getinfo(easy_.get(), CURLINFO_REDIRECT_URL, &location) !=
          CURLE_OK ||
      location == nullptr) {
    return "";
  }
  return location;
}

size_t Transfer::OnBody(char* data, size_t size, size_t count, void* self) {
  return static_cast<Transfer*>(self)->Take(
      absl::string_view(data, size * count));
}

size_t Transfer::Take(absl::string_view bytes) {
  window_bytes_ += bytes.size();
  const int status = StatusCode();
  // What error pages say is not looked at.
  if (status != 200 && status != 206) return bytes.size();
  if (!begun_) sink_status_ = Begin(status);
  if (sink_status_.ok()) sink_status_ = sink_.Write(bytes);
  return sink_status_.ok() ? bytes.size() : 0;
}

absl::Status Transfer::Begin(int status) {
  begun_ = true;
  if (status == 200) return sink_.Begin(0);
  const std::optional<uint64_t> first = FirstByteOf(Header("content-range"));
  if (request_.offset == 0 || first != request_.offset) {
    return base::WithReason(
        absl::OutOfRangeError(absl::StrCat(PublicUrl(request_.url),
                                           ": answered with another range")),
        "RANGE_REFUSED");
  }
  return sink_.Begin(request_.offset);
}

absl::Status Transfer::StatusError(int status) const {
  const std::string message =
      absl::StrCat(PublicUrl(request_.url), ": HTTP status ", status);
  if (status == 416) {
    return base::WithReason(absl::OutOfRangeError(message), "RANGE_REFUSED");
  }
  if (status == 404 || status == 410) {
    return base::WithReason(absl::NotFoundError(message),
                            "SOURCE_FILE_MISSING");
  }
  if (status == 401 || status == 403) {
    return base::WithReason(absl::PermissionDeniedError(message),
                            "SOURCE_REFUSED");
  }
  if (status != 408 && status != 429 && status < 500) {
    return base::WithReason(absl::FailedPreconditionError(message),
                            "SOURCE_REFUSED");
  }
  absl::Status error =
      Unreachable(request_.url, absl::StrCat("HTTP status ", status));
  curl_off_t retry_after_s = 0;
  curl_easy_getinfo(easy_.get(), CURLINFO_RETRY_AFTER, &retry_after_s);
  if (retry_after_s <= 0) return error;
  constexpr curl_off_t kDay_s = 86400;
  return base::WithRetryAfter(
      std::move(error), std::chrono::seconds(std::min(retry_after_s, kDay_s)));
}

absl::StatusOr<HttpGetResponse> Transfer::Finish() {
  HttpGetResponse response{.status = StatusCode(), .etag = Header("etag")};
  const bool not_modified = response.status == 304 && !request_.etag.empty();
  if (not_modified || !Redirect().empty()) return response;
  if (response.status != 200 && response.status != 206) {
    return StatusError(response.status);
  }
  // A file of no bytes has no first one.
  if (!begun_) TL_RETURN_IF_ERROR(Begin(response.status));
  return response;
}

}  // namespace

absl::Status HttpOptions::Validate() const {
  if (connect_timeout.count() < 1 || stall_timeout.count() < 1) {
    return absl::InvalidArgumentError("time-outs must be positive");
  }
  if (max_redirects < 0 || max_redirects > 50) {
    return absl::InvalidArgumentError("redirects must be 0 to 50");
  }
  return absl::OkStatus();
}

absl::StatusOr<HttpGetResponse> HttpGet(const HttpGetRequest& request,
                                        const HttpOptions& options,
                                        const base::Clock& clock,
                                        HttpSink& sink,
                                        const std::stop_token& stop) {
  HttpGetRequest next = request;
  for (int redirects = 0; redirects <= options.max_redirects; ++redirects) {
    TL_RETURN_IF_ERROR(CheckTransport(next.url, options.allow_plain_http));
    Transfer transfer(next, options, clock, sink);
    TL_ASSIGN_OR_RETURN(HttpGetResponse response, transfer.Run(stop));
    const std::string location = transfer.Redirect();
    if (location.empty()) return response;
    if (IsHttps(next.url) && !IsHttps(location)) {
      return base::WithReason(
          absl::FailedPreconditionError(absl::StrCat(
              PublicUrl(next.url), ": redirects to what is not encrypted")),
          "SOURCE_UNTRUSTED");
    }
    next.url = location;
  }
  return base::WithReason(absl::FailedPreconditionError(absl::StrCat(
                              PublicUrl(request.url), ": more than ",
                              options.max_redirects, " redirects")),
                          "SOURCE_REFUSED");
}

}  // namespace treeline::repository

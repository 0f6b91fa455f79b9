#include "client/bench/http_transport.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/relocalizer/token_source.h"
#include "common/base/clock.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/curl/curl_handles.h"

namespace treeline::bench {
namespace {

constexpr int kPollMs = 1000;
constexpr size_t kMaxAnswerBytes = size_t{64} << 20;

// What does not change from call to call.
struct Endpoint {
  Target target = Target::kConnect;
  std::vector<std::string> urls;
  relocalizer::ClientTlsOptions tls;
  std::unique_ptr<relocalizer::TokenSource> token;  // null: none
  std::vector<std::string> bodies;
};

// A call; `easy` and what curl writes belong to the transport's thread.
struct Exchange {
  size_t number = 0;
  size_t item = 0;
  base::MonotonicTime due = {};
  Transport::Done done;
  std::atomic<bool> cancelled = false;
  curl::Headers headers;
  std::string answer;
  std::array<char, CURL_ERROR_SIZE> error{};
};

size_t TakeAnswer(const char* data, size_t size, size_t count, void* to) {
  auto* exchange = static_cast<Exchange*>(to);
  if (exchange->answer.size() + size * count > kMaxAnswerBytes) return 0;
  exchange->answer.append(data, size * count);
  return size * count;
}

absl::Status StatusOf(CURLcode code, const Exchange& exchange) {
  const std::string why = exchange.error[0] != '\0' ? exchange.error.data()
                                                    : curl_easy_strerror(code);
  return code == CURLE_OPERATION_TIMEDOUT ? absl::DeadlineExceededError(why)
                                          : absl::UnavailableError(why);
}

class HttpTransport final : public Transport {
 public:
  HttpTransport(Endpoint endpoint, int max_connections)
      : endpoint_(std::move(endpoint)), multi_(curl_multi_init()) {
    curl_multi_setopt(multi_.get(), CURLMOPT_MAX_TOTAL_CONNECTIONS,
                      static_cast<long>(max_connections));
    curl_multi_setopt(multi_.get(), CURLMOPT_MAXCONNECTS,
                      static_cast<long>(max_connections));
    thread_ = std::thread([this] { Run(); });
  }

  ~HttpTransport() override {
    stopped_ = true;
    curl_multi_wakeup(multi_.get());
    thread_.join();
  }

  std::shared_ptr<PendingCall> Ask(size_t number, size_t item,
                                   std::chrono::nanoseconds timeout,
                                   Done done) override;

 private:
  class Handle;
  using ExchangePtr = std::shared_ptr<Exchange>;
  struct Running {
    curl::Easy easy;
    ExchangePtr exchange;
  };

  void Run();
  void StartNew();
  void Start(ExchangePtr exchange);
  void SetUp(CURL* easy, Exchange& exchange, int64_t timeout_ms);
  void EndCancelled();
  void EndFinished();
  void End(const ExchangePtr& exchange, CURLcode code, long http_status);

  const Endpoint endpoint_;
  const curl::Multi multi_;
  std::atomic<bool> stopped_ = false;
  std::atomic<bool> any_cancelled_ = false;
  std::mutex mutex_;
  std::deque<ExchangePtr> new_;  // by mutex_
  // Of the thread.
  std::unordered_map<CURL*, Running> running_;
  std::vector<curl::Easy> idle_;
  std::thread thread_;
};

class HttpTransport::Handle final : public PendingCall {
 public:
  Handle(HttpTransport& transport, std::weak_ptr<Exchange> exchange)
      : transport_(transport), exchange_(std::move(exchange)) {}
  void Cancel() override {
    const ExchangePtr exchange = exchange_.lock();
    if (exchange == nullptr) return;  // over
    exchange->cancelled = true;
    transport_.any_cancelled_ = true;
    curl_multi_wakeup(transport_.multi_.get());
  }

 private:
  HttpTransport& transport_;
  const std::weak_ptr<Exchange> exchange_;
};

std::shared_ptr<Transport::PendingCall> HttpTransport::Ask(
    size_t number, size_t item, std::chrono::nanoseconds timeout, Done done) {
  auto exchange = std::make_shared<Exchange>();
  exchange->number = number;
  exchange->item = item;
  exchange->due =
      base::SteadyClock().Now() +
      std::chrono::duration_cast<base::MonotonicTime::duration>(timeout);
  exchange->done = std::move(done);
  auto handle = std::make_shared<Handle>(*this, exchange);
  {
    const std::lock_guard lock(mutex_);
    new_.push_back(std::move(exchange));
  }
  curl_multi_wakeup(multi_.get());
  return handle;
}

void HttpTransport::Run() {
  while (!stopped_) {
    StartNew();
    int running = 0;
    curl_multi_perform(multi_.get(), &running);
    EndFinished();
    if (any_cancelled_.exchange(false)) EndCancelled();
    curl_multi_poll(multi_.get(), nullptr, 0, kPollMs, nullptr);
  }
}

void HttpTransport::StartNew() {
  std::deque<ExchangePtr> starting;
  {
    const std::lock_guard lock(mutex_);
    starting.swap(new_);
  }
  for (ExchangePtr& exchange : starting) Start(std::move(exchange));
}

void HttpTransport::Start(ExchangePtr exchange) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(
      exchange->due - base::SteadyClock().Now());
  if (exchange->cancelled || left.count() <= 0) {
    End(exchange, CURLE_OPERATION_TIMEDOUT, 0);
    return;
  }
  Running running{.easy = nullptr, .exchange = std::move(exchange)};
  if (idle_.empty()) {
    running.easy.reset(curl_easy_init());
  } else {
    running.easy = std::move(idle_.back());
    idle_.pop_back();
  }
  CURL* easy = running.easy.get();
  SetUp(easy, *running.exchange, left.count());
  curl_multi_add_handle(multi_.get(), easy);
  running_[easy] = std::move(running);
}

void HttpTransport::SetUp(CURL* easy, Exchange& exchange, int64_t timeout_ms) {
  const Target target = endpoint_.target;
  const std::string& body = endpoint_.bodies[exchange.item];
  const std::string& url =
      endpoint_.urls[exchange.number % endpoint_.urls.size()];
  curl::AddHeader(exchange.headers,
                  absl::StrCat("Content-Type: ", ContentTypeOf(target)));
  curl::AddHeader(exchange.headers, absl::StrCat("Accept: ", AcceptOf(target)));
  // Or curl waits for a word of the server before it sends a large body.
  curl::AddHeader(exchange.headers, "Expect:");
  if (target != Target::kGeoPose) {
    curl::AddHeader(exchange.headers, "Connect-Protocol-Version: 1");
    curl::AddHeader(exchange.headers,
                    absl::StrCat("Connect-Timeout-Ms: ", timeout_ms));
  }
  if (endpoint_.token != nullptr) {
    curl::AddHeader(exchange.headers, absl::StrCat("Authorization: Bearer ",
                                                   endpoint_.token->Get()));
  }
  curl_easy_reset(easy);
  // In the clear it goes to this machine, and not by way of another.
  if (endpoint_.token != nullptr && endpoint_.tls.ca_file.empty()) {
    curl_easy_setopt(easy, CURLOPT_NOPROXY, "*");
  }
  curl_easy_setopt(easy, CURLOPT_URL, url.c_str());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(timeout_ms));
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, exchange.headers.get());
  curl_easy_setopt(easy, CURLOPT_POSTFIELDS, body.data());
  curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE_LARGE,
                   static_cast<curl_off_t>(body.size()));
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, &TakeAnswer);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, static_cast<void*>(&exchange));
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, exchange.error.data());
  const relocalizer::ClientTlsOptions& tls = endpoint_.tls;
  if (!tls.ca_file.empty()) {
    curl_easy_setopt(easy, CURLOPT_CAINFO, tls.ca_file.c_str());
  }
  if (!tls.certificate_file.empty()) {
    curl_easy_setopt(easy, CURLOPT_SSLCERT, tls.certificate_file.c_str());
    curl_easy_setopt(easy, CURLOPT_SSLKEY, tls.key_file.c_str());
  }
}

void HttpTransport::EndFinished() {
  int left = 0;
  while (const CURLMsg* message = curl_multi_info_read(multi_.get(), &left)) {
    if (message->msg != CURLMSG_DONE) continue;
    const CURLcode code = message->data.result;
    auto node = running_.extract(message->easy_handle);
    Running& running = node.mapped();
    long http_status = 0;
    curl_easy_getinfo(running.easy.get(), CURLINFO_RESPONSE_CODE, &http_status);
    curl_multi_remove_handle(multi_.get(), running.easy.get());
    idle_.push_back(std::move(running.easy));
    End(running.exchange, code, http_status);
  }
}

void HttpTransport::EndCancelled() {
  for (auto at = running_.begin(); at != running_.end();) {
    if (!at->second.exchange->cancelled) {
      ++at;
      continue;
    }
    Running running = std::move(at->second);
    at = running_.erase(at);
    // Not to be used again: the connection goes with it.
    curl_multi_remove_handle(multi_.get(), running.easy.get());
    const Done done = std::exchange(running.exchange->done, nullptr);
    running.easy.reset();
    done({.status = absl::CancelledError("cancelled by this client")});
  }
}

void HttpTransport::End(const ExchangePtr& exchange, CURLcode code,
                        long http_status) {
  const Done done = std::exchange(exchange->done, nullptr);
  Reply reply;
  v1::LocalizeResponse response;
  if (exchange->cancelled) {
    reply.status = absl::CancelledError("cancelled by this client");
  } else if (code != CURLE_OK) {
    reply.status = StatusOf(code, *exchange);
  } else {
    absl::StatusOr<v1::LocalizeResponse> parsed =
        ParseHttpAnswer(endpoint_.target, http_status, exchange->answer);
    reply.status = parsed.status();
    if (parsed.ok()) {
      response = *std::move(parsed);
      reply.response = &response;
    }
    reply.pushback = base::RetryAfterOf(reply.status).has_value();
  }
  done(reply);
}

// Stricter than ConnectOptions::Validate(): gRPC's "unix:80" is a socket file,
// and here a host.
absl::Status CheckAddress(absl::string_view address,
                          const relocalizer::ConnectOptions& options,
                          bool has_token) {
  if (!relocalizer::IsUrlHost(address)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "\"", address, "\" is no address over HTTP: write HOST:PORT"));
  }
  if (has_token && options.tls.ca_file.empty() &&
      !relocalizer::IsUrlHostOnThisMachine(address)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a token would travel to ", address, " in the clear; use TLS"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<Transport>> MakeHttpTransport(
    Target target, const relocalizer::ConnectOptions& options,
    int max_connections, const std::vector<WorkItem>& items) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (!options.tls.server_name.empty()) {
    return absl::InvalidArgumentError(
        "--tls-server-name is for gRPC alone; over HTTP the certificate must "
        "have the host's own name");
  }
  Endpoint endpoint{.target = target,
                    .urls = {},
                    .tls = options.tls,
                    .token = nullptr,
                    .bodies = {}};
  TL_ASSIGN_OR_RETURN(endpoint.token, relocalizer::TokenSource::Open(options));
  for (const absl::string_view address : absl::StrSplit(options.server, ',')) {
    TL_RETURN_IF_ERROR(
        CheckAddress(address, options, endpoint.token != nullptr));
    endpoint.urls.push_back(
        absl::StrCat(options.tls.ca_file.empty() ? "http://" : "https://",
                     address, PathOf(target)));
  }
  for (const WorkItem& item : items) {
    TL_ASSIGN_OR_RETURN(std::string body, HttpBody(target, item));
    endpoint.bodies.push_back(std::move(body));
  }
  return std::make_unique<HttpTransport>(std::move(endpoint), max_connections);
}

}  // namespace treeline::bench

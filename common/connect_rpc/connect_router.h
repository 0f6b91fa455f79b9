// The Connect protocol: POST /PACKAGE.SERVICE/METHOD with a message as JSON or
// binary; unary methods and those whose server streams.
// https://connectrpc.com/docs/protocol
#ifndef COMMON_CONNECT_RPC_CONNECT_ROUTER_H_
#define COMMON_CONNECT_RPC_CONNECT_ROUTER_H_

#include <google/protobuf/message.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/connect_rpc/connect_stream.h"
#include "common/http/http_message.h"

namespace treeline::connect_rpc {

struct ConnectRouterOptions {
  // Whether calls without the header Connect-Protocol-Version are refused. No
  // page of another origin can send it, or one of the protocol's content
  // types, unless its preflight is answered.
  bool require_protocol_version = false;
  // Larger bodies are refused before anything is built from them: a byte of a
  // body may become a hundred of a message.
  size_t max_request_bytes = size_t{64} << 10;
  // What messages are held by while they are parsed, and then until they are
  // answered, beside the body; nullptr: without a bound. Must outlive the
  // router.
  base::ByteBudget* budget = nullptr;
  // See ConnectStream.
  std::chrono::milliseconds heartbeat{5000};
};

// What a method sees of a call beside its message.
struct ConnectCall {
  const http::HttpRequest& request;
  // From Connect-Timeout-Ms.
  base::MonotonicTime deadline = base::MonotonicTime::max();
};

// Whether a call is let in, by its head alone. May note in `request` who calls.
using AdmitCall = std::function<absl::Status(http::HttpRequest& request)>;

// Methods are added before it serves; then it is thread-safe.
class ConnectRouter {
 public:
  using Message = google::protobuf::Message;

  explicit ConnectRouter(const base::Clock& clock,
                         const ConnectRouterOptions& options = {})
      : clock_(clock), options_(options) {}

  // path: "/treeline.v1.NavigationService/Pause". `call` as
  // absl::StatusOr<Response>(const ConnectCall&, const Request&). `admit`:
  // null: everyone is let in.
  template <typename Request, typename Call>
  void AddUnary(const std::string& path, Call call, AdmitCall admit = nullptr) {
    Method& method = NewMethod<Request>(path);
    method.admit = std::move(admit);
    method.unary = [call = std::move(call)](const ConnectCall& about,
                                            const Message& request)
        -> absl::StatusOr<std::unique_ptr<Message>> {
      auto response = call(about, static_cast<const Request&>(request));
      if (!response.ok()) return response.status();
      using Response = typename decltype(response)::value_type;
      return std::make_unique<Response>(*std::move(response));
    };
  }
  // `call` as absl::Status(const Request&, ConnectStream&); it returns once the
  // stream is gone. Empty Responses may stand between those that it writes.
  template <typename Request, typename Response, typename Call>
  void AddStream(const std::string& path, Call call) {
    Method& method = NewMethod<Request>(path);
    method.response = std::make_unique<Response>();
    method.stream = [call = std::move(call)](const Message& request,
                                             ConnectStream& stream) {
      return call(static_cast<const Request&>(request), stream);
    };
  }

  // A method that is not served here: `why`.
  void AddUnimplemented(const std::string& path, absl::string_view why);

  // Whether `path` is one of a package of ours.
  static bool Owns(absl::string_view path);

  // Answers unknown methods (404), what is not POST (405), methods that are not
  // served here (501), other types (415) and other versions (400).
  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) const;

  // For requests that CheckHead lets through, before the body is read: see
  // HttpHandler::Admit.
  std::optional<http::HttpResponse> Admit(http::HttpRequest& request) const;

  // For requests that both let through. Bodies that are too large get 413;
  // other errors as the protocol has them.
  http::HttpResponse Handle(const http::HttpRequest& request) const;

 private:
  struct Method {
    // Null of one that is not served here; `refusal` says why.
    std::unique_ptr<const Message> request;
    absl::Status refusal;
    AdmitCall admit;
    std::function<absl::StatusOr<std::unique_ptr<Message>>(const ConnectCall&,
                                                           const Message&)>
        unary;
    // Of a stream; else null.
    std::unique_ptr<const Message> response;
    std::function<absl::Status(const Message&, ConnectStream&)> stream;
  };

  // A request's message, and what it takes of the budget.
  struct Parsed {
    base::ByteLease lease;
    std::unique_ptr<Message> message;
  };

  template <typename Request>
  Method& NewMethod(const std::string& path) {
    Method& method = methods_[path];
    method.request = std::make_unique<Request>();
    return method;
  }
  absl::StatusOr<Parsed> Parse(const Method& method, bool is_json,
                               absl::string_view bytes) const;
  absl::StatusOr<http::HttpResponse> Unary(
      const Method& method, const http::HttpRequest& request) const;
  http::HttpResponse Stream(const Method& method,
                            const http::HttpRequest& request) const;
  absl::Status RunStream(const Method& method, const Message& request,
                         const ConnectStream::Options& options,
                         http::HttpBodyWriter& writer) const;

  const base::Clock& clock_;
  const ConnectRouterOptions options_;
  std::map<std::string, Method> methods_;
};

// From the header Connect-Timeout-Ms; MonotonicTime::max() without it.
// INVALID_ARGUMENT: it is not 1 to 10 digits.
absl::StatusOr<base::MonotonicTime> ConnectDeadline(
    const http::HttpRequest& request);

}  // namespace treeline::connect_rpc

#endif  // COMMON_CONNECT_RPC_CONNECT_ROUTER_H_

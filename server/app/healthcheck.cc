#include "server/app/healthcheck.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/byte_buffer.h>

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/wire/status.h"
#include "server/service/scene_health.h"

namespace treeline::server_app {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

constexpr char kMethod[] = "/grpc.health.v1.Health/Check";
constexpr int kServing = 1;

std::string NameOf(int serving_status) {
  switch (serving_status) {
    case 0:
      return "UNKNOWN";
    case kServing:
      return "SERVING";
    case 2:
      return "NOT_SERVING";
    case 3:
      return "SERVICE_UNKNOWN";
    default:
      return absl::StrCat("status ", serving_status);
  }
}

struct Connection {
  // The server itself is asked, not a proxy of the environment for it.
  Connection() { arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0); }

  std::shared_ptr<grpc::ChannelCredentials> credentials;
  grpc::ChannelArguments arguments;
};

absl::StatusOr<Connection> ConnectionOf(const HealthcheckOptions& options) {
  Connection connection;
  if (options.tls_ca.empty()) {
    connection.credentials = grpc::InsecureChannelCredentials();
    return connection;
  }
  grpc::SslCredentialsOptions tls;
  TL_ASSIGN_OR_RETURN(tls.pem_root_certs,
                      base::ReadFile(options.tls_ca, 1 << 20));
  if (!options.tls_cert.empty()) {
    TL_ASSIGN_OR_RETURN(tls.pem_cert_chain,
                        base::ReadFile(options.tls_cert, 1 << 20));
    TL_ASSIGN_OR_RETURN(tls.pem_private_key,
                        base::ReadFile(options.tls_key, 1 << 20));
  }
  connection.credentials = grpc::SslCredentials(tls);
  if (!options.tls_name.empty()) {
    connection.arguments.SetSslTargetNameOverride(options.tls_name);
  }
  return connection;
}

// One unary call of bytes.
absl::StatusOr<std::string> Ask(grpc::GenericStub& stub,
                                const std::string& request_bytes,
                                double timeout_s) {
  grpc::ClientContext context;
  context.set_deadline(
      std::chrono::system_clock::now() +
      std::chrono::microseconds(static_cast<int64_t>(timeout_s * 1e6)));
  const grpc::Slice slice(request_bytes);
  const grpc::ByteBuffer request(&slice, 1);
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareUnaryCall(&context, kMethod, request, &queue);
  call->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  call->Finish(&response, &status, /*tag=*/nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  if (!status.ok()) return wire::FromGrpc(status);
  std::vector<grpc::Slice> slices;
  if (!response.Dump(&slices).ok()) {
    return absl::UnavailableError("the answer cannot be read");
  }
  std::string bytes;
  for (const grpc::Slice& part : slices) {
    bytes.append(reinterpret_cast<const char*>(part.begin()), part.size());
  }
  return bytes;
}

}  // namespace

std::string EncodeHealthRequest(absl::string_view service) {
  // Field 1, a string; absent if it is empty.
  if (service.empty()) return "";
  std::string bytes(1, '\x0a');
  uint64_t length = service.size();
  for (; length >= 0x80; length >>= 7) {
    bytes.push_back(static_cast<char>((length & 0x7f) | 0x80));
  }
  bytes.push_back(static_cast<char>(length));
  absl::StrAppend(&bytes, service);
  return bytes;
}

absl::StatusOr<int> DecodeHealthResponse(absl::string_view bytes) {
  CodedInputStream input(reinterpret_cast<const uint8_t*>(bytes.data()),
                         static_cast<int>(bytes.size()));
  uint32_t status = 0;
  while (const uint32_t tag = input.ReadTag()) {
    const bool is_status = tag == (1 << 3);  // field 1, a varint
    if (is_status ? !input.ReadVarint32(&status)
                  : !WireFormatLite::SkipField(&input, tag)) {
      return absl::InvalidArgumentError("not a HealthCheckResponse");
    }
  }
  if (!input.ConsumedEntireMessage()) {
    return absl::InvalidArgumentError("not a HealthCheckResponse");
  }
  return static_cast<int>(status);
}

absl::Status CheckHealth(const HealthcheckOptions& options) {
  TL_ASSIGN_OR_RETURN(const Connection connection, ConnectionOf(options));
  grpc::GenericStub stub(grpc::CreateCustomChannel(
      options.server, connection.credentials, connection.arguments));
  const std::string service =
      options.scene.empty() ? "" : service::HealthServiceOf(options.scene);
  const auto answer =
      Ask(stub, EncodeHealthRequest(service), options.timeout_s);
  if (!answer.ok()) return answer.status();
  const auto status = DecodeHealthResponse(*answer);
  if (!status.ok()) return absl::UnavailableError(status.status().message());
  if (*status == kServing) return absl::OkStatus();
  return absl::UnavailableError(NameOf(*status));
}

}  // namespace treeline::server_app

#include "client/relocalizer/connect_options.h"

#include <arpa/inet.h>

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"

namespace treeline::relocalizer {
namespace {

struct HostAndPort {
  std::string host;  // without brackets
  std::string port;
};

std::string Text(absl::string_view text) { return {text.data(), text.size()}; }

// "127.0.0.1:1" or "[::1]:1"; without a port, that is empty.
HostAndPort Split(absl::string_view address) {
  const size_t colon = address.rfind(':');
  const size_t bracket = address.rfind(']');
  const bool has_port = colon != absl::string_view::npos &&
                        (bracket == absl::string_view::npos || colon > bracket);
  absl::string_view host = has_port ? address.substr(0, colon) : address;
  if (absl::ConsumePrefix(&host, "[")) absl::ConsumeSuffix(&host, "]");
  return {.host = Text(host),
          .port = has_port ? Text(address.substr(colon + 1)) : ""};
}

bool IsAddress(int family, const std::string& host) {
  unsigned char ignored[sizeof(in6_addr)];
  return inet_pton(family, host.c_str(), ignored) == 1;
}

bool IsPort(const std::string& port) {
  int number = 0;
  return absl::SimpleAtoi(port, &number) && number >= 1 && number <= 65535;
}

absl::Status CheckListed(const std::string& address, int family) {
  const HostAndPort parts = Split(address);
  if (!IsPort(parts.port)) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", address,
                     "\" has no port; several servers are given "
                     "as ADDRESS:PORT,ADDRESS:PORT"));
  }
  if (!IsAddress(family, parts.host)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "\"", address,
        "\": several servers are given by their IP addresses, "
        "all of one family; one name for all of them is dns:///NAME:PORT"));
  }
  return absl::OkStatus();
}

// What is behind the host must be a port: others may read "127.0.0.1:1@robot"
// as a user's name on another host.
bool IsAddressOnThisMachine(absl::string_view address) {
  const auto [host, port] = Split(address);
  return (port.empty() || IsPort(port)) &&
         (host == "localhost" || host == "::1" ||
          (IsAddress(AF_INET, host) && absl::StartsWith(host, "127.")));
}

// gRPC would look for a host of the whole name, or for the port 0.
absl::Status CheckSingle(const std::string& address) {
  for (const char* scheme : {"http://", "https://", "grpc://", "grpcs://"}) {
    if (absl::StartsWithIgnoreCase(address, scheme)) {
      return absl::InvalidArgumentError(
          absl::StrCat("\"", address,
                       "\" is a web address; a server is given as HOST:PORT, ",
                       "the port that it says it is \"listening on\""));
    }
  }
  if (absl::StrContains(address, ":///") || !Split(address).port.empty()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "\"", address, "\" has no port; give HOST:PORT, for instance ", address,
      absl::EndsWith(address, ":") ? "" : ":", "50051"));
}

absl::Status OutOfRange(absl::string_view name, int value, int high) {
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; it must be 1..", high));
}

}  // namespace

absl::StatusOr<std::string> GrpcTarget(absl::string_view server) {
  const std::vector<std::string> addresses = absl::StrSplit(server, ',');
  if (addresses.size() == 1) {
    TL_RETURN_IF_ERROR(CheckSingle(addresses.front()));
    return addresses.front();
  }
  const bool six = absl::StartsWith(server, "[");
  for (const std::string& address : addresses) {
    TL_RETURN_IF_ERROR(CheckListed(address, six ? AF_INET6 : AF_INET));
  }
  return absl::StrCat(six ? "ipv6:" : "ipv4:", server);
}

bool IsOnThisMachine(absl::string_view server) {
  if (absl::StartsWith(server, "unix:")) return true;
  for (const char* scheme : {"ipv4:", "ipv6:", "dns:///"}) {
    if (absl::ConsumePrefix(&server, scheme)) break;
  }
  const std::vector<std::string> addresses = absl::StrSplit(server, ',');
  return std::all_of(addresses.begin(), addresses.end(),
                     [](const std::string& address) {
                       return IsAddressOnThisMachine(address);
                     });
}

bool IsUrlHost(absl::string_view address) {
  const auto [host, port] = Split(address);
  if (host.empty() || absl::EndsWith(address, ":")) return false;
  if (!port.empty() && !IsPort(port)) return false;
  if (absl::StartsWith(address, "[")) return IsAddress(AF_INET6, host);
  return std::all_of(host.begin(), host.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' ||
           c == '-' || c == '_';
  });
}

bool IsUrlHostOnThisMachine(absl::string_view address) {
  return IsUrlHost(address) && IsAddressOnThisMachine(address);
}

absl::Status ConnectOptions::Validate() const {
  if (server.empty()) {
    return absl::InvalidArgumentError(
        "no server given; for instance 127.0.0.1:50051");
  }
  TL_RETURN_IF_ERROR(GrpcTarget(server).status());
  if (max_attempts < 1 || max_attempts > 5) {
    return OutOfRange("max_attempts", max_attempts, 5);
  }
  if (max_message_mib < 1 || max_message_mib > 1024) {
    return OutOfRange("max_message_mib", max_message_mib, 1024);
  }
  if (tls.certificate_file.empty() != tls.key_file.empty()) {
    return absl::InvalidArgumentError(
        "a client's certificate and its key go together");
  }
  if (tls.ca_file.empty() &&
      !(tls.certificate_file.empty() && tls.server_name.empty())) {
    return absl::InvalidArgumentError(
        "a client's certificate or a server's name need the certificates that "
        "are trusted");
  }
  if (!token_file.empty() && !token_variable.empty()) {
    return absl::InvalidArgumentError("two tokens given");
  }
  if (tls.ca_file.empty() && !(token_file.empty() && token_variable.empty()) &&
      !IsOnThisMachine(server)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a token would travel to ", server, " in the clear; use TLS"));
  }
  return absl::OkStatus();
}

}  // namespace treeline::relocalizer

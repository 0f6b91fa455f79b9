#include "common/base/listen_address.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace treeline::base {
namespace {

struct AddressListDeleter {
  void operator()(addrinfo* list) const { freeaddrinfo(list); }
};

absl::Status Malformed(absl::string_view text, absl::string_view problem) {
  return absl::InvalidArgumentError(
      absl::StrCat("address '", text, "' ", problem,
                   "; give HOST:PORT, for instance 127.0.0.1:50051"));
}

// 0, or errno of the first call that failed.
int BindOnce(const addrinfo& candidate) {
  const int fd =
      socket(candidate.ai_family, candidate.ai_socktype | SOCK_CLOEXEC,
             candidate.ai_protocol);
  if (fd < 0) return errno;
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  int error = 0;
  if (bind(fd, candidate.ai_addr, candidate.ai_addrlen) != 0 ||
      listen(fd, 1) != 0) {
    error = errno;
  }
  close(fd);
  return error;
}

}  // namespace

std::string ListenAddress::ToString() const {
  return absl::StrContains(host, ':') ? absl::StrCat("[", host, "]:", port)
                                      : absl::StrCat(host, ":", port);
}

absl::StatusOr<ListenAddress> ParseListenAddress(absl::string_view text) {
  const size_t colon = text.rfind(':');
  if (colon == absl::string_view::npos) return Malformed(text, "has no port");
  absl::string_view host = text.substr(0, colon);
  if (absl::ConsumePrefix(&host, "[")) {
    if (!absl::ConsumeSuffix(&host, "]")) {
      return Malformed(text, "has a bracket too few");
    }
  } else if (absl::StrContains(host, ':')) {
    return Malformed(text, "is IPv6 without brackets");
  }
  if (host.empty()) return Malformed(text, "has no host");
  ListenAddress address{.host = std::string(host.data(), host.size())};
  if (!absl::SimpleAtoi(text.substr(colon + 1), &address.port) ||
      address.port < 0 || address.port > 65535) {
    return Malformed(text, "has no port between 0 and 65535");
  }
  return address;
}

bool IsLoopback(const ListenAddress& address) {
  if (address.host == "localhost") return true;
  in_addr v4{};
  if (inet_pton(AF_INET, address.host.c_str(), &v4) == 1) {
    return (ntohl(v4.s_addr) >> 24) == 127;
  }
  in6_addr v6{};
  return inet_pton(AF_INET6, address.host.c_str(), &v6) == 1 &&
         IN6_IS_ADDR_LOOPBACK(&v6);
}

absl::Status TryBind(const ListenAddress& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const int lookup =
      getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(),
                  &hints, &found);
  const std::string what =
      absl::StrCat("cannot listen on ", address.ToString(), ": ");
  if (lookup != 0) {
    return absl::UnavailableError(absl::StrCat(what, gai_strerror(lookup)));
  }
  const std::unique_ptr<addrinfo, AddressListDeleter> list(found);
  for (const addrinfo* candidate = found; candidate != nullptr;
       candidate = candidate->ai_next) {
    if (const int error = BindOnce(*candidate); error != 0) {
      return absl::UnavailableError(absl::StrCat(what, std::strerror(error)));
    }
  }
  return absl::OkStatus();
}

}  // namespace treeline::base

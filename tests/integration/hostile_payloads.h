// Requests that are small on the wire, or large, and would become far larger in
// memory.
#ifndef TESTS_INTEGRATION_HOSTILE_PAYLOADS_H_
#define TESTS_INTEGRATION_HOSTILE_PAYLOADS_H_

#include <string>
#include <vector>

namespace treeline {

struct HostileRequest {
  // For gtest: letters and digits.
  std::string name;
  // Of HTTP: where to, and as what. Empty: over gRPC alone.
  std::string path = {};
  std::string content_type = {};
  bool is_gzip = false;
  // Of gRPC. Empty: over HTTP alone.
  std::string method = {};
  std::string body = {};
};

// Bodies of just under 32 MiB, the server's default limit; those that are gzip,
// inflated.
std::vector<HostileRequest> HostileHttpRequests();
// Bodies as gRPC sends them, plain; each is to be sent compressed as well.
std::vector<HostileRequest> HostileGrpcRequests();

std::string Gzip(const std::string& bytes);

}  // namespace treeline

#endif  // TESTS_INTEGRATION_HOSTILE_PAYLOADS_H_

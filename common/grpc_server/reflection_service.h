// grpc.reflection: what grpcurl, grpcui, Postman and their like ask.
#ifndef COMMON_GRPC_SERVER_REFLECTION_SERVICE_H_
#define COMMON_GRPC_SERVER_REFLECTION_SERVICE_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/grpc_server/raw_service.h"

namespace treeline::grpc_server {

// Versions v1 and v1alpha, which newer and older tools ask. gRPC's own service
// has v1alpha alone, and parses requests of any size, of anybody.
class ReflectionService final : public RawService {
 public:
  // The names of the services of the server, these not among them. Their files
  // are those of the generated pool.
  explicit ReflectionService(std::vector<std::string> services);

 private:
  const std::vector<std::string> services_;
};

// The bytes of the ServerReflectionResponse to the ServerReflectionRequest
// `request`. Knows the files of the generated pool; of extensions it knows
// none.
std::string AnswerReflection(absl::string_view request,
                             const std::vector<std::string>& services);

}  // namespace treeline::grpc_server

#endif  // COMMON_GRPC_SERVER_REFLECTION_SERVICE_H_

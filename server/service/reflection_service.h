// grpc.reflection.v1alpha: what grpcurl and its like ask.
#ifndef SERVER_SERVICE_REFLECTION_SERVICE_H_
#define SERVER_SERVICE_REFLECTION_SERVICE_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/service/raw_service.h"

namespace treeline::service {

// gRPC's own service parses requests of any size, unknown fields included, of
// anybody.
class ReflectionGrpcService final : public RawService {
 public:
  // The names of the services of the server, this one not among them.
  explicit ReflectionGrpcService(std::vector<std::string> services);

 private:
  const std::vector<std::string> services_;
};

// The bytes of the ServerReflectionResponse to the ServerReflectionRequest
// `request`. Knows the files of the generated pool; of extensions it knows
// none.
std::string AnswerReflection(absl::string_view request,
                             const std::vector<std::string>& services);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_REFLECTION_SERVICE_H_

// What calls over HTTP say, and how their answers are understood. No I/O.
#ifndef CLIENT_BENCH_HTTP_TARGET_H_
#define CLIENT_BENCH_HTTP_TARGET_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/bench/workload.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::bench {

// How a server is asked.
enum class Target {
  kGrpc,
  kConnect,      // the Connect protocol over HTTP, binary messages
  kConnectJson,  // the same with JSON
  kGeoPose,      // the GeoPose Protocol
};
// "grpc", "connect", "connect-json", "geopose". INVALID_ARGUMENT names them.
absl::StatusOr<Target> ParseTarget(absl::string_view name);
const char* Name(Target target);

// Where on the server a target over HTTP is, and the types of its bodies.
const char* PathOf(Target target);
const char* ContentTypeOf(Target target);
const char* AcceptOf(Target target);

// The body of a query. INVALID_ARGUMENT: the GeoPose Protocol has no way to say
// it: raw pixels, depth in another unit than millimetres, or depth that is
// registered but of no stated camera. It does not name the scene either: the
// server chooses.
absl::StatusOr<std::string> HttpBody(Target target, const WorkItem& item);

// An answer. From the GeoPose Protocol come no evidence, scene or timings; an
// answer's pose on the Earth stands in world_from_camera (latitude and
// longitude in degrees, height in metres; the quaternion), so that two answers
// can be compared. Its "no pose" is an answer that is not localized. Errors
// are the server's, with their reason and time to try again; UNKNOWN if that
// is no answer of a Treeline server.
absl::StatusOr<v1::LocalizeResponse> ParseHttpAnswer(Target target,
                                                     long http_status,
                                                     const std::string& body);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_HTTP_TARGET_H_

#include "tests/integration/hostile_payloads.h"

#include <zlib.h>

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline {
namespace {

constexpr char kLocalizePath[] = "/treeline.v1.RelocalizationService/Localize";
constexpr char kProto[] = "application/proto";
constexpr char kJson[] = "application/json";
constexpr size_t kBytes = 31 << 20;

// `unit` as often as it fits.
std::string Repeat(const std::string& unit, size_t bytes = kBytes) {
  std::string all;
  all.reserve(bytes);
  while (all.size() + unit.size() <= bytes) all += unit;
  return all;
}

std::string Array(const std::string& before, const std::string& element,
                  const std::string& after) {
  return absl::StrCat(before, Repeat(absl::StrCat(element, ",")), element,
                      after);
}

// candidate_scenes, each empty: 2 bytes.
std::string EmptyScenes() { return Repeat(std::string("\x2a\x00", 2)); }

// Field 15, a number.
std::string UnknownNumbers() { return Repeat(std::string("\x78\x00", 2)); }

// A valid request: a picture of NULs.
std::string Zeros() {
  v1::LocalizeRequest request;
  request.set_scene("room");
  request.mutable_frame()->mutable_color()->set_encoded(
      std::string(kBytes, '\0'));
  return request.SerializeAsString();
}

// Camera.parameters: 8 bytes each, packed.
std::string ManyParameters() {
  v1::LocalizeRequest request;
  auto& parameters =
      *request.mutable_frame()->mutable_camera()->mutable_parameters();
  parameters.Resize(static_cast<int>(kBytes / sizeof(double)), 0);
  return request.SerializeAsString();
}

// frame = {} again and again: merged into one.
std::string ManyFrames() { return Repeat(std::string("\x1a\x02\x0a\x00", 4)); }

std::string QuotedScenes() {
  return Array(R"({'scene':'"','candidateScenes':[)", "''", "]}");
}

std::string ZerosAsJson() {
  return absl::StrCat(R"({"scene":"room","frame":{"color":{"encoded":")",
                      Repeat("AAAA", kBytes / 2), "\"}}}");
}

HostileRequest Http(const std::string& name, const std::string& body,
                    const char* type, bool is_gzip = false,
                    const char* path = kLocalizePath) {
  return {.name = name,
          .path = path,
          .content_type = type,
          .is_gzip = is_gzip,
          .body = is_gzip ? Gzip(body) : body};
}

HostileRequest Grpc(const std::string& name, const std::string& body,
                    const char* method = kLocalizePath) {
  return {.name = name, .method = method, .body = body};
}

}  // namespace

std::string Gzip(const std::string& bytes) {
  z_stream stream = {};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 15 + 16, 9,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    return "";
  }
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::vector<HostileRequest> HostileHttpRequests() {
  return {
      Http("GzipOfEmptyScenes", EmptyScenes(), kProto, true),
      Http("EmptyScenes", EmptyScenes(), kProto),
      Http("GzipOfQuotedScenes", QuotedScenes(), kJson, true),
      Http("QuotedScenes", QuotedScenes(), kJson),
      Http("GzipOfZeros", Zeros(), kProto, true),
      Http("Zeros", Zeros(), kProto),
      Http("ZerosAsJson", ZerosAsJson(), kJson),
      Http("UnknownNumbers", UnknownNumbers(), kProto),
      Http("DeepArrays", std::string(kBytes, '['), kJson),
      Http("GeoPoseArrays",
           Array(R"({"id":"1","type":"geopose","sensorReadings":)"
                 R"({"cameraReadings":[)",
                 "{}", "]}}"),
           kJson, false, "/geopose"),
  };
}

std::vector<HostileRequest> HostileGrpcRequests() {
  return {
      Grpc("EmptyScenes", EmptyScenes()),
      Grpc("UnknownNumbers", UnknownNumbers()),
      Grpc("Zeros", Zeros()),
      Grpc("ManyParameters", ManyParameters()),
      Grpc("ManyFrames", ManyFrames()),
      Grpc("HealthOfUnknownNumbers", UnknownNumbers(),
           "/grpc.health.v1.Health/Check"),
      Grpc("ReflectionOfUnknownNumbers", UnknownNumbers(),
           "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"),
      Grpc("StreamOfEmptyScenes", EmptyScenes(),
           "/treeline.v1.RelocalizationService/LocalizeStream"),
  };
}

}  // namespace treeline

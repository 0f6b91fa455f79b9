#include "common/grpc_server/reflection_service.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "grpc/health/v1/health.pb.h"
#include "grpc/reflection/v1/reflection.pb.h"
#include "grpc/reflection/v1alpha/reflection.pb.h"

namespace treeline::grpc_server {
namespace {

namespace v1 = ::grpc::reflection::v1;
using google::protobuf::DescriptorPool;
using google::protobuf::FileDescriptor;

constexpr const char* kNames[] = {"grpc.reflection.v1.ServerReflection",
                                  "grpc.reflection.v1alpha.ServerReflection"};
// A request names one file or symbol.
constexpr size_t kMaxRequestBytes = 4096;

void SetError(grpc::StatusCode code, std::string message,
              v1::ServerReflectionResponse& response) {
  v1::ErrorResponse& error = *response.mutable_error_response();
  error.set_error_code(code);
  error.set_error_message(std::move(message));
}

// `file` and all that it needs, each once.
void AddFiles(const FileDescriptor& file, std::set<std::string>& done,
              v1::FileDescriptorResponse& files) {
  if (!done.insert(file.name()).second) return;
  google::protobuf::FileDescriptorProto proto;
  file.CopyTo(&proto);
  files.add_file_descriptor_proto(proto.SerializeAsString());
  for (int i = 0; i < file.dependency_count(); ++i) {
    AddFiles(*file.dependency(i), done, files);
  }
}

void SetFiles(const FileDescriptor* file, absl::string_view what,
              v1::ServerReflectionResponse& response) {
  if (file == nullptr) {
    SetError(grpc::StatusCode::NOT_FOUND, absl::StrCat(what, " unknown"),
             response);
    return;
  }
  std::set<std::string> done;
  AddFiles(*file, done, *response.mutable_file_descriptor_response());
}

void Answer(const v1::ServerReflectionRequest& request,
            const std::vector<std::string>& services,
            v1::ServerReflectionResponse& response) {
  const DescriptorPool& pool = *DescriptorPool::generated_pool();
  switch (request.message_request_case()) {
    case v1::ServerReflectionRequest::kFileByFilename:
      SetFiles(pool.FindFileByName(request.file_by_filename()), "the file is",
               response);
      return;
    case v1::ServerReflectionRequest::kFileContainingSymbol:
      SetFiles(pool.FindFileContainingSymbol(request.file_containing_symbol()),
               "the symbol is", response);
      return;
    case v1::ServerReflectionRequest::kListServices: {
      v1::ListServiceResponse& list =
          *response.mutable_list_services_response();
      for (const char* name : kNames) list.add_service()->set_name(name);
      for (const std::string& name : services) {
        list.add_service()->set_name(name);
      }
      return;
    }
    case v1::ServerReflectionRequest::kFileContainingExtension:
    case v1::ServerReflectionRequest::kAllExtensionNumbersOfType:
      SetError(grpc::StatusCode::NOT_FOUND, "there are no extensions",
               response);
      return;
    case v1::ServerReflectionRequest::MESSAGE_REQUEST_NOT_SET:
      break;
  }
  SetError(grpc::StatusCode::INVALID_ARGUMENT, "nothing is asked", response);
}

// One stream: an answer for each request. Lives until gRPC is done with it.
class ReflectionCall final : public RawReactor {
 public:
  explicit ReflectionCall(const std::vector<std::string>& services)
      : services_(services) {
    StartRead(&incoming_);
  }

 private:
  void OnReadDone(bool ok) override {
    if (!ok) {
      Finish(grpc::Status::OK);
      return;
    }
    std::vector<grpc::Slice> slices;
    if (incoming_.Length() > kMaxRequestBytes ||
        !incoming_.Dump(&slices).ok()) {
      Finish(
          {grpc::StatusCode::INVALID_ARGUMENT, "not a request of reflection"});
      return;
    }
    std::string request;
    for (const grpc::Slice& slice : slices) {
      request.append(reinterpret_cast<const char*>(slice.begin()),
                     slice.size());
    }
    const grpc::Slice answer(AnswerReflection(request, services_));
    outgoing_ = grpc::ByteBuffer(&answer, 1);
    StartWrite(&outgoing_);
  }
  void OnWriteDone(bool ok) override {
    if (ok) {
      StartRead(&incoming_);
    } else {
      Finish(grpc::Status::OK);
    }
  }
  void OnDone() override { delete this; }

  const std::vector<std::string>& services_;
  grpc::ByteBuffer incoming_;
  grpc::ByteBuffer outgoing_;
};

}  // namespace

ReflectionService::ReflectionService(std::vector<std::string> services)
    : services_(std::move(services)) {
  // Else the linker leaves out files that nothing else needs, and the pool does
  // not know them.
  ::grpc::health::v1::HealthCheckRequest::descriptor();
  ::grpc::reflection::v1alpha::ServerReflectionRequest::descriptor();
  for (const char* name : kNames) {
    AddRawMethod(absl::StrCat("/", name, "/ServerReflectionInfo"),
                 [this](grpc::CallbackServerContext* /*context*/) {
                   return new ReflectionCall(services_);
                 });
  }
}

std::string AnswerReflection(absl::string_view request,
                             const std::vector<std::string>& services) {
  v1::ServerReflectionRequest asked;
  v1::ServerReflectionResponse response;
  if (asked.ParseFromArray(request.data(), static_cast<int>(request.size()))) {
    Answer(asked, services, response);
    *response.mutable_original_request() = std::move(asked);
  } else {
    SetError(grpc::StatusCode::INVALID_ARGUMENT, "not a request of reflection",
             response);
  }
  return response.SerializeAsString();
}

}  // namespace treeline::grpc_server

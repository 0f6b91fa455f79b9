#include "server/service/reflection_service.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::service {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::FileDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

constexpr char kName[] = "grpc.reflection.v1alpha.ServerReflection";
// A request names one file or symbol.
constexpr size_t kMaxRequestBytes = 4096;

// Fields of ServerReflectionRequest; all but the extension are texts.
enum Asked {
  kNothing = 0,
  kFileByFilename = 3,
  kFileContainingSymbol = 4,
  kFileContainingExtension = 5,
  kAllExtensionNumbersOfType = 6,
  kListServices = 7
};
// Fields of ServerReflectionResponse.
constexpr int kOriginalRequest = 2;
constexpr int kFileDescriptorResponse = 4;
constexpr int kListServicesResponse = 6;
constexpr int kErrorResponse = 7;

constexpr char kNotFound = 5;
constexpr char kInvalidArgument = 3;

std::string Varint(uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) {
    bytes.push_back(static_cast<char>((value & 0x7f) | 0x80));
  }
  bytes.push_back(static_cast<char>(value));
  return bytes;
}

// A text, bytes or a message.
std::string Field(int number, absl::string_view bytes) {
  return absl::StrCat(Varint(static_cast<uint64_t>(number) << 3 |
                             WireFormatLite::WIRETYPE_LENGTH_DELIMITED),
                      Varint(bytes.size()), bytes);
}

std::string ErrorOf(char code, absl::string_view message) {
  return Field(kErrorResponse,
               absl::StrCat(absl::string_view("\x08", 1),
                            absl::string_view(&code, 1), Field(2, message)));
}

// `file` and all that it needs, each once.
void AddFiles(const FileDescriptor& file, std::set<std::string>& done,
              std::string& response) {
  if (!done.insert(file.name()).second) return;
  google::protobuf::FileDescriptorProto proto;
  file.CopyTo(&proto);
  response += Field(1, proto.SerializeAsString());
  for (int i = 0; i < file.dependency_count(); ++i) {
    AddFiles(*file.dependency(i), done, response);
  }
}

std::string FileAnswer(const FileDescriptor* file, absl::string_view what) {
  if (file == nullptr)
    return ErrorOf(kNotFound, absl::StrCat(what, " unknown"));
  std::set<std::string> done;
  std::string files;
  AddFiles(*file, done, files);
  return Field(kFileDescriptorResponse, files);
}

// The last of what is asked, as of a oneof. False: no request.
bool Decode(absl::string_view request, int& asked, std::string& text) {
  CodedInputStream input(reinterpret_cast<const uint8_t*>(request.data()),
                         static_cast<int>(request.size()));
  while (const uint32_t tag = input.ReadTag()) {
    const int number = WireFormatLite::GetTagFieldNumber(tag);
    const bool is_known = number >= kFileByFilename &&
                          number <= kListServices &&
                          WireFormatLite::GetTagWireType(tag) ==
                              WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
    uint32_t length = 0;
    const bool is_read =
        is_known ? input.ReadVarint32(&length) && length <= request.size() &&
                       input.ReadString(&text, static_cast<int>(length))
                 : WireFormatLite::SkipField(&input, tag);
    if (!is_read) return false;
    if (is_known) asked = number;
  }
  return input.ConsumedEntireMessage();
}

std::string Answer(int asked, const std::string& text,
                   const std::vector<std::string>& services) {
  const DescriptorPool& pool = *DescriptorPool::generated_pool();
  switch (asked) {
    case kFileByFilename:
      return FileAnswer(pool.FindFileByName(text), "the file is");
    case kFileContainingSymbol:
      return FileAnswer(pool.FindFileContainingSymbol(text), "the symbol is");
    case kListServices: {
      std::string list = Field(1, Field(1, kName));
      for (const std::string& service : services) {
        list += Field(1, Field(1, service));
      }
      return Field(kListServicesResponse, list);
    }
    case kFileContainingExtension:
    case kAllExtensionNumbersOfType:
      return ErrorOf(kNotFound, "there are no extensions");
    default:
      return ErrorOf(kInvalidArgument, "nothing is asked");
  }
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

ReflectionGrpcService::ReflectionGrpcService(std::vector<std::string> services)
    : services_(std::move(services)) {
  AddRawMethod(absl::StrCat("/", kName, "/ServerReflectionInfo"),
               [this](grpc::CallbackServerContext* /*context*/) {
                 return new ReflectionCall(services_);
               });
}

std::string AnswerReflection(absl::string_view request,
                             const std::vector<std::string>& services) {
  int asked = kNothing;
  std::string text;
  std::string response = Field(kOriginalRequest, request);
  if (!Decode(request, asked, text)) {
    // What cannot be read cannot be repeated as a message either.
    return ErrorOf(kInvalidArgument, "not a request of reflection");
  }
  return response + Answer(asked, text, services);
}

}  // namespace treeline::service

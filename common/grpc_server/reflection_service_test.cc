#include "common/grpc_server/reflection_service.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/descriptor_database.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "grpc/reflection/v1/reflection.pb.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::grpc_server {
namespace {

using ::grpc::reflection::v1::ServerReflectionRequest;
using ::grpc::reflection::v1::ServerReflectionResponse;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

ServerReflectionResponse AnswerTo(const std::string& bytes) {
  ServerReflectionResponse response;
  EXPECT_TRUE(
      response.ParseFromString(AnswerReflection(bytes, {"a.B", "c.D"})));
  return response;
}

ServerReflectionResponse Answer(const ServerReflectionRequest& request) {
  return AnswerTo(request.SerializeAsString());
}

ServerReflectionRequest Symbol(const std::string& name) {
  ServerReflectionRequest request;
  request.set_file_containing_symbol(name);
  return request;
}

std::vector<std::string> ListedServices() {
  ServerReflectionRequest request;
  request.set_list_services("*");
  const ServerReflectionResponse response = Answer(request);
  std::vector<std::string> names;
  for (const auto& service : response.list_services_response().service()) {
    names.push_back(service.name());
  }
  return names;
}

// As a tool does, from the files of the answer alone.
void ExpectDescribed(const ServerReflectionResponse& response,
                     const std::string& service) {
  google::protobuf::SimpleDescriptorDatabase files;
  for (const std::string& bytes :
       response.file_descriptor_response().file_descriptor_proto()) {
    google::protobuf::FileDescriptorProto file;
    ASSERT_TRUE(file.ParseFromString(bytes));
    EXPECT_TRUE(files.Add(file)) << file.name();
  }
  google::protobuf::DescriptorPool pool(&files);
  EXPECT_NE(pool.FindServiceByName(service), nullptr) << service;
}

TEST(Reflection, ListsTheServicesAndItself) {
  EXPECT_THAT(
      ListedServices(),
      ElementsAre("grpc.reflection.v1.ServerReflection",
                  "grpc.reflection.v1alpha.ServerReflection", "a.B", "c.D"));
}

// grpcurl describe and grpcui ask for each service that is listed, and end with
// an error where one is unknown.
TEST(Reflection, DescribesItselfAndHealth) {
  const ReflectionService service({});
  for (const char* name :
       {"grpc.reflection.v1.ServerReflection",
        "grpc.reflection.v1alpha.ServerReflection", "grpc.health.v1.Health"}) {
    ExpectDescribed(Answer(Symbol(name)), name);
  }
}

TEST(Reflection, TellsTheFileOfASymbolAndWhatItNeeds) {
  ASSERT_NE(v1::LocalizeRequest::descriptor(), nullptr);
  ServerReflectionRequest by_file;
  by_file.set_file_by_filename("treeline/v1/relocalization.proto");
  for (const ServerReflectionRequest& request :
       {Symbol("treeline.v1.RelocalizationService"),
        Symbol("treeline.v1.LocalizeRequest"), by_file}) {
    ExpectDescribed(Answer(request), "treeline.v1.RelocalizationService");
  }
}

TEST(Reflection, RepeatsTheRequest) {
  const ServerReflectionRequest request = Symbol("no.such.Symbol");
  const ServerReflectionResponse response = Answer(request);
  EXPECT_EQ(response.original_request().SerializeAsString(),
            request.SerializeAsString());
  EXPECT_EQ(response.error_response().error_code(), 5);
  EXPECT_THAT(response.error_response().error_message(), HasSubstr("unknown"));
}

TEST(Reflection, AnswersWhatIsNoRequest) {
  for (const char* bytes : {"\xff\xff", "\x22\x7f"}) {
    EXPECT_THAT(AnswerTo(bytes).error_response().error_message(),
                HasSubstr("not a request"));
  }
  EXPECT_THAT(AnswerTo("").error_response().error_message(),
              HasSubstr("nothing is asked"));
  ServerReflectionRequest request;
  request.set_all_extension_numbers_of_type("treeline.v1.Frame");
  EXPECT_THAT(Answer(request).error_response().error_message(),
              HasSubstr("no extensions"));
}

}  // namespace
}  // namespace treeline::grpc_server

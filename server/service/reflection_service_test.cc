#include "server/service/reflection_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "treeline/v1/relocalization.pb.h"

namespace treeline::service {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string>& Services() {
  static const std::vector<std::string> services = {"a.B", "c.D"};
  return services;
}

std::string Answer(const std::string& request) {
  return AnswerReflection(request, Services());
}

std::string Ask(char tag, const std::string& text) {
  return std::string{tag, static_cast<char>(text.size())} + text;
}

// Tags are field << 3 | 2.
TEST(Reflection, ListsTheServicesAndItself) {
  EXPECT_THAT(Answer(Ask('\x3a', "*")),
              AllOf(HasSubstr("a.B"), HasSubstr("c.D"),
                    HasSubstr("grpc.reflection.v1alpha.ServerReflection")));
}

TEST(Reflection, TellsTheFileOfASymbolAndWhatItNeeds) {
  ASSERT_NE(v1::LocalizeRequest::descriptor(), nullptr);
  for (const std::string& request :
       {Ask('\x22', "treeline.v1.RelocalizationService"),
        Ask('\x22', "treeline.v1.LocalizeRequest"),
        Ask('\x1a', "treeline/v1/relocalization.proto")}) {
    EXPECT_THAT(Answer(request),
                AllOf(HasSubstr("LocalizeStreamRequest"),
                      HasSubstr("GeoAnchor"), HasSubstr("google.rpc")));
  }
}

TEST(Reflection, RepeatsTheRequest) {
  const std::string request = Ask('\x22', "no.such.Symbol");
  EXPECT_THAT(Answer(request), AllOf(HasSubstr(request), HasSubstr("unknown")));
}

TEST(Reflection, AnswersWhatIsNoRequest) {
  EXPECT_THAT(Answer("\xff\xff"), HasSubstr("not a request"));
  EXPECT_THAT(Answer("\x22\x7f"), HasSubstr("not a request"));
  EXPECT_THAT(Answer(""), HasSubstr("nothing is asked"));
  EXPECT_THAT(Answer(Ask('\x32', "treeline.v1.Frame")),
              AllOf(HasSubstr("no extensions"), Not(HasSubstr("GeoAnchor"))));
}

}  // namespace
}  // namespace treeline::service

#include "common/wire/message_shape.h"

#include <gmock/gmock.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <gtest/gtest.h>

#include <string>

#include "treeline/v1/relocalization.pb.h"

namespace treeline::wire {
namespace {

using ::testing::HasSubstr;

absl::Status Check(const std::string& bytes, const MessageLimits& limits = {},
                   int block = -1) {
  google::protobuf::io::ArrayInputStream stream(
      bytes.data(), static_cast<int>(bytes.size()), block);
  return CheckMessageShape(stream, *v1::LocalizeRequest::descriptor(), limits);
}

std::string Times(int count, const std::string& bytes) {
  std::string all;
  for (int i = 0; i < count; ++i) all += bytes;
  return all;
}

v1::LocalizeRequest FullRequest() {
  v1::LocalizeRequest request;
  request.set_scene("kitchen");
  v1::Frame& frame = *request.mutable_frame();
  frame.mutable_color()->set_encoded(std::string(100000, '\x80'));
  frame.mutable_camera()->set_model("PINHOLE");
  for (int i = 0; i < 8; ++i) frame.mutable_camera()->add_parameters(i);
  frame.mutable_depth()->set_unit_m(0.001);
  frame.mutable_depth()->mutable_raw()->set_data(std::string(3, '\xff'));
  frame.mutable_depth()
      ->mutable_calibration()
      ->mutable_color_from_depth()
      ->mutable_rotation()
      ->set_w(1);
  request.mutable_options()->set_seed(~uint64_t{0});
  return request;
}

TEST(MessageShape, LetsRequestsThrough) {
  const std::string bytes = FullRequest().SerializeAsString();
  EXPECT_TRUE(Check(bytes).ok()) << Check(bytes);
  // As it comes from a network, in pieces.
  EXPECT_TRUE(Check(bytes, {}, 3).ok());
  EXPECT_TRUE(Check("").ok());
  v1::LocalizeRequest parsed;
  ASSERT_TRUE(ParseMessage(bytes, parsed).ok());
  EXPECT_EQ(parsed.SerializeAsString(), bytes);
}

TEST(MessageShape, RefusesManyEmptyTexts) {
  // candidate_scenes = "": 40 bytes of memory for 2 of the request.
  const std::string one("\x2a\x00", 2);
  EXPECT_TRUE(Check(Times(20000, one)).ok());
  const absl::Status refused = Check(Times(20001, one));
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("fields"));
}

TEST(MessageShape, CountsFieldsThatItDoesNotKnow) {
  const MessageLimits limits{.max_fields = 10};
  // Field 15: a number, a text, 4 and 8 bytes.
  for (const std::string& one :
       {std::string("\x78\x00", 2), std::string("\x7a\x00", 2),
        std::string("\x7d\x00\x00\x00\x00", 5),
        std::string("\x79\x00\x00\x00\x00\x00\x00\x00\x00", 9)}) {
    EXPECT_TRUE(Check(Times(10, one), limits).ok());
    EXPECT_FALSE(Check(Times(11, one), limits).ok());
  }
}

TEST(MessageShape, CountsFieldsOfMessagesWithinMessages) {
  const MessageLimits limits{.max_fields = 10};
  // frame = { color = {} }: 2 fields each time.
  const std::string one("\x1a\x02\x0a\x00", 4);
  EXPECT_TRUE(Check(Times(5, one), limits).ok());
  EXPECT_FALSE(Check(Times(6, one), limits).ok());
}

TEST(MessageShape, CountsElementsOfPackedFields) {
  v1::LocalizeRequest request;
  v1::Camera& camera = *request.mutable_frame()->mutable_camera();
  for (int i = 0; i < 20; ++i) camera.add_parameters(i);
  const std::string bytes = request.SerializeAsString();
  EXPECT_TRUE(Check(bytes, {.max_fields = 23}).ok());
  EXPECT_FALSE(Check(bytes, {.max_fields = 22}).ok());
}

TEST(MessageShape, BoundsDepth) {
  const std::string bytes = FullRequest().SerializeAsString();
  // request, frame, depth, calibration, color_from_depth, rotation.
  EXPECT_TRUE(Check(bytes, {.max_depth = 6}).ok());
  EXPECT_THAT(std::string(Check(bytes, {.max_depth = 5}).message()),
              HasSubstr("deep"));
}

TEST(MessageShape, RefusesWhatIsNoMessage) {
  for (const std::string& bytes : {
           std::string("\x0a\x05kit"),               // cut off
           std::string("\x0a"),                      // without its length
           std::string("\xff\xff\xff"),              // no tag
           std::string("\x00\x00", 2),               // field 0
           std::string("\x7b\x7c"),                  // a group
           std::string("\x7c"),                      // the end of none
           std::string("\x0e\x00", 2),               // wire type 6
           std::string("\x1f\x8b\x08\x00", 4),       // gzip
           std::string("\x1a\x04\x0a\x09kit"),       // beyond what it lies in
           std::string("\x0a\xff\xff\xff\xff\x0f"),  // 4 GiB
           std::string("\x08\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01"),
       }) {
    EXPECT_EQ(Check(bytes).code(), absl::StatusCode::kInvalidArgument)
        << testing::PrintToString(bytes);
  }
}

TEST(MessageShape, ParsingFailsAsProtobufDoes) {
  v1::LocalizeRequest request;
  // scene is not UTF-8.
  const absl::Status refused = ParseMessage("\x0a\x01\xff", request);
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()),
              HasSubstr("treeline.v1.LocalizeRequest"));
}

}  // namespace
}  // namespace treeline::wire

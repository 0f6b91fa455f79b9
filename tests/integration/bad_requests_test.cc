// What clients do wrong: each a clear error, and the server goes on.
#include <grpcpp/create_channel.h>

#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "common/image/decode.h"
#include "common/wire/camera.h"
#include "common/wire/frame.h"
#include "common/wire/status.h"
#include "gmock/gmock.h"
#include "tests/integration/fixture.h"
#include "treeline/v1/relocalization.grpc.pb.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

class BadRequests : public ServerTest {
 protected:
  BadRequests() : frames_(HeldOutFrames()) {}

  void SetUp() override {
    ServerTest::SetUp();
    PutRoom();
    StartServer();
    if (server_ == nullptr) return;
    stub_ = v1::RelocalizationService::NewStub(
        grpc::CreateChannel(address_, grpc::InsecureChannelCredentials()));
  }

  // The request is refused with this code and a message that names `what`, and
  // the next good one is answered by the same process.
  void ExpectRefused(const relocalizer::LocalizeQuery& query,
                     absl::StatusCode code, const char* what) {
    CheckRefusal(client_->Localize(query, {}).status(), code, what);
  }
  void ExpectRefused(const v1::LocalizeRequest& request, absl::StatusCode code,
                     const char* what) {
    grpc::ClientContext context;
    v1::LocalizeResponse response;
    CheckRefusal(wire::FromGrpc(stub_->Localize(&context, request, &response)),
                 code, what);
  }

  v1::LocalizeRequest GoodRequest() const {
    const relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
    v1::LocalizeRequest request;
    request.set_scene(query.scene);
    *request.mutable_frame() = wire::ToProto(query.frame);
    return request;
  }

  const dataset::Dataset frames_;
  std::unique_ptr<v1::RelocalizationService::Stub> stub_;

 private:
  void CheckRefusal(const absl::Status& status, absl::StatusCode code,
                    const char* what) {
    EXPECT_EQ(status.code(), code) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(what));
    const auto good = client_->Localize(QueryOf(frames_, 0), {});
    EXPECT_TRUE(good.ok()) << good.status();
    EXPECT_TRUE(server_->IsRunning());
  }
};

std::string& ColorBytes(relocalizer::LocalizeQuery& query) {
  return std::get<wire::EncodedImage>(query.frame.color).bytes;
}

std::string& DepthBytes(relocalizer::LocalizeQuery& query) {
  return std::get<wire::EncodedImage>(query.frame.depth->image).bytes;
}

TEST_F(BadRequests, UnknownScene) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  query.scene = "attic";
  ExpectRefused(query, absl::StatusCode::kNotFound, "attic");
}

TEST_F(BadRequests, UnknownVersion) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  query.model_version = "2";
  ExpectRefused(query, absl::StatusCode::kNotFound, "version '2'");
}

TEST_F(BadRequests, SceneThatIsAPath) {
  for (const char* scene : {"../room", "room/1", "."}) {
    relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
    query.scene = scene;
    ExpectRefused(query, absl::StatusCode::kInvalidArgument, "scene");
  }
}

TEST_F(BadRequests, TruncatedImages) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  ColorBytes(query).resize(ColorBytes(query).size() / 2);
  ExpectRefused(query, absl::StatusCode::kInvalidArgument,
                "frame.color.encoded");
  query = QueryOf(frames_, 0);
  DepthBytes(query).resize(DepthBytes(query).size() / 2);
  ExpectRefused(query, absl::StatusCode::kInvalidArgument, "frame.depth.png");
}

TEST_F(BadRequests, ImagesThatAreNone) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  ColorBytes(query) = "<html>404</html>";
  ExpectRefused(query, absl::StatusCode::kInvalidArgument,
                "frame.color.encoded");
  query = QueryOf(frames_, 0);
  std::swap(ColorBytes(query), DepthBytes(query));
  ExpectRefused(query, absl::StatusCode::kInvalidArgument, "frame.");
}

// A JPEG file of a few hundred bytes that claims 65,500 x 65,500 pixels.
TEST_F(BadRequests, AbsurdImageSize) {
  const image::ColorImage small{
      .width = 16, .height = 16, .rgb = std::vector<uint8_t>(16 * 16 * 3)};
  std::string jpeg = image::EncodeJpeg(small, 80).value();
  const size_t frame_header = jpeg.find("\xff\xc0");
  ASSERT_NE(frame_header, std::string::npos);
  jpeg.replace(frame_header + 5, 4, "\xff\xdc\xff\xdc");
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  ColorBytes(query) = jpeg;
  ExpectRefused(query, absl::StatusCode::kInvalidArgument, "65500 x 65500");
}

TEST_F(BadRequests, ImageOfAnotherSizeWithoutItsCamera) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  query.frame.color = image::ColorImage{
      .width = 32, .height = 24, .rgb = std::vector<uint8_t>(32 * 24 * 3)};
  ExpectRefused(query, absl::StatusCode::kInvalidArgument, "frame.camera");
}

TEST_F(BadRequests, DepthOfAnotherSize) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  query.frame.depth->image = image::DepthImage{
      .width = 32, .height = 24, .values = std::vector<uint16_t>(32 * 24)};
  ExpectRefused(query, absl::StatusCode::kInvalidArgument, "frame.depth");
}

TEST_F(BadRequests, MissingDepth) {
  relocalizer::LocalizeQuery query = QueryOf(frames_, 0);
  query.frame.depth.reset();
  ExpectRefused(query, absl::StatusCode::kInvalidArgument, "depth");
}

TEST_F(BadRequests, MissingColor) {
  v1::LocalizeRequest request = GoodRequest();
  request.mutable_frame()->clear_color();
  ExpectRefused(request, absl::StatusCode::kInvalidArgument, "frame.color");
}

TEST_F(BadRequests, IntrinsicsThatAreNotNumbers) {
  v1::LocalizeRequest request = GoodRequest();
  *request.mutable_frame()->mutable_camera() =
      wire::ToProto(frames_.calibration().color);
  request.mutable_frame()->mutable_camera()->set_parameters(
      0, std::numeric_limits<double>::quiet_NaN());
  ExpectRefused(request, absl::StatusCode::kInvalidArgument, "frame.camera");
}

TEST_F(BadRequests, DepthUnitThatIsNone) {
  for (const double unit_m :
       {0.0, -0.001, std::numeric_limits<double>::quiet_NaN()}) {
    v1::LocalizeRequest request = GoodRequest();
    request.mutable_frame()->mutable_depth()->set_unit_m(unit_m);
    ExpectRefused(request, absl::StatusCode::kInvalidArgument,
                  "frame.depth.unit_m");
  }
}

TEST_F(BadRequests, DepthWithoutItsRegistration) {
  v1::LocalizeRequest request = GoodRequest();
  request.mutable_frame()->mutable_depth()->clear_registration();
  ExpectRefused(request, absl::StatusCode::kInvalidArgument,
                "frame.depth.registration");
}

TEST_F(BadRequests, MessageOverTheLimit) {
  v1::LocalizeRequest request = GoodRequest();
  request.mutable_frame()->mutable_color()->set_encoded(
      std::string(33 << 20, 'x'));
  ExpectRefused(request, absl::StatusCode::kResourceExhausted, "larger than");
}

TEST_F(BadRequests, NothingAtAll) {
  ExpectRefused(v1::LocalizeRequest(), absl::StatusCode::kInvalidArgument,
                "frame.color");
}

}  // namespace
}  // namespace treeline

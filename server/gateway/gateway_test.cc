#include "server/gateway/gateway.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <tuple>

#include "absl/strings/escaping.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "google/rpc/status.pb.h"
#include "server/gateway/cors.h"
#include "server/gateway/testing_dispatcher.h"

namespace treeline::gateway {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr char kLocalize[] = "/treeline.v1.RelocalizationService/Localize";
constexpr char kPage[] = "https://app.example.com";

class GatewayTest : public ::testing::Test {
 protected:
  void SetUp() override { Start(DefaultOptions()); }

  static GatewayOptions DefaultOptions() {
    GatewayOptions options;
    options.http.listen = "127.0.0.1:0";
    options.http.max_body_mib = 1;
    options.allowed_origins = {kPage};
    return options;
  }

  void Start(const GatewayOptions& options) {
    client_.reset();
    gateway_.reset();
    auto gateway = Gateway::Start(
        options, dispatcher_,
        {.metrics =
             [](absl::string_view accept) {
               return accept == "application/odd"
                          ? Content{"application/odd", "odd"}
                          : Content{"text/plain; version=0.0.4; charset=utf-8",
                                    "treeline_up 1\n"};
             },
         .may_read_metrics =
             [this](const service::CallInfo& call) {
               return metrics_token_.empty() ||
                              call.credentials.bearer_token == metrics_token_
                          ? absl::OkStatus()
                          : absl::UnauthenticatedError("who are you?");
             },
         .failed_queries =
             [](absl::string_view path) -> absl::StatusOr<Content> {
           if (path == "odd") return absl::NotFoundError("no such query");
           return Content{"image/png", "<" + std::string(path) + ">"};
         },
         .may_inspect =
             [](const service::CallInfo& call) {
               return call.credentials.bearer_token == "inspector"
                          ? absl::OkStatus()
                          : absl::PermissionDeniedError("not you");
             },
         .ready = [this] { return ready_; }},
        clock_);
    ASSERT_TRUE(gateway.ok()) << gateway.status();
    gateway_ = *std::move(gateway);
    client_ =
        std::make_unique<httplib::Client>("http://" + gateway_->address());
    client_->set_keep_alive(true);
    client_->set_tcp_nodelay(true);
  }

  httplib::Result PostJson(const std::string& path, const std::string& body,
                           const httplib::Headers& headers = {}) {
    return client_->Post(path, headers, body, "application/json");
  }

  // "not_found" and so on; the body must be an error.
  static std::string CodeOf(const httplib::Result& result) {
    return nlohmann::json::parse(result->body)["code"];
  }
  static std::string MessageOf(const httplib::Result& result) {
    return nlohmann::json::parse(result->body)["message"];
  }

  const base::SteadyClock clock_{};
  TestingDispatcher dispatcher_;
  bool ready_ = true;
  // Empty: everyone may read them.
  std::string metrics_token_;
  std::unique_ptr<Gateway> gateway_;
  std::unique_ptr<httplib::Client> client_;
};

TEST_F(GatewayTest, AnswersConnectJson) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest& request) {
    v1::LocalizeResponse response;
    response.set_outcome(v1::OUTCOME_LOCALIZED);
    response.set_scene(request.scene());
    response.set_inliers(77);
    return response;
  };
  const auto result = PostJson(kLocalize, R"({"scene":"kitchen"})",
                               {{"Connect-Protocol-Version", "1"}});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  EXPECT_EQ(result->get_header_value("Content-Type"), "application/json");
  const auto body = nlohmann::json::parse(result->body);
  EXPECT_EQ(body["scene"], "kitchen");
  EXPECT_EQ(body["outcome"], "OUTCOME_LOCALIZED");
  EXPECT_EQ(body["inliers"], 77);
}

TEST_F(GatewayTest, APictureAloneIsAQuestion) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest& request) {
    v1::LocalizeResponse response;
    response.set_outcome(v1::OUTCOME_LOCALIZED);
    response.set_scene(request.scene());
    response.set_samples(
        static_cast<int>(request.frame().color().encoded().size()));
    return response;
  };
  const std::string picture = "\xff\xd8 a picture";
  const auto plain =
      client_->Post("/localize?scene=living%20room",
                    {{"Authorization", "Bearer t"}}, picture, "image/jpeg");
  ASSERT_TRUE(plain);
  ASSERT_EQ(plain->status, 200) << plain->body;
  const auto body = nlohmann::json::parse(plain->body);
  EXPECT_EQ(body["scene"], "living room");
  EXPECT_EQ(body["samples"], picture.size());
  EXPECT_EQ(dispatcher_.calls().back().credentials.bearer_token, "t");
  EXPECT_EQ(dispatcher_.admitted().back(), service::Scope::kLocalize);
  const auto form = client_->Post(
      "/localize",
      httplib::MultipartFormDataItems{{"image", picture, "a.jpg", "image/jpeg"},
                                      {"scene", "kitchen", "", ""}});
  ASSERT_TRUE(form);
  ASSERT_EQ(form->status, 200) << form->body;
  EXPECT_EQ(nlohmann::json::parse(form->body)["scene"], "kitchen");
  // And what is none says how to ask.
  EXPECT_EQ(client_->Post("/localize?at=home", picture, "image/jpeg")->status,
            400);
  const auto get = client_->Get("/localize");
  EXPECT_EQ(get->status, 405);
  EXPECT_THAT(MessageOf(get), HasSubstr("curl -F"));
  EXPECT_EQ(PostJson("/localize", "{}")->status, 415);
}

TEST_F(GatewayTest, FailedQueriesAreForThoseWhoMay) {
  const httplib::Headers inspector{{"Authorization", "Bearer inspector"}};
  const auto get = [&](const std::string& path) {
    return client_->Get(path, inspector);
  };
  EXPECT_EQ(get("/failed-queries")->body, "<>");
  EXPECT_EQ(get("/failed-queries/")->body, "<>");
  const auto picture = get("/failed-queries/a-1/picture");
  EXPECT_EQ(picture->body, "<a-1/picture>");
  EXPECT_EQ(picture->get_header_value("Content-Type"), "image/png");
  EXPECT_EQ(picture->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(picture->get_header_value("Cache-Control"), "no-store");
  EXPECT_EQ(get("/failed-queries/odd")->status, 404);
  EXPECT_EQ(get("/failed-queriesx")->status, 404);
  for (const std::string path : {"/failed-queries", "/failed-queries/a/picture",
                                 "/failed-queries/odd"}) {
    EXPECT_EQ(client_->Get(path)->status, 403) << path;
  }
  EXPECT_EQ(
      client_->Post("/failed-queries", inspector, "", "text/plain")->status,
      405);
}

TEST_F(GatewayTest, AnswersConnectBinary) {
  v1::GetSceneRequest request;
  request.set_scene("kitchen");
  const auto result =
      client_->Post("/treeline.v1.SceneService/GetScene", httplib::Headers{},
                    request.SerializeAsString(), "application/proto");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  EXPECT_EQ(result->get_header_value("Content-Type"), "application/proto");
  v1::GetSceneResponse response;
  ASSERT_TRUE(response.ParseFromString(result->body));
  EXPECT_EQ(response.scene().scene(), "kitchen");
}

TEST_F(GatewayTest, ServesEveryUnaryMethod) {
  for (const char* method :
       {"ListScenes", "GetScene", "LoadScene", "UnloadScene"}) {
    const auto result =
        PostJson(std::string("/treeline.v1.SceneService/") + method, "{}");
    ASSERT_TRUE(result);
    EXPECT_EQ(result->status, 200) << method;
    EXPECT_STREQ(dispatcher_.calls().back().rpc, method);
  }
}

TEST_F(GatewayTest, TellsTheDispatcherWhatTheHeadersSay) {
  const auto result = PostJson(kLocalize, "{}",
                               {{"Authorization", "bearer  abc.def"},
                                {"traceparent", "00-aa-bb-01"},
                                {"Connect-Timeout-Ms", "2000"}});
  ASSERT_TRUE(result);
  ASSERT_THAT(dispatcher_.calls(), SizeIs(1));
  const service::CallInfo call = dispatcher_.calls()[0];
  EXPECT_STREQ(call.rpc, "Localize");
  EXPECT_STREQ(call.transport, "http");
  EXPECT_EQ(call.credentials.bearer_token, "abc.def");
  EXPECT_EQ(call.traceparent, "00-aa-bb-01");
  EXPECT_EQ(call.deadline - call.arrival, std::chrono::seconds(2));
  EXPECT_THAT(call.peer, StartsWith("ipv4:127.0.0.1:"));
  EXPECT_FALSE(call.admin_listener);
}

TEST_F(GatewayTest, HasNoDeadlineAndNoTokenWithoutHeaders) {
  ASSERT_TRUE(PostJson(kLocalize, "{}", {{"Authorization", "Basic abc"}}));
  EXPECT_EQ(dispatcher_.calls()[0].deadline, base::MonotonicTime::max());
  EXPECT_THAT(dispatcher_.calls()[0].credentials.bearer_token, IsEmpty());
}

TEST_F(GatewayTest, RefusesTimeoutsThatAreNone) {
  for (const char* timeout : {"-1", "1.5", "abc", "12345678901", " "}) {
    const auto result =
        PostJson(kLocalize, "{}", {{"Connect-Timeout-Ms", timeout}});
    ASSERT_TRUE(result);
    if (std::string(timeout) == " ") continue;  // Stripped: no header.
    EXPECT_EQ(result->status, 400) << timeout;
  }
}

TEST_F(GatewayTest, AsksWhoItIsBeforeTheBodyIsRead) {
  dispatcher_.admission = absl::UnauthenticatedError("who are you?");
  // Neither JSON nor a message: nobody has looked.
  const auto result = PostJson(kLocalize, "{{{");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 401);
  EXPECT_EQ(PostJson("/treeline.v1.SceneService/LoadScene", "{{{")->status,
            401);
  EXPECT_THAT(
      dispatcher_.admitted(),
      testing::ElementsAre(service::Scope::kLocalize, service::Scope::kAdmin));
  EXPECT_THAT(dispatcher_.calls(), IsEmpty());
}

TEST_F(GatewayTest, TellsTheDispatcherWhoWasLetIn) {
  ASSERT_TRUE(PostJson(kLocalize, "{}"));
  ASSERT_THAT(dispatcher_.calls(), SizeIs(1));
  EXPECT_EQ(dispatcher_.calls()[0].client, "tester");
}

TEST_F(GatewayTest, RefusesMessagesThatWouldBecomeLarge) {
  v1::LocalizeRequest request;
  for (int i = 0; i < 20001; ++i) request.add_candidate_scenes();
  const auto result =
      client_->Post(kLocalize, httplib::Headers{}, request.SerializeAsString(),
                    "application/proto");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 400);
  EXPECT_THAT(MessageOf(result), HasSubstr("fields"));
}

// The same limit as that of the listener.
TEST_F(GatewayTest, TakesRequestsAsLargeAsTheListenerDoes) {
  v1::LocalizeRequest request;
  request.mutable_frame()->mutable_color()->set_encoded(
      std::string((1 << 20) - 100, 'x'));
  const auto result =
      client_->Post(kLocalize, httplib::Headers{}, request.SerializeAsString(),
                    "application/proto");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 200);
  ASSERT_THAT(dispatcher_.requests(), SizeIs(1));
  EXPECT_THAT(dispatcher_.requests()[0].frame().color().encoded(),
              SizeIs((1 << 20) - 100));
}

TEST_F(GatewayTest, MetricsAreForWhoMayReadThem) {
  metrics_token_ = "abc";
  EXPECT_EQ(client_->Get("/metrics")->status, 401);
  EXPECT_EQ(client_->Get("/metrics", {{"Authorization", "Bearer abc"}})->status,
            200);
  EXPECT_EQ(client_->Get("/healthz")->status, 200);
}

TEST_F(GatewayTest, NamesUnknownFields) {
  const auto result =
      PostJson(kLocalize, R"({"frame":{"camera":{"modell":"PINHOLE"}}})");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 400);
  EXPECT_EQ(CodeOf(result), "invalid_argument");
  EXPECT_THAT(MessageOf(result), HasSubstr("modell"));
  EXPECT_THAT(dispatcher_.calls(), IsEmpty());
}

TEST_F(GatewayTest, RefusesBodiesThatAreNoMessages) {
  for (const char* body : {"", "{", "[]", "{\"scene\": 3", "nonsense"}) {
    const auto result = PostJson(kLocalize, body);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->status, 400) << body;
  }
  const auto deep = PostJson(kLocalize, std::string(100000, '['));
  EXPECT_EQ(deep->status, 400);
  EXPECT_THAT(MessageOf(deep), HasSubstr("deep"));
  const auto binary = client_->Post(kLocalize, httplib::Headers{},
                                    "\xff\xff\xff", "application/proto");
  EXPECT_EQ(binary->status, 400);
}

TEST_F(GatewayTest, SendsErrorsAsConnectDoes) {
  dispatcher_.on_localize = [](const v1::LocalizeRequest&) {
    return base::WithRetryAfter(
        base::WithReason(absl::UnavailableError("the queue is full"),
                         "QUEUE_FULL"),
        std::chrono::milliseconds(1200));
  };
  const auto result = PostJson(kLocalize, "{}");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 503);
  EXPECT_EQ(result->get_header_value("Retry-After"), "2");
  const auto body = nlohmann::json::parse(result->body);
  EXPECT_EQ(body["code"], "unavailable");
  EXPECT_EQ(body["message"], "the queue is full");
  ASSERT_THAT(body["details"], SizeIs(2));
  EXPECT_EQ(body["details"][0]["type"], "google.rpc.ErrorInfo");
  EXPECT_EQ(body["details"][0]["debug"]["reason"], "QUEUE_FULL");
  std::string value;
  ASSERT_TRUE(absl::Base64Unescape(
      body["details"][0]["value"].get<std::string>(), &value));
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(value));
  EXPECT_EQ(info.reason(), "QUEUE_FULL");
}

TEST_F(GatewayTest, SaysWhatItDoesNotServe) {
  EXPECT_EQ(PostJson("/treeline.v1.SceneService/Nothing", "{}")->status, 404);
  EXPECT_EQ(PostJson("/nothing", "{}")->status, 404);
  EXPECT_EQ(client_->Get("/nothing")->status, 404);
  const auto get = client_->Get(kLocalize);
  EXPECT_EQ(get->status, 405);
  EXPECT_EQ(get->get_header_value("Allow"), "POST");
  const auto stream =
      PostJson("/treeline.v1.RelocalizationService/LocalizeStream", "{}");
  EXPECT_EQ(stream->status, 501);
  EXPECT_THAT(MessageOf(stream), HasSubstr("gRPC"));
  const auto form = client_->Post(kLocalize, httplib::Headers{}, "a=b",
                                  "application/x-www-form-urlencoded");
  EXPECT_EQ(form->status, 415);
  EXPECT_EQ(
      PostJson(kLocalize, "{}", {{"Connect-Protocol-Version", "2"}})->status,
      400);
}

TEST_F(GatewayTest, TellsHealthReadinessAndMetrics) {
  EXPECT_EQ(client_->Get("/healthz")->status, 200);
  EXPECT_EQ(client_->Get("/readyz")->status, 200);
  ready_ = false;
  EXPECT_EQ(client_->Get("/readyz")->status, 503);
  EXPECT_EQ(client_->Get("/healthz")->status, 200);
  const auto metrics = client_->Get("/metrics");
  EXPECT_EQ(metrics->status, 200);
  EXPECT_EQ(metrics->body, "treeline_up 1\n");
  EXPECT_THAT(metrics->get_header_value("Content-Type"),
              StartsWith("text/plain; version=0.0.4"));
  const auto odd = client_->Get("/metrics", {{"Accept", "application/odd"}});
  EXPECT_EQ(odd->body, "odd");
  EXPECT_EQ(odd->get_header_value("Content-Type"), "application/odd");
  EXPECT_EQ(client_->Post("/metrics")->status, 405);
  // Nobody asked for a part of it.
  EXPECT_EQ(client_->Get("/metrics", {{"Range", "bytes=0-3"}})->body,
            "treeline_up 1\n");
}

TEST_F(GatewayTest, AnOperatorsListenerSaysSoAndAClientsHasNoMetrics) {
  GatewayOptions options = DefaultOptions();
  options.serve_admin = true;
  Start(options);
  ASSERT_TRUE(PostJson("/treeline.v1.SceneService/LoadScene", "{}"));
  EXPECT_TRUE(dispatcher_.calls().back().admin_listener);
  options.serve_rpc = false;
  options.serve_metrics = false;
  Start(options);
  EXPECT_EQ(PostJson(kLocalize, "{}")->status, 404);
  EXPECT_EQ(client_->Get("/metrics")->status, 404);
  EXPECT_EQ(client_->Get("/geopose")->status, 404);
  EXPECT_EQ(client_->Get("/localize")->status, 404);
  EXPECT_EQ(client_->Get("/healthz")->status, 200);
}

TEST_F(GatewayTest, LetsAllowedPagesIn) {
  const auto preflight = client_->Options(
      kLocalize, {{"Origin", kPage},
                  {"Access-Control-Request-Method", "POST"},
                  {"Access-Control-Request-Headers", "content-type"}});
  ASSERT_TRUE(preflight);
  EXPECT_EQ(preflight->status, 204);
  EXPECT_EQ(preflight->get_header_value("Access-Control-Allow-Origin"), kPage);
  EXPECT_THAT(preflight->get_header_value("Access-Control-Allow-Headers"),
              AllOf(HasSubstr("Connect-Protocol-Version"),
                    HasSubstr("X-Treeline-Scene")));
  const auto call = PostJson(kLocalize, "{}", {{"Origin", kPage}});
  EXPECT_EQ(call->status, 200);
  EXPECT_EQ(call->get_header_value("Access-Control-Allow-Origin"), kPage);
  EXPECT_EQ(call->get_header_value("Vary"), "Origin");
  // Errors too, or the page could not read them.
  const auto error = PostJson(kLocalize, "{", {{"Origin", kPage}});
  EXPECT_EQ(error->get_header_value("Access-Control-Allow-Origin"), kPage);
}

TEST_F(GatewayTest, LetsOtherPagesNotIn) {
  for (const char* origin :
       {"https://evil.example.com", "http://app.example.com", "null",
        "https://app.example.com.evil.org", "https://app.example.com:444"}) {
    const auto preflight = client_->Options(
        kLocalize,
        {{"Origin", origin}, {"Access-Control-Request-Method", "POST"}});
    EXPECT_EQ(preflight->status, 403) << origin;
    EXPECT_FALSE(preflight->has_header("Access-Control-Allow-Origin"));
    EXPECT_FALSE(preflight->has_header("Access-Control-Allow-Methods"));
    const auto call = PostJson(kLocalize, "{}", {{"Origin", origin}});
    EXPECT_EQ(call->status, 403) << origin;
    EXPECT_FALSE(call->has_header("Access-Control-Allow-Origin"));
    const auto get = client_->Get("/healthz", {{"Origin", origin}});
    EXPECT_FALSE(get->has_header("Access-Control-Allow-Origin"));
  }
  EXPECT_THAT(dispatcher_.calls(), IsEmpty());
}

// Nobody else has a certificate of that name.
TEST(CorsPolicy, OverTlsThePageOfTheServerHasAnyName) {
  const CorsPolicy policy({}, OwnPages::kOverTls);
  const auto allows = [&](const std::string& origin, const std::string& host) {
    return !policy
                .Check({.method = "POST",
                        .headers = {{"origin", origin}, {"host", host}}})
                .has_value();
  };
  EXPECT_TRUE(allows("https://ar.example:8443", "ar.example:8443"));
  EXPECT_FALSE(allows("https://other.example", "ar.example"));
  EXPECT_FALSE(allows("http://ar.example", "ar.example"));
  EXPECT_FALSE(allows("null", "ar.example"));
}

TEST_F(GatewayTest, ThePageOfTheServerMayCallIt) {
  GatewayOptions options = DefaultOptions();
  const std::string folder = testing::TempDir() + "/gateway_ar_page";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(base::WriteNewFile(folder + "/index.html", "<p>").ok());
  options.ar_page_folder = folder;
  Start(options);
  const auto page = client_->Get("/ar/");
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(page->body, "<p>");
  EXPECT_EQ(page->get_header_value_count("Cache-Control"), 1U);
  EXPECT_EQ(page->get_header_value("Cache-Control"), "no-cache");
  EXPECT_EQ(page->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"),
              HasSubstr("default-src 'none'"));
  EXPECT_EQ(client_->Post("/ar/", "", "text/plain")->status, 405);
  const auto from = [this](const std::string& origin, const std::string& host) {
    return PostJson(kLocalize, "{}", {{"Origin", origin}, {"Host", host}})
        ->status;
  };
  const std::string own = gateway_->address();
  EXPECT_EQ(from("http://" + own, own), 200);
  EXPECT_EQ(from("http://localhost:8080", "localhost:8080"), 200);
  // A name that leads here, another port, another scheme.
  EXPECT_EQ(from("http://evil.example", "evil.example"), 403);
  EXPECT_EQ(from("http://127.0.0.1:1", own), 403);
  EXPECT_EQ(from("https://" + own, own), 403);
  // Without a page, nothing of its own asks.
  Start(DefaultOptions());
  EXPECT_EQ(from("http://" + gateway_->address(), gateway_->address()), 403);
  EXPECT_EQ(client_->Get("/ar/")->status, 404);
}

TEST_F(GatewayTest, StopsACallWhoseDeadlineHasPassed) {
  dispatcher_.waits_for_stop = true;
  const auto result = PostJson(kLocalize, "{}", {{"Connect-Timeout-Ms", "20"}});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 504);
  EXPECT_EQ(CodeOf(result), "deadline_exceeded");
}

TEST_F(GatewayTest, StopsACallWhoseClientHasGone) {
  dispatcher_.waits_for_stop = true;
  std::thread caller([this] {
    const auto result = PostJson(kLocalize, "{}");
    EXPECT_FALSE(result);
  });
  dispatcher_.AwaitCalls(1);
  client_->stop();
  caller.join();
  // Would wait for ever for a call that had not been stopped.
  gateway_->Stop(std::chrono::hours(1));
}

TEST_F(GatewayTest, StopGivesCallsInFlightTheirGraceAndThenStopsThem) {
  dispatcher_.waits_for_stop = true;
  std::thread caller([this] { std::ignore = PostJson(kLocalize, "{}"); });
  dispatcher_.AwaitCalls(1);
  gateway_->Stop(std::chrono::milliseconds(50));
  EXPECT_TRUE(dispatcher_.calls()[0].stop.stop_requested());
  caller.join();
}

TEST_F(GatewayTest, RefusesOptionsThatMakeNoSense) {
  const auto refuses = [&](const GatewayOptions& options) {
    return Gateway::Start(options, dispatcher_, {}, clock_).status().code() ==
           absl::StatusCode::kInvalidArgument;
  };
  GatewayOptions options = DefaultOptions();
  options.allowed_origins = {"*"};
  EXPECT_TRUE(refuses(options));
  options.allowed_origins = {"https://app.example.com/path"};
  EXPECT_TRUE(refuses(options));
  options = DefaultOptions();
  options.http.listen = "0.0.0.0:0";
  EXPECT_TRUE(refuses(options));
  options = DefaultOptions();
  options.http.max_body_mib = 0;
  EXPECT_TRUE(refuses(options));
  options = DefaultOptions();
  options.http.max_connections = 0;
  EXPECT_TRUE(refuses(options));
}

}  // namespace
}  // namespace treeline::gateway

#include "server/service/service_dispatcher.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/service_test_util.h"

namespace treeline::service {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr char kTraceparent[] =
    "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";

// A query, and its answer once it has one.
struct Query {
  v1::LocalizeRequest request;
  std::stop_source stop;
  absl::Notification done;
  absl::StatusOr<v1::LocalizeResponse> response = absl::UnknownError("none");
};

class ServiceDispatcherTest : public testing::Test {
 protected:
  ServiceDispatcherTest()
      : scenes_({{"kitchen", [](auto&, auto&) { return LocalizedEstimate(); }},
                 {"gate",
                  [this](auto&, auto&) {
                    at_gate_.Notify();
                    gate_.WaitForNotification();
                    return LocalizedEstimate();
                  }},
                 {"patient",
                  [this](auto&, const localizer::LocalizeOptions& options)
                      -> absl::StatusOr<localizer::PoseEstimate> {
                    at_gate_.Notify();
                    absl::Notification stopped;
                    const std::stop_callback on_stop(options.stop,
                                                     [&] { stopped.Notify(); });
                    stopped.WaitForNotification();
                    return absl::CancelledError("stopped");
                  }}}) {
    Start({.workers = 1, .queue = 2});
  }

  void Start(const DispatcherOptions& options) {
    dispatcher_.reset();
    dispatcher_.emplace(scenes_.repository(), access_, observer_, clock_,
                        options);
  }

  std::unique_ptr<Query> Begin(
      const std::string& scene, const std::string& client = "ipv4:10.0.0.1:1",
      base::MonotonicTime deadline = base::MonotonicTime::max()) {
    return Begin(TestRequest(scene), client, deadline);
  }
  std::unique_ptr<Query> Begin(
      const v1::LocalizeRequest& request,
      const std::string& client = "ipv4:10.0.0.1:1",
      base::MonotonicTime deadline = base::MonotonicTime::max()) {
    auto query = std::make_unique<Query>();
    query->request = request;
    dispatcher_->Localize({.rpc = "Localize",
                           .transport = "http",
                           .peer = client,
                           .traceparent = kTraceparent,
                           .arrival = clock_.Now(),
                           .deadline = deadline,
                           .stop = query->stop.get_token()},
                          query->request, [&query = *query](auto response) {
                            query.response = std::move(response);
                            query.done.Notify();
                          });
    return query;
  }
  absl::StatusOr<v1::LocalizeResponse> Ask(const v1::LocalizeRequest& request) {
    const auto query = Begin(request);
    query->done.WaitForNotification();
    return query->response;
  }

  absl::Notification at_gate_;
  absl::Notification gate_;
  FakeScenes scenes_;
  RecordingObserver observer_;
  OpenAccess access_;
  base::SteadyClock clock_;
  std::optional<ServiceDispatcher> dispatcher_;
};

TEST_F(ServiceDispatcherTest, AnswersAndReportsEveryCallOnce) {
  EXPECT_TRUE(Ask(TestRequest("kitchen")).ok());
  EXPECT_EQ(Ask(TestRequest("attic")).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(Ask(TestRequest("broken")).status().code(),
            absl::StatusCode::kDataLoss);
  EXPECT_EQ(Ask(v1::LocalizeRequest()).status().code(),
            absl::StatusCode::kInvalidArgument);
  const std::vector<CallRecord> records = observer_.records();
  ASSERT_EQ(records.size(), 4u);
  EXPECT_EQ(records[0].client, "ipv4:10.0.0.1");
  EXPECT_STREQ(records[0].transport, "http");
  ASSERT_TRUE(records[0].trace.has_value());
  EXPECT_EQ(records[0].trace->span_id, "b7ad6b7169203331");
  EXPECT_EQ(records[0].scene, "kitchen");
  EXPECT_EQ(records[1].scene, "attic");
  EXPECT_EQ(records[1].model_version, "");
  for (size_t i = 1; i < 4; ++i) {
    EXPECT_NE(base::ErrorInfoOf(records[i].status).reason, "") << i;
  }
}

TEST_F(ServiceDispatcherTest, OverlongSceneNamesAreNotRecordedWhole) {
  Ask(TestRequest(std::string(1 << 20, 'x'))).IgnoreError();
  EXPECT_EQ(observer_.records()[0].scene.size(), repository::kLongestName);
}

TEST_F(ServiceDispatcherTest, AbsurdOptionsAreRefusedBeforeTheyWait) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.mutable_options()->set_time_budget_ms(-1);
  EXPECT_EQ(Ask(request).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(ServiceDispatcherTest, ScenesAreTriedIfNoneIsNamed) {
  v1::LocalizeRequest request = TestRequest("");
  EXPECT_EQ(Ask(request).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(base::ErrorInfoOf(observer_.records()[0].status).reason,
            "NO_SCENE_TO_RECOGNIZE");
  // These have no descriptors, but are named.
  request.add_candidate_scenes("broken");
  request.add_candidate_scenes("kitchen");
  const auto response = Ask(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->scene(), "kitchen");
  EXPECT_EQ(response->outcome(), v1::OUTCOME_LOCALIZED);
  ASSERT_EQ(response->candidates_size(), 2);
  EXPECT_FALSE(response->candidates(0).tried());
  EXPECT_TRUE(response->candidates(1).tried());
  EXPECT_EQ(response->candidates(1).inliers(), 432);
  EXPECT_EQ(observer_.records()[1].scene, "kitchen");
  EXPECT_EQ(observer_.records()[1].model_version, "1");
}

TEST_F(ServiceDispatcherTest, CandidatesThatAllFailSayWhy) {
  v1::LocalizeRequest request = TestRequest("");
  request.add_candidate_scenes("attic");
  EXPECT_EQ(Ask(request).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(ServiceDispatcherTest, ContradictoryChoicesOfAScene) {
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.add_candidate_scenes("kitchen");
  EXPECT_EQ(Ask(request).status().code(), absl::StatusCode::kInvalidArgument);
  request = TestRequest("");
  request.add_candidate_scenes("../kitchen");
  EXPECT_EQ(Ask(request).status().code(), absl::StatusCode::kInvalidArgument);
  request = TestRequest("");
  request.set_model_version("1");
  EXPECT_EQ(Ask(request).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(ServiceDispatcherTest, AFullQueueSaysWhenToTryAgain) {
  const auto working = Begin("gate");
  at_gate_.WaitForNotification();
  const auto first = Begin("kitchen");
  const auto second = Begin("kitchen");
  const auto third = Begin("kitchen");
  EXPECT_EQ(dispatcher_->load().queued, 2);
  EXPECT_EQ(dispatcher_->load().running, 1);
  ASSERT_TRUE(third->done.HasBeenNotified());
  const absl::Status status = third->response.status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorInfoOf(status).reason, "QUEUE_FULL");
  ASSERT_TRUE(base::RetryAfterOf(status).has_value());
  EXPECT_GE(*base::RetryAfterOf(status), milliseconds(10));
  gate_.Notify();
  for (const auto* query : {&working, &first, &second}) {
    (*query)->done.WaitForNotification();
    EXPECT_TRUE((*query)->response.ok()) << (*query)->response.status();
  }
  EXPECT_EQ(observer_.records().size(), 4u);
}

TEST_F(ServiceDispatcherTest, AnotherClientGetsItsShareOfAFullQueue) {
  const auto working = Begin("gate");
  at_gate_.WaitForNotification();
  const auto first = Begin("kitchen");
  const auto second = Begin("kitchen");
  const auto other = Begin("kitchen", "ipv4:10.0.0.2:1");
  ASSERT_TRUE(second->done.HasBeenNotified());
  EXPECT_EQ(base::ErrorInfoOf(second->response.status()).reason, "QUEUE_FULL");
  EXPECT_TRUE(base::RetryAfterOf(second->response.status()).has_value());
  gate_.Notify();
  for (const auto* query : {&working, &first, &other}) {
    (*query)->done.WaitForNotification();
    EXPECT_TRUE((*query)->response.ok());
  }
  EXPECT_EQ(observer_.records().size(), 4u);
}

TEST_F(ServiceDispatcherTest, ACancelledQueryFreesItsPlaceAtOnce) {
  const auto working = Begin("gate");
  at_gate_.WaitForNotification();
  const auto waiting = Begin("kitchen");
  waiting->stop.request_stop();
  ASSERT_TRUE(waiting->done.HasBeenNotified());
  EXPECT_EQ(waiting->response.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(dispatcher_->load().queued, 0);
  gate_.Notify();
  working->done.WaitForNotification();
  EXPECT_EQ(observer_.records().size(), 2u);
}

TEST_F(ServiceDispatcherTest, ACancelledQueryStopsItsWorker) {
  const auto working = Begin("patient");
  at_gate_.WaitForNotification();
  working->stop.request_stop();
  working->done.WaitForNotification();
  EXPECT_EQ(working->response.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(base::ErrorInfoOf(working->response.status()).reason, "CANCELLED");
}

TEST_F(ServiceDispatcherTest, OneThatWasCancelledBeforeItCameIsNotWorkedOn) {
  auto query = std::make_unique<Query>();
  query->request = TestRequest("patient");
  query->stop.request_stop();
  dispatcher_->Localize({.rpc = "Localize", .stop = query->stop.get_token()},
                        query->request, [&](auto response) {
                          query->response = std::move(response);
                          query->done.Notify();
                        });
  query->done.WaitForNotification();
  EXPECT_EQ(query->response.status().code(), absl::StatusCode::kCancelled);
  EXPECT_FALSE(at_gate_.HasBeenNotified());
}

// Nothing but the dispatcher watches these deadlines.
TEST_F(ServiceDispatcherTest, TheDeadlineStopsTheWorker) {
  const auto working =
      Begin("patient", "ipv4:10.0.0.1:1", clock_.Now() + milliseconds(50));
  working->done.WaitForNotification();
  EXPECT_EQ(working->response.status().code(),
            absl::StatusCode::kDeadlineExceeded);
}

TEST_F(ServiceDispatcherTest, TheTimeBudgetStopsTheWorker) {
  v1::LocalizeRequest request = TestRequest("patient");
  request.mutable_options()->set_time_budget_ms(50);
  EXPECT_EQ(Ask(request).status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST_F(ServiceDispatcherTest, TheDeadlineEndsQueriesThatWait) {
  const auto working = Begin("gate");
  at_gate_.WaitForNotification();
  const auto waiting =
      Begin("kitchen", "ipv4:10.0.0.1:1", clock_.Now() + milliseconds(200));
  waiting->done.WaitForNotification();
  EXPECT_EQ(waiting->response.status().code(),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_FALSE(gate_.HasBeenNotified());
  gate_.Notify();
  working->done.WaitForNotification();
}

TEST_F(ServiceDispatcherTest, ADeadlineThatHasPassedCostsNothing) {
  const auto late =
      Begin("patient", "ipv4:10.0.0.1:1", clock_.Now() - milliseconds(1));
  late->done.WaitForNotification();
  EXPECT_FALSE(late->response.ok());
  EXPECT_FALSE(at_gate_.HasBeenNotified());
  EXPECT_EQ(observer_.records().size(), 1u);
}

// Who may do nothing.
class NoAccess final : public AccessPolicy {
 public:
  absl::StatusOr<Client> Admit(const CallInfo&, Scope) override {
    return base::WithReason(absl::UnauthenticatedError("who are you?"),
                            "TOKEN_MISSING");
  }
};

TEST_F(ServiceDispatcherTest, StrangersAreTurnedAwayAndReported) {
  NoAccess access;
  ServiceDispatcher dispatcher(scenes_.repository(), access, observer_, clock_,
                               {});
  const v1::LocalizeRequest request = TestRequest("patient");
  absl::Status status;
  dispatcher.Localize({.rpc = "Localize"}, request,
                      [&](const auto& answer) { status = answer.status(); });
  EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated);
  dispatcher.ListScenes({.rpc = "ListScenes"}, {},
                        [&](const auto& answer) { status = answer.status(); });
  EXPECT_EQ(base::ErrorInfoOf(status).reason, "TOKEN_MISSING");
  EXPECT_EQ(observer_.records().size(), 2u);
}

TEST(DispatcherOptions, OutOfRangeAreRefused) {
  for (const DispatcherOptions& bad :
       {DispatcherOptions{.workers = -1}, DispatcherOptions{.workers = 1025},
        DispatcherOptions{.queue = 0}, DispatcherOptions{.queue = 100001}}) {
    EXPECT_EQ(bad.Validate().code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_TRUE(DispatcherOptions{}.Validate().ok());
}

TEST_F(ServiceDispatcherTest, ScenesAreListedWithTheirState) {
  absl::StatusOr<v1::ListScenesResponse> list = absl::UnknownError("none");
  dispatcher_->ListScenes({.rpc = "ListScenes"}, {},
                          [&](auto answer) { list = std::move(answer); });
  ASSERT_TRUE(list.ok()) << list.status();
  ASSERT_EQ(list->scenes_size(), 4);
  EXPECT_EQ(list->scenes(0).scene(), "broken");
  EXPECT_THAT(observer_.records()[0].rpc, HasSubstr("ListScenes"));
}

}  // namespace
}  // namespace treeline::service

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "common/base/descriptor.h"
#include "common/flood_guard/testing_connection.h"
#include "common/flood_guard/testing_frames.h"
#include "nav_agent/service/agent_grpc_server.h"
#include "nav_agent/service/agent_stub.h"
#include "nav_agent/service/testing_navigator.h"
#include "treeline/v1/navigation.grpc.pb.h"

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;

class AgentGrpcTest : public ::testing::Test {
 protected:
  void Start(bool is_simulated = true, int max_streams = 8) {
    agent_ = std::make_unique<SteppingAgent>(is_simulated);
    auto server = AgentGrpcServer::Start(
        agent_->commands, {.listen = "127.0.0.1:0",
                           .max_streams = max_streams,
                           .report = [this](const std::string& message) {
                             const absl::MutexLock lock(&mutex_);
                             reports_.push_back(message);
                           }});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    const auto channel = grpc::CreateChannel(
        server_->address(), grpc::InsecureChannelCredentials());
    navigation_ = v1::NavigationService::NewStub(channel);
    simulation_ = v1::SimulationService::NewStub(channel);
  }
  ~AgentGrpcTest() override {
    if (agent_ != nullptr) agent_->Close();
  }
  static v1::NavigateRequest GoalAt(double x_m, double y_m) {
    v1::NavigateRequest request;
    v1::LevelPose& pose = *request.add_poses();
    pose.set_x_m(x_m);
    pose.set_y_m(y_m);
    return request;
  }
  // The goal's state, once the stepping thread has it so.
  bool BecomesCancelled() const {
    uint64_t seen = 0;
    for (;;) {
      const auto state =
          agent_->hub.WaitForNewer(seen, absl::Now() + absl::Seconds(60));
      if (state == nullptr) return false;
      seen = state->number;
      if (state->snapshot.goal.has_value() &&
          state->snapshot.goal->state == behavior::GoalState::kCancelled) {
        return true;
      }
    }
  }

  std::vector<std::string> Reports() {
    const absl::MutexLock lock(&mutex_);
    return reports_;
  }

  std::unique_ptr<SteppingAgent> agent_;
  absl::Mutex mutex_;
  std::vector<std::string> reports_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<AgentGrpcServer> server_;
  std::unique_ptr<v1::NavigationService::Stub> navigation_;
  std::unique_ptr<v1::SimulationService::Stub> simulation_;
};

TEST_F(AgentGrpcTest, ARouteTellsHowItGoesAndWhatItMissed) {
  Start();
  v1::PutRoutesRequest put;
  v1::Route& route = *put.add_routes();
  route.set_name("patrol");
  for (const double x_m : {1.0, 0.5}) {
    v1::Waypoint& waypoint = *route.add_waypoints();
    waypoint.set_x_m(x_m);
    waypoint.set_name("at");
  }
  grpc::ClientContext put_context;
  v1::PutRoutesResponse kept;
  ASSERT_TRUE(navigation_->PutRoutes(&put_context, put, &kept).ok());
  EXPECT_FALSE(kept.survives_restart());
  EXPECT_THAT(kept.warning(), HasSubstr("--state-dir"));
  v1::RunRouteRequest run;
  run.set_kept("patrol");
  grpc::ClientContext context;
  const auto stream = navigation_->RunRoute(&context, run);
  v1::RunRouteResponse one;
  while (stream->Read(&one)) {
    EXPECT_EQ(one.route().name(), "patrol");
    EXPECT_EQ(one.route().waypoints(), 2);
  }
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_TRUE(one.is_final());
  EXPECT_EQ(one.route().state(), v1::ROUTE_STATE_SUCCEEDED);
  EXPECT_EQ(one.route().reached(), 2);
  EXPECT_EQ(one.route().last_missed_size(), 0);
  EXPECT_EQ(one.route().waypoint(), 1);
  EXPECT_EQ(one.goal().state(), v1::GOAL_STATE_SUCCEEDED);
}

TEST_F(AgentGrpcTest, CommandsReachItPastAProxyOfTheEnvironment) {
  Start();
  setenv("http_proxy", "http://127.0.0.1:1", 1);
  const auto stub = AgentStub(server_->address());
  grpc::ClientContext context;
  v1::GetRoutesResponse routes;
  const grpc::Status status = stub->GetRoutes(&context, {}, &routes);
  unsetenv("http_proxy");
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(AgentGrpcTest, ARouteThatIsNotKeptIsSaidSo) {
  Start();
  const auto run = [this](const v1::RunRouteRequest& request) {
    grpc::ClientContext context;
    const auto stream = navigation_->RunRoute(&context, request);
    v1::RunRouteResponse one;
    while (stream->Read(&one)) {
    }
    return stream->Finish();
  };
  v1::RunRouteRequest request;
  EXPECT_EQ(run(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request.set_kept("patrol");
  EXPECT_EQ(run(request).error_code(), grpc::StatusCode::NOT_FOUND);
  request.mutable_route()->add_waypoints()->set_x_m(1);
  request.set_first_waypoint(-1);
  EXPECT_EQ(run(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request.set_first_waypoint(1);
  EXPECT_EQ(run(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request.set_first_waypoint(0);
  request.mutable_route()->set_when_missed(static_cast<v1::MissedPolicy>(9));
  EXPECT_EQ(run(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(AgentGrpcTest, ARouteWhoseCallerGoesIsCancelled) {
  Start();
  agent_->navigator.may_arrive = false;
  v1::RunRouteRequest request;
  request.mutable_route()->add_waypoints()->set_x_m(1);
  grpc::ClientContext context;
  const auto stream = navigation_->RunRoute(&context, request);
  v1::RunRouteResponse one;
  ASSERT_TRUE(stream->Read(&one));
  EXPECT_EQ(one.route().state(), v1::ROUTE_STATE_DRIVING);
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(BecomesCancelled());
}

TEST_F(AgentGrpcTest, NavigateTellsHowItGoesUntilTheGoal) {
  Start();
  agent_->navigator.may_arrive = false;
  grpc::ClientContext context;
  const auto stream = navigation_->Navigate(&context, GoalAt(1, 1));
  std::vector<v1::NavigateResponse> feedback;
  v1::NavigateResponse one;
  while (stream->Read(&one)) {
    feedback.push_back(one);
    agent_->navigator.may_arrive = true;
  }
  EXPECT_TRUE(stream->Finish().ok());
  ASSERT_GE(feedback.size(), 2U);
  for (size_t i = 0; i + 1 < feedback.size(); ++i) {
    EXPECT_FALSE(feedback[i].is_final());
    EXPECT_EQ(feedback[i].goal().state(), v1::GOAL_STATE_ACTIVE);
  }
  EXPECT_TRUE(feedback.back().is_final());
  EXPECT_EQ(feedback.back().goal().state(), v1::GOAL_STATE_SUCCEEDED);
  EXPECT_EQ(feedback.back().map_from_base().x_m(), 1);
}

TEST_F(AgentGrpcTest, BadGoalsAreRefused) {
  Start();
  grpc::ClientContext context;
  const auto stream = navigation_->Navigate(&context, v1::NavigateRequest());
  v1::NavigateResponse one;
  EXPECT_FALSE(stream->Read(&one));
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("a pose at least"));
}

TEST_F(AgentGrpcTest, AGoalEndsWithItsCall) {
  Start();
  grpc::ClientContext context;
  // Far enough for minutes.
  const auto stream = navigation_->Navigate(&context, GoalAt(50000, 0));
  v1::NavigateResponse one;
  ASSERT_TRUE(stream->Read(&one));
  context.TryCancel();
  EXPECT_TRUE(BecomesCancelled());
  while (stream->Read(&one)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(AgentGrpcTest, AGoalStaysIfItShould) {
  Start();
  v1::NavigateRequest request = GoalAt(50000, 0);
  request.set_keep_when_call_ends(true);
  {
    grpc::ClientContext context;
    const auto stream = navigation_->Navigate(&context, request);
    v1::NavigateResponse one;
    ASSERT_TRUE(stream->Read(&one));
    context.TryCancel();
    while (stream->Read(&one)) {
    }
    stream->Finish();
  }
  // Stopped before the agent: its calls have ended.
  server_.reset();
  agent_->Close();
  EXPECT_EQ(agent_->navigator.goal()->state, behavior::GoalState::kActive);
}

TEST_F(AgentGrpcTest, AnotherGoalTakesItsPlace) {
  Start();
  grpc::ClientContext first_context;
  const auto first = navigation_->Navigate(&first_context, GoalAt(50000, 0));
  v1::NavigateResponse one;
  ASSERT_TRUE(first->Read(&one));
  grpc::ClientContext second_context;
  const auto second = navigation_->Navigate(&second_context, GoalAt(1, 0));
  v1::NavigateResponse last;
  while (first->Read(&one)) last = one;
  EXPECT_TRUE(first->Finish().ok());
  EXPECT_TRUE(last.is_final());
  EXPECT_EQ(last.goal().cause(), v1::NAVIGATION_CAUSE_PREEMPTED);
  while (second->Read(&one)) last = one;
  EXPECT_EQ(last.goal().id(), 2U);
}

TEST_F(AgentGrpcTest, StreamsAreBounded) {
  Start(/*is_simulated=*/true, /*max_streams=*/1);
  grpc::ClientContext first_context;
  const auto first = navigation_->StreamState(&first_context, {});
  v1::StreamStateResponse one;
  ASSERT_TRUE(first->Read(&one));
  grpc::ClientContext second_context;
  const auto second = navigation_->StreamState(&second_context, {});
  EXPECT_FALSE(second->Read(&one));
  EXPECT_EQ(second->Finish().error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  first_context.TryCancel();
}

TEST_F(AgentGrpcTest, StreamStateTellsStatesAndEvents) {
  Start();
  grpc::ClientContext context;
  const auto stream = navigation_->StreamState(&context, {});
  v1::StreamStateResponse one;
  ASSERT_TRUE(stream->Read(&one));
  EXPECT_EQ(one.state().mode(), v1::NAVIGATOR_MODE_IDLE);
  agent_->hub.AddEvent(3, "lost", "the scan does not fit");
  while (one.events().empty()) ASSERT_TRUE(stream->Read(&one));
  EXPECT_EQ(one.events(0).kind(), "lost");
  context.TryCancel();
}

TEST_F(AgentGrpcTest, StreamsEndWithTheAgent) {
  Start();
  grpc::ClientContext context;
  const auto stream = navigation_->StreamState(&context, {});
  v1::StreamStateResponse one;
  ASSERT_TRUE(stream->Read(&one));
  agent_->Close();
  while (stream->Read(&one)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  grpc::ClientContext next;
  v1::PauseResponse response;
  EXPECT_EQ(navigation_->Pause(&next, {}, &response).error_code(),
            grpc::StatusCode::UNAVAILABLE);
}

TEST_F(AgentGrpcTest, GivesMaps) {
  Start();
  v1::GetMapsRequest request;
  request.add_picture_levels(1);
  grpc::ClientContext context;
  v1::GetMapsResponse response;
  ASSERT_TRUE(navigation_->GetMaps(&context, request, &response).ok());
  EXPECT_EQ(response.name(), "house");
  ASSERT_EQ(response.levels_size(), 2);
  EXPECT_EQ(response.levels(0).free_cells(), 42);
  EXPECT_TRUE(response.levels(0).png().empty());
  EXPECT_EQ(response.levels(1).png().substr(1, 3), "PNG");
  request.add_picture_levels(5);
  grpc::ClientContext second;
  EXPECT_EQ(navigation_->GetMaps(&second, request, &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(AgentGrpcTest, TakesPosesAndSmallCommands) {
  Start();
  v1::SetInitialPoseRequest pose;
  v1::SetInitialPoseResponse pose_response;
  grpc::ClientContext missing;
  EXPECT_EQ(
      navigation_->SetInitialPose(&missing, pose, &pose_response).error_code(),
      grpc::StatusCode::INVALID_ARGUMENT);
  pose.mutable_map_from_base()->set_x_m(0.5);
  grpc::ClientContext given;
  EXPECT_TRUE(navigation_->SetInitialPose(&given, pose, &pose_response).ok());
  grpc::ClientContext cancel;
  v1::CancelResponse cancelled;
  v1::CancelRequest which;
  which.set_goal_id(9);
  EXPECT_EQ(navigation_->Cancel(&cancel, which, &cancelled).error_code(),
            grpc::StatusCode::NOT_FOUND);
  grpc::ClientContext find;
  v1::FindYourselfResponse found;
  EXPECT_TRUE(navigation_->FindYourself(&find, {}, &found).ok());
  agent_->Close();
  EXPECT_EQ(agent_->navigator.snapshot.pose->pose.map_from_base.translation.x,
            0.5);
  EXPECT_EQ(agent_->navigator.mode(), behavior::NavigatorMode::kRelocalizing);
}

TEST_F(AgentGrpcTest, TheSimulationIsThereForSimulatedRobotsAlone) {
  Start();
  v1::KidnapRequest request;
  request.set_place("kitchen");
  v1::KidnapResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(simulation_->Kidnap(&context, request, &response).ok());
  EXPECT_EQ(response.map_from_base().x_m(), 3);
  v1::InjectFaultRequest fault;
  fault.set_target("laser");
  fault.set_kind("silent");
  v1::InjectFaultResponse injected;
  grpc::ClientContext fault_context;
  EXPECT_TRUE(simulation_->InjectFault(&fault_context, fault, &injected).ok());
  agent_->Close();
  server_.reset();
  EXPECT_THAT(
      agent_->simulation.calls,
      ::testing::ElementsAre("kidnap to kitchen", "fault laser silent 0 1"));
  Start(/*is_simulated=*/false);
  grpc::ClientContext real;
  EXPECT_EQ(simulation_->Kidnap(&real, request, &response).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
}

TEST(AgentGrpcOptions, DoNotOpenTheRobotToEverybody) {
  EXPECT_TRUE(AgentGrpcOptions().Validate().ok());
  EXPECT_FALSE(AgentGrpcOptions{.listen = "0.0.0.0:1"}.Validate().ok());
  EXPECT_TRUE(
      (AgentGrpcOptions{.listen = "0.0.0.0:1", .insecure_any_address = true})
          .Validate()
          .ok());
  EXPECT_FALSE(AgentGrpcOptions{.listen = "nowhere"}.Validate().ok());
  EXPECT_FALSE(AgentGrpcOptions{.max_streams = 0}.Validate().ok());
}

TEST_F(AgentGrpcTest, CutsOffWhoFloodsItAndHearsOthers) {
  Start();
  const base::Descriptor flood(flood_guard::ConnectForTest(server_->address()));
  std::string frames =
      flood_guard::kTestPreface +
      flood_guard::TestFrame(flood_guard::kTestSettings, 0, 0, "");
  for (int i = 0; i < 20'000; ++i) {
    frames += flood_guard::TestFrame(flood_guard::kTestHeaders,
                                     flood_guard::kTestEndHeaders, 2 * i + 1,
                                     "\x83\x86") +
              flood_guard::TestFrame(flood_guard::kTestReset, 0, 2 * i + 1,
                                     std::string(4, '\0'));
  }
  // What the server no longer takes cannot be sent.
  size_t sent = 0;
  while (sent < frames.size()) {
    const ssize_t more = send(flood.get(), frames.data() + sent,
                              frames.size() - sent, MSG_NOSIGNAL);
    if (more <= 0) break;
    sent += static_cast<size_t>(more);
  }
  std::array<char, 4096> bytes = {};
  ssize_t size = 0;
  do {
    size = recv(flood.get(), bytes.data(), bytes.size(), 0);
  } while (size > 0);
  EXPECT_TRUE(size == 0 || errno == ECONNRESET) << errno;
  EXPECT_THAT(Reports(),
              ::testing::ElementsAre(HasSubstr("cut off 127.0.0.1:")));

  // Its address may come back after a second.
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::seconds(60));
  v1::GetInfoResponse info;
  const grpc::Status status = navigation_->GetInfo(&context, {}, &info);
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(AgentGrpcTest, TellsWhichServicesThereAre) {
  Start();
  grpc::GenericStub stub(grpc::CreateChannel(
      server_->address(), grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  // ServerReflectionRequest with list_services.
  const grpc::Slice list_services(std::string("\x3a\x00", 2));
  const grpc::ByteBuffer request(&list_services, 1);
  grpc::ByteBuffer answer;
  absl::Notification done;
  stub.UnaryCall(
      &context,
      "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", {},
      &request, &answer, [&](const grpc::Status& status) {
        EXPECT_TRUE(status.ok()) << status.error_message();
        done.Notify();
      });
  done.WaitForNotification();
  grpc::Slice bytes;
  ASSERT_TRUE(answer.DumpToSingleSlice(&bytes).ok());
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_THAT(text, HasSubstr("treeline.v1.NavigationService"));
  EXPECT_THAT(text, HasSubstr("grpc.health.v1.Health"));
}

}  // namespace
}  // namespace treeline::agent_service

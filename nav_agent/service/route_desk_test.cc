#include "nav_agent/service/route_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "nav_agent/routes/route_file.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;

routes::Route Pair(const std::string& name) {
  return {.name = name,
          .waypoints = {{.position_in_map = {1, 1}},
                        {.position_in_map = {0, 0}, .level = 1}}};
}

class RouteDeskTest : public testing::Test {
 protected:
  std::string routes_path() const { return folder_.path() + "/routes"; }
  std::string progress_path() const {
    return folder_.path() + "/route-progress";
  }
  absl::StatusOr<std::unique_ptr<RouteDesk>> Open(int levels = 2) {
    return RouteDesk::Open(levels, folder_.path());
  }
  // Steps until the route is what is wanted.
  void StepTo(RouteDesk& desk, routes::RouteState wanted, size_t waypoint) {
    for (int i = 0; i < 1000; ++i) {
      navigator_.Step();
      now_ += std::chrono::milliseconds(25);
      desk.Step(navigator_, now_);
      const routes::RouteStatus& status = *desk.runner().status();
      if (status.state == wanted && status.progress.waypoint == waypoint) {
        return;
      }
    }
    FAIL() << "it never came to that";
  }

  base::TestingFolder folder_;
  FakeNavigator navigator_;
  base::MonotonicTime now_{std::chrono::seconds(100)};
};

TEST_F(RouteDeskTest, KeptRoutesAreFoundAgain) {
  {
    const auto desk = *Open();
    ASSERT_TRUE(desk->book().Put({Pair("a"), Pair("b")}).ok());
    routes::Route other = Pair("a");
    other.is_loop = true;
    ASSERT_TRUE(desk->book().Put({other}).ok());
    ASSERT_TRUE(desk->book().Remove({"b"}).ok());
    EXPECT_EQ(desk->book().revision(), 4U);
  }
  const auto again = *Open();
  ASSERT_EQ(again->book().contents().things.size(), 1U);
  EXPECT_TRUE(again->book().Find("a")->is_loop);
  const absl::Status missing = again->book().Find("b").status();
  EXPECT_TRUE(absl::IsNotFound(missing));
  EXPECT_THAT(missing.message(), HasSubstr("there are: 'a'"));
}

TEST_F(RouteDeskTest, ADamagedFileIsAnErrorThatSaysWhatToDo) {
  ASSERT_TRUE((*Open())->book().Put({Pair("a")}).ok());
  const std::string whole = *base::ReadFile(routes_path());
  for (const std::string& damaged :
       {std::string(), whole.substr(0, whole.size() / 2), whole + "x"}) {
    ASSERT_TRUE(base::WriteFileAtomically(routes_path(), damaged).ok());
    const absl::Status status = Open().status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
    EXPECT_THAT(status.message(), HasSubstr(routes_path()));
    EXPECT_THAT(status.message(), HasSubstr("remove the file"));
    // It is left as it was, for whoever mends it.
    EXPECT_EQ(*base::ReadFile(routes_path()), damaged);
  }
}

TEST_F(RouteDeskTest, RoutesOfAnotherMapAreAnError) {
  ASSERT_TRUE((*Open())->book().Put({Pair("a")}).ok());
  const absl::Status status = Open(1).status();
  EXPECT_THAT(status.message(), HasSubstr("is on level 1"));
  EXPECT_THAT(status.message(), HasSubstr("are they of another map?"));
}

TEST_F(RouteDeskTest, WhatCannotBeKeptIsNotPut) {
  const auto desk = *Open();
  ASSERT_TRUE(desk->book().Put({Pair("a")}).ok());
  // A full disk, as far as files are concerned: the new one cannot be made.
  std::filesystem::create_directories(
      absl::StrCat(routes_path(), ".tmp-", ::getpid(), "/in-the-way"));
  const absl::Status status = desk->book().Put({Pair("b")}).status();
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(), HasSubstr("the routes stay as they were"));
  EXPECT_FALSE(desk->book().Remove({"a"}).ok());
  EXPECT_EQ(desk->book().contents().things.size(), 1U);
  EXPECT_EQ((*Open())->book().contents().things.size(), 1U);
}

TEST_F(RouteDeskTest, AllOrNothing) {
  RouteDesk desk(1);
  EXPECT_THAT(desk.book().Put({Pair("a")}).status().message(),
              HasSubstr("the map has 0..0"));
  routes::Route good = Pair("a");
  good.waypoints.pop_back();
  ASSERT_TRUE(desk.book().Put({good}).ok());
  EXPECT_TRUE(absl::IsNotFound(desk.book().Remove({"a", "gone"}).status()));
  EXPECT_EQ(desk.book().contents().things.size(), 1U);
  EXPECT_THAT(desk.book().keeping().message(),
              HasSubstr("without --state-dir"));
  EXPECT_THAT(desk.keeping().message(), HasSubstr("without --state-dir"));
}

TEST_F(RouteDeskTest, ARouteUnderWayIsOfferedAfterARestart) {
  {
    const auto desk = *Open();
    ASSERT_TRUE(desk->Offer(now_).ok());
    EXPECT_FALSE(desk->runner().status().has_value());
    ASSERT_TRUE(desk->runner().Start(navigator_, Pair("a"), 0).ok());
    StepTo(*desk, routes::RouteState::kDriving, 1);
  }
  {
    const auto again = *Open();
    ASSERT_TRUE(again->Offer(now_).ok());
    ASSERT_TRUE(again->runner().status().has_value());
    const routes::RouteStatus& status = *again->runner().status();
    EXPECT_EQ(status.state, routes::RouteState::kOffered);
    EXPECT_EQ(status.progress.waypoint, 1U);
    EXPECT_EQ(status.progress.reached, 1);
    EXPECT_EQ(status.progress.route->name, "a");
    ASSERT_TRUE(again->runner().Resume(navigator_).ok());
    StepTo(*again, routes::RouteState::kSucceeded, 1);
    EXPECT_TRUE(again->keeping().ok());
  }
  // It is over: nobody takes it up again.
  const auto last = *Open();
  ASSERT_TRUE(last->Offer(now_).ok());
  EXPECT_FALSE(last->runner().status().has_value());
}

TEST_F(RouteDeskTest, ProgressThatIsNotUnderstoodOffersNothing) {
  for (const std::string& damaged :
       {std::string("treeline-route-prog"),
        routes::ProgressFileText(routes::RouteProgress{
            .route = std::make_shared<const routes::Route>(routes::Route{
                .waypoints = {{.position_in_map = {1, 1}, .level = 5}}})})}) {
    ASSERT_TRUE(base::WriteFileAtomically(progress_path(), damaged).ok());
    const auto desk = *Open();
    EXPECT_THAT(desk->Offer(now_).message(),
                HasSubstr("what route was under way is not known"));
    EXPECT_FALSE(desk->runner().status().has_value());
  }
}

TEST_F(RouteDeskTest, ADiskThatIsFullStopsNoRoute) {
  const auto desk = *Open();
  std::filesystem::create_directories(
      absl::StrCat(progress_path(), ".tmp-", ::getpid(), "/in-the-way"));
  ASSERT_TRUE(desk->runner().Start(navigator_, Pair("a"), 0).ok());
  StepTo(*desk, routes::RouteState::kSucceeded, 1);
  while (desk->keeping().ok()) std::this_thread::yield();
  EXPECT_THAT(desk->keeping().message(), HasSubstr(progress_path()));
}

}  // namespace
}  // namespace treeline::agent_service

// treeline learn as a process, of pictures without poses: from a video or a
// folder of photographs, by COLMAP, to a scene that a server answers from.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/dataset/trajectory_error.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/tools/capture/testing_captures.h"
#include "server/tools/photographs/structure_from_motion.h"
#include "server/tools/photographs/testing_walk.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

using photographs::AlongTheWall;
using photographs::PictureOfRoom;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr int kPictures = 24;  // 20 are needed
constexpr int kQueries = 6;
// Of the held-out views, once aligned: a hundredth of the walk.
constexpr double kNear_m = 0.03;

class LearnPictures : public testing::Test {
 protected:
  void SetUp() override {
    if (!photographs::FindColmap("colmap").ok()) {
      GTEST_SKIP() << "COLMAP is not installed: scripts/install-deps --tools";
    }
  }

  // A walk along the wall and back, at two heights; `share` in [0, 1].
  static geometry::Rigid3 WalkAt(double share) {
    return AlongTheWall(1.2 - 2.4 * std::abs(2 * share - 1),
                        0.15 * std::sin(12 * share),
                        share < 0.5 ? -0.3 : 0.3 * std::sin(20 * share));
  }
  static geometry::Rigid3 PictureAt(int i) {
    return WalkAt(static_cast<double>(i) / (kPictures - 1));
  }

  ProgramResult Learn(const std::string& source,
                      const std::vector<std::string>& more) const {
    std::vector<std::string> argv = {TREELINE_PROGRAM,
                                     "learn",
                                     folder_.Path(source),
                                     "--scene",
                                     "room",
                                     "--repository",
                                     folder_.Path("models"),
                                     "--output",
                                     folder_.Path("learnt"),
                                     "--trees",
                                     "2",
                                     "--only-tested"};
    argv.insert(argv.end(), more.begin(), more.end());
    return RunProgram(argv);
  }

  // Poses that a server answers for views between those of the walk.
  std::vector<dataset::PosePair> AskServer(int width, int height) const {
    Process server({TREELINE_SERVER_PROGRAM, "--models", folder_.Path("models"),
                    "--load-all", "--listen", "127.0.0.1:0", "--admin-listen",
                    "", "--http-listen", "", "--drain-s", "0"});
    const std::string prefix = "listening on ";
    const auto line = server.WaitForLine(prefix);
    EXPECT_TRUE(line.has_value()) << server.err();
    if (!line) return {};
    std::vector<dataset::PosePair> pairs;
    for (int i = 0; i < kQueries; ++i) {
      const geometry::Rigid3 truth = WalkAt((i + 0.4) / kQueries);
      const std::string picture = folder_.Write(
          absl::StrFormat("queries/%d.jpg", i),
          *image::EncodeJpeg(PictureOfRoom(truth, width, height), 95));
      const ProgramResult asked = RunProgram(
          {TREELINE_CLIENT_PROGRAM, "localize", "--json", "--server",
           line->substr(prefix.size()), "--scene", "room", "--color", picture,
           "--camera", photographs::WalkCameraText(width, height)});
      const Json answer = Json::parse(asked.out, nullptr, false);
      if (asked.exit_code != 0 || answer.is_discarded()) {
        ADD_FAILURE() << i << ": " << asked.out << asked.err;
        continue;
      }
      const Json& pose = answer["world_from_camera"];
      pairs.push_back(
          {.time = i,
           .estimate = {{pose["qw"], pose["qx"], pose["qy"], pose["qz"]},
                        {pose["tx"], pose["ty"], pose["tz"]}},
           .reference = truth});
    }
    return pairs;
  }

  const base::TestingFolder folder_;
};

void ExpectNear(const std::vector<dataset::PosePair>& pairs,
                dataset::TrajectoryAlignment alignment) {
  ASSERT_EQ(pairs.size(), kQueries);
  const auto error = dataset::AbsoluteTrajectoryError(pairs, alignment);
  ASSERT_TRUE(error.has_value());
  EXPECT_LT(error->position_m.rmse, kNear_m);
  EXPECT_LT(error->rotation_rad.rmse, 0.02);
  testing::Test::RecordProperty(
      "position_rmse_m", absl::StrFormat("%.4f", error->position_m.rmse));
}

void ExpectPage(const std::string& path, const std::string& what) {
  const auto page = base::ReadFile(path);
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_THAT(*page, HasSubstr(what));
}

// Filmed with a phone that was held upright: what is stored lies on its side.
// Nothing tells how large the room is.
TEST_F(LearnPictures, MakesASceneThatServesOfAVideo) {
  std::vector<image::ColorImage> stored;
  for (int i = 0; i < kPictures; ++i) {
    stored.push_back(image::Turned(PictureOfRoom(PictureAt(i), 360, 480),
                                   image::QuarterTurn::kCounterclockwise));
  }
  capture::WriteVideo(stored, image::QuarterTurn::kClockwise,
                      folder_.Path("walk.mp4"));
  const ProgramResult learnt = Learn("walk.mp4", {});
  ASSERT_EQ(learnt.exit_code, 0) << learnt.out << learnt.err;
  ExpectPage(folder_.Path("learnt/page.html"), "arbitrary unit");
  ExpectNear(AskServer(360, 480), dataset::TrajectoryAlignment::kSimilarity);
}

// One known distance: the scene is in metres.
TEST_F(LearnPictures, MakesASceneInMetresOfPhotographs) {
  for (int i = 0; i < kPictures; ++i) {
    folder_.Write(
        absl::StrFormat("photos/p%02d.jpg", i),
        *image::EncodeJpeg(PictureOfRoom(PictureAt(i), 480, 360), 95));
  }
  const double apart_m =
      geometry::Norm(PictureAt(0).translation - PictureAt(11).translation);
  const ProgramResult learnt =
      Learn("photos",
            {"--distance", absl::StrFormat("p00.jpg,p11.jpg,%.9f", apart_m)});
  ASSERT_EQ(learnt.exit_code, 0) << learnt.out << learnt.err;
  ExpectPage(folder_.Path("learnt/page.html"), "to metres, as told");
  ExpectNear(AskServer(480, 360), dataset::TrajectoryAlignment::kRigid);
}

}  // namespace
}  // namespace treeline

#include "nav_agent/app/plan/plan_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "nav_agent/traversability/level_files.h"
#include "opencv2/imgproc.hpp"

namespace treeline::plan_app {
namespace {

constexpr int kLegend_px = 96;
constexpr int kGap_px = 12;
constexpr int kMinWidth_px = 900;
constexpr double kMax_px = 1400;
constexpr double kSteepest_rad = 0.28;
const cv::Scalar kBlack(30, 30, 30);
const cv::Scalar kStartTree(60, 110, 230);
const cv::Scalar kGoalTree(40, 160, 70);
const cv::Scalar kPath(220, 30, 30);
const cv::Scalar kStart(20, 50, 190);
const cv::Scalar kGoal(10, 110, 30);
const cv::Scalar kAsked(130, 130, 130);
const cv::Scalar kBlockage(240, 140, 20);

void Write(cv::Mat& image, const std::string& text, int x, int y) {
  cv::putText(image, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.45, kBlack, 1,
              cv::LINE_AA);
}

// One level's part of the picture.
class LevelPanel {
 public:
  LevelPanel(cv::Mat& image, const traversability::NavigationMap& map,
             int level, int left, double px_per_m)
      : image_(&image),
        grid_(&map.grid(level)),
        left_(left),
        px_per_m_(px_per_m) {
    const image::ColorImage picture =
        traversability::PictureOfLevel(map.traversable(), level, kSteepest_rad);
    // OpenCV takes no const data, and does not write to it.
    const cv::Mat cells(picture.height, picture.width, CV_8UC3,
                        const_cast<uint8_t*>(picture.rgb.data()));
    const cv::Rect place(left, 0, Pixels(grid_->width), Pixels(grid_->height));
    cv::resize(cells, image(place), place.size(), 0, 0, cv::INTER_NEAREST);
    Write(image, absl::StrFormat("level %d", level), left + 8, 18);
  }

  // In 16ths of a pixel.
  cv::Point At(geometry::Vec2 in_map) const {
    const geometry::Vec2 at = grid_->map_from_grid.Inverse() * in_map;
    const double height_m = grid_->height * grid_->resolution_m;
    return {static_cast<int>(std::lround(16 * (left_ + px_per_m_ * at.x))),
            static_cast<int>(std::lround(16 * px_per_m_ * (height_m - at.y)))};
  }
  void Line(geometry::Vec2 from, geometry::Vec2 to, const cv::Scalar& color,
            int width_px) {
    cv::line(*image_, At(from), At(to), color, width_px, cv::LINE_AA, 4);
  }
  void Robot(const geometry::Rigid2& map_from_base,
             const core::RobotModel& robot, const cv::Scalar& color,
             int width_px) {
    const std::array<geometry::Vec2, 4> corners = {
        {{robot.front_m, robot.half_width_m},
         {-robot.rear_m, robot.half_width_m},
         {-robot.rear_m, -robot.half_width_m},
         {robot.front_m, -robot.half_width_m}}};
    for (size_t i = 0; i < 4; ++i) {
      Line(map_from_base * corners[i], map_from_base * corners[(i + 1) % 4],
           color, width_px);
    }
    // Where it looks.
    Line(map_from_base.translation,
         map_from_base * geometry::Vec2{robot.front_m, 0}, color, width_px);
  }
  void Disc(geometry::Vec2 center, double radius_m, const cv::Scalar& color) {
    cv::circle(*image_, At(center),
               static_cast<int>(std::lround(16 * px_per_m_ * radius_m)), color,
               2, cv::LINE_AA, 4);
  }

 private:
  int Pixels(int cells) const {
    return static_cast<int>(
        std::lround(cells * grid_->resolution_m * px_per_m_));
  }

  cv::Mat* image_;
  const core::OccupancyGrid* grid_;
  int left_;
  double px_per_m_;
};

std::vector<int> LevelsOf(const traversability::NavigationMap& map,
                          const PlanReport& report) {
  std::set<int> levels;
  for (const core::LevelPose& pose : report.result.path) {
    levels.insert(pose.place.level);
  }
  for (const core::LevelPose* pose :
       {&report.request.start, &report.request.goal}) {
    if (pose->place.level >= 0 && pose->place.level < map.levels()) {
      levels.insert(pose->place.level);
    }
  }
  if (levels.empty()) levels.insert(0);
  return {levels.begin(), levels.end()};
}

void DrawEnds(LevelPanel& panel, int level, const core::RobotModel& robot,
              const PlanReport& report) {
  const auto robot_at = [&](const core::LevelPose& pose,
                            const cv::Scalar& color, int width_px) {
    if (pose.place.level == level) {
      panel.Robot(pose.map_from_base, robot, color, width_px);
    }
  };
  const std::vector<core::LevelPose>& path = report.result.path;
  if (path.empty() || report.result.moved_start_m > 0) {
    robot_at(report.request.start, kAsked, 1);
  }
  if (path.empty() || report.result.moved_goal_m > 0) {
    robot_at(report.request.goal, kAsked, 1);
  }
  if (path.empty()) return;
  core::LevelPose start = path.front();
  start.map_from_base.yaw_rad = report.request.start.map_from_base.yaw_rad;
  robot_at(start, kStart, 2);
  robot_at(path.back(), kGoal, 2);
}

void DrawLevel(LevelPanel& panel, int level, const core::RobotModel& robot,
               const PlanReport& report) {
  const planning::PlanResult& result = report.result;
  for (size_t i = 0; i + 1 < result.tree_edges.size(); i += 2) {
    panel.Line(result.tree_edges[i], result.tree_edges[i + 1],
               i < result.start_tree_points ? kStartTree : kGoalTree, 1);
  }
  for (const planning::Blockage& blockage : report.request.blockages) {
    if (blockage.level == level) {
      panel.Disc(blockage.center, blockage.radius_m, kBlockage);
    }
  }
  for (size_t i = 1; i < result.path.size(); ++i) {
    if (result.path[i].place.level != level &&
        result.path[i - 1].place.level != level) {
      continue;
    }
    panel.Line(result.path[i - 1].map_from_base.translation,
               result.path[i].map_from_base.translation, kPath, 2);
  }
  DrawEnds(panel, level, robot, report);
}

void DrawLegend(cv::Mat& image, int top, double px_per_m,
                const PlanReport& report) {
  const std::array<std::pair<const cv::Scalar*, const char*>, 7> entries = {
      {{&kStartTree, "start's tree"},
       {&kGoalTree, "goal's tree"},
       {&kPath, "path"},
       {&kStart, "start"},
       {&kGoal, "goal"},
       {&kAsked, "as asked for"},
       {&kBlockage, "blockage"}}};
  int x = 10;
  for (const auto& [color, name] : entries) {
    cv::line(image, {x, top + 16}, {x + 20, top + 16}, *color, 3);
    Write(image, name, x + 26, top + 20);
    x += 44 + 8 * static_cast<int>(std::string(name).size());
  }
  const int meter = static_cast<int>(std::lround(px_per_m));
  cv::rectangle(image, {10, top + 40}, {10 + meter, top + 44}, kBlack,
                cv::FILLED);
  Write(image, "1 m", 16 + meter, top + 47);
  std::string text = PlanSummary(report);
  if (const size_t end = text.find('\n'); end != std::string::npos) {
    text.resize(end);
  }
  Write(image, absl::StrFormat("%s, %s", report.map_name, report.planner),
        60 + meter, top + 47);
  Write(image, text, 10, top + 75);
}

}  // namespace

image::ColorImage DrawPlanReport(const traversability::NavigationMap& map,
                                 const core::RobotModel& robot,
                                 const PlanReport& report) {
  const std::vector<int> levels = LevelsOf(map, report);
  const core::OccupancyGrid& grid = map.grid(0);
  const double width_m = grid.width * grid.resolution_m;
  const double height_m = grid.height * grid.resolution_m;
  const double px_per_m = std::min(80.0, kMax_px / std::max(width_m, height_m));
  const int panel_px = static_cast<int>(std::lround(width_m * px_per_m));
  const int height_px = static_cast<int>(std::lround(height_m * px_per_m));
  const int panels = static_cast<int>(levels.size());
  const int width_px =
      std::max(kMinWidth_px, panels * panel_px + (panels - 1) * kGap_px);
  cv::Mat image(height_px + kLegend_px, width_px, CV_8UC3,
                cv::Scalar(255, 255, 255));
  for (int i = 0; i < panels; ++i) {
    const int level = levels[static_cast<size_t>(i)];
    LevelPanel panel(image, map, level, i * (panel_px + kGap_px), px_per_m);
    DrawLevel(panel, level, robot, report);
  }
  DrawLegend(image, height_px, px_per_m, report);
  image::ColorImage picture{
      .width = width_px, .height = height_px + kLegend_px, .rgb = {}};
  picture.rgb.assign(image.datastart, image.dataend);
  return picture;
}

}  // namespace treeline::plan_app

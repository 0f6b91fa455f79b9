#include "nav_agent/mapping/scan_matcher.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "nav_agent/mapping/grid_kernels.h"

namespace treeline::mapping {
namespace {

constexpr int kMaxLevels = 7;
// The response around the best cell is looked at this far, in steps.
constexpr int kAround = 5;
constexpr int kRefinements = 12;
// Below this angle nothing is gained; above, near things are missed.
constexpr double kMinAngleStep_rad = 0.0015;
constexpr double kMaxAngleStep_rad = 0.02;

// Less than any score; how many points are added up before it is asked whether
// the rest can matter; steps uphill before a search.
constexpr double kTooLittle = -1e300;
constexpr size_t kPointsAtOnce = 32;
constexpr int kMaxClimb = 30;

// Returns scatter by this much, and so do the directions of the pieces between
// them: a wall seems to tell a little of where along it the scan was taken. So
// many points do that together that it would be believed. A return of its own
// is as a rule one of a surface seen almost along, and tells little.
constexpr double kReturnNoise_m = 0.02;
constexpr double kPretends = 8;
constexpr double kDotPretends = 0.8;

double Square(double x) { return x * x; }

int CellsOf(double length_m, double cell_m) {
  return static_cast<int>(std::ceil(length_m / cell_m - 1e-9));
}

int LevelsFor(int half_cells) {
  int levels = 1;
  while (levels < kMaxLevels && (1 << (levels + 1)) <= half_cells) ++levels;
  return levels;
}

double FarthestPoint_m(const ScanOutline& scan) {
  double farthest_m2 = 0;
  for (const geometry::Vec2& point : scan.points_m) {
    farthest_m2 = std::max(farthest_m2, geometry::Dot(point, point));
  }
  return std::sqrt(farthest_m2);
}

// Steps that move `quantile` of the points by less than a cell.
double AngleStep_rad(const ScanOutline& scan, double cell_m, double quantile) {
  std::vector<double> ranges_m;
  ranges_m.reserve(scan.size());
  for (const geometry::Vec2& point : scan.points_m)
    ranges_m.push_back(std::sqrt(geometry::Dot(point, point)));
  const auto nth =
      ranges_m.begin() +
      static_cast<ptrdiff_t>(quantile * static_cast<double>(scan.size() - 1));
  std::nth_element(ranges_m.begin(), nth, ranges_m.end());
  return std::clamp(cell_m / std::max(*nth, cell_m), kMinAngleStep_rad,
                    kMaxAngleStep_rad);
}

struct Box {
  geometry::Vec2 low;
  geometry::Vec2 high;
};

// What holds the scan at a pose, turned either way by up to turn_rad.
Box BoxOf(const ScanOutline& scan, const geometry::Rigid2& pose,
          double turn_rad) {
  Box box = {.low = pose.translation, .high = pose.translation};
  // Between three turns, points are at most so far out of what those hold.
  const double bulge =
      turn_rad < std::numbers::pi ? 1 - std::cos(0.5 * turn_rad) : 2;
  for (const double turn : {-turn_rad, 0.0, turn_rad}) {
    const double c = std::cos(pose.yaw_rad + turn);
    const double s = std::sin(pose.yaw_rad + turn);
    for (const geometry::Vec2& p : scan.points_m) {
      const geometry::Vec2 at =
          pose.translation +
          geometry::Vec2{c * p.x - s * p.y, s * p.x + c * p.y};
      const double beyond_m = bulge * std::sqrt(geometry::Dot(p, p));
      box.low = {std::min(box.low.x, at.x - beyond_m),
                 std::min(box.low.y, at.y - beyond_m)};
      box.high = {std::max(box.high.x, at.x + beyond_m),
                  std::max(box.high.y, at.y + beyond_m)};
    }
  }
  return box;
}

// One rotation of the scan: where its points fall, as offsets into the grid.
struct RotatedScan {
  double turn_rad = 0;
  std::vector<int32_t> offsets;
};

// Poses within the search, as steps: cells in x and y, turns in yaw.
class Search {
 public:
  Search(const SurfaceGrid& grid, const ScanOutline& scan,
         const geometry::Rigid2& guess, const MatchSearch& search,
         const ScanMatcherOptions& options)
      : grid_(grid),
        scan_(scan),
        guess_(guess),
        half_cells_(CellsOf(search.half_extent_m, grid.cell_m())),
        angle_step_rad_(
            AngleStep_rad(scan, grid.cell_m(), options.angle_quantile)),
        half_turns_(static_cast<int>(
            std::ceil(search.half_angle_rad / angle_step_rad_ - 1e-9))),
        per_point_(1.0 / (255.0 * static_cast<double>(scan.size()))),
        translation_penalty_(
            Square(grid.cell_m() / search.guess_sigma_m) /
            (2 * options.point_weight * static_cast<double>(scan.size()))),
        yaw_penalty_(
            Square(angle_step_rad_ / search.guess_sigma_rad) /
            (2 * options.point_weight * static_cast<double>(scan.size()))),
        log_scale_(options.point_weight * static_cast<double>(scan.size())) {
    for (int turn = -half_turns_; turn <= half_turns_; ++turn) {
      rotated_.push_back(Rotate(turn));
    }
  }

  struct Pose {
    int turn = 0;
    int x = 0;
    int y = 0;
    double score = kTooLittle;
  };

  Pose FindBest();
  // The spread of p around `best`: second moments in (x, y, yaw).
  Eigen::Matrix3d Spread(const Pose& best) const;
  bool IsAtBorder(const Pose& pose) const {
    return std::abs(pose.x) >= half_cells_ || std::abs(pose.y) >= half_cells_ ||
           std::abs(pose.turn) >= half_turns_;
  }
  geometry::Rigid2 PoseOf(const Pose& pose) const {
    return {{guess_.translation.x + pose.x * grid_.cell_m(),
             guess_.translation.y + pose.y * grid_.cell_m()},
            geometry::NormalizedAngle_rad(guess_.yaw_rad +
                                          pose.turn * angle_step_rad_)};
  }

 private:
  RotatedScan Rotate(int turn) const;
  const RotatedScan& At(int turn) const {
    return rotated_[static_cast<size_t>(turn + half_turns_)];
  }
  // The largest score of the poses (x..x+2^h-1, y..y+2^h-1); what is less than
  // `needed` may be kTooLittle.
  double Bound(int turn, int x, int y, int h, double needed) const;
  // The score of a pose uphill of the guess.
  double ClimbFromGuess() const;
  void Descend(const Pose& pose, int h, Pose* best) const;

  const SurfaceGrid& grid_;
  const ScanOutline& scan_;
  const geometry::Rigid2 guess_;
  const int half_cells_;
  const double angle_step_rad_;
  const int half_turns_;
  const double per_point_;
  const double translation_penalty_;
  const double yaw_penalty_;
  const double log_scale_;
  std::vector<RotatedScan> rotated_;
  // Some pose has as much.
  double reached_ = kTooLittle;
};

RotatedScan Search::Rotate(int turn) const {
  RotatedScan rotated;
  rotated.turn_rad = turn * angle_step_rad_;
  rotated.offsets.reserve(scan_.size());
  const geometry::Rigid2 pose = {guess_.translation,
                                 guess_.yaw_rad + rotated.turn_rad};
  const double c = std::cos(pose.yaw_rad);
  const double s = std::sin(pose.yaw_rad);
  const double scale = 1 / grid_.cell_m();
  const geometry::Vec2 offset = pose.translation - grid_.origin();
  // No step of the search, of the spread or of a block may leave the grid.
  const double margin = half_cells_ + kAround + (1 << grid_.levels());
  const double end_x = grid_.width() - margin;
  const double end_y = grid_.height() - margin;
  for (const geometry::Vec2& p : scan_.points_m) {
    const double x = (offset.x + c * p.x - s * p.y) * scale;
    const double y = (offset.y + s * p.x + c * p.y) * scale;
    if (!(x >= margin) || !(y >= margin) || !(x < end_x) || !(y < end_y)) {
      continue;
    }
    rotated.offsets.push_back(static_cast<int32_t>(y) * grid_.width() +
                              static_cast<int32_t>(x));
  }
  return rotated;
}

double Search::Bound(int turn, int x, int y, int h, double needed) const {
  const uint8_t* cells = grid_.level(h) + y * grid_.width() + x;
  const int reach = (1 << h) - 1;
  // How far the nearest pose of the block is from the guess.
  const double dx = std::max({x, -(x + reach), 0});
  const double dy = std::max({y, -(y + reach), 0});
  const double penalty =
      translation_penalty_ * (dx * dx + dy * dy) + yaw_penalty_ * turn * turn;
  // Even if all points that are left were on surfaces, it would not do.
  const double needed_sum = (needed + penalty) / per_point_ - 1;
  const std::vector<int32_t>& offsets = At(turn).offsets;
  uint32_t sum = 0;
  for (size_t begin = 0; begin < offsets.size(); begin += kPointsAtOnce) {
    const size_t left = offsets.size() - begin;
    if (sum + 255.0 * static_cast<double>(left) < needed_sum) return kTooLittle;
    const size_t end = begin + std::min(left, kPointsAtOnce);
    for (size_t i = begin; i < end; ++i) sum += cells[offsets[i]];
  }
  return sum * per_point_ - penalty;
}

void Search::Descend(const Pose& pose, int h, Pose* best) const {
  if (pose.score <= best->score) return;
  if (h == 0) {
    *best = pose;
    return;
  }
  const int half = 1 << (h - 1);
  std::array<Pose, 4> parts;
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    Pose part = {.turn = pose.turn,
                 .x = pose.x + (i % 2) * half,
                 .y = pose.y + (i / 2) * half};
    if (part.x > half_cells_ || part.y > half_cells_) continue;
    part.score = Bound(part.turn, part.x, part.y, h - 1,
                       std::max(best->score, reached_));
    parts[static_cast<size_t>(count++)] = part;
  }
  std::stable_sort(
      parts.begin(), parts.begin() + count,
      [](const Pose& a, const Pose& b) { return a.score > b.score; });
  for (int i = 0; i < count; ++i) {
    Descend(parts[static_cast<size_t>(i)], h - 1, best);
  }
}

double Search::ClimbFromGuess() const {
  Pose top;
  top.score = Bound(0, 0, 0, 0, kTooLittle);
  for (int step = 0; step < kMaxClimb; ++step) {
    const Pose from = top;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int by : {-1, 1}) {
        Pose next = from;
        int& along = axis == 0 ? next.x : axis == 1 ? next.y : next.turn;
        along += by;
        if (std::abs(along) > (axis == 2 ? half_turns_ : half_cells_)) continue;
        next.score = Bound(next.turn, next.x, next.y, 0, top.score);
        if (next.score > top.score) top = next;
      }
    }
    if (top.score <= from.score) break;
  }
  return top.score;
}

Search::Pose Search::FindBest() {
  const int top = grid_.levels() - 1;
  const int block = 1 << top;
  // What is less than a pose that is known is not the best: the search takes
  // the same one of equals as without.
  reached_ = ClimbFromGuess();
  std::vector<Pose> blocks;
  for (int turn = -half_turns_; turn <= half_turns_; ++turn) {
    for (int y = -half_cells_; y <= half_cells_; y += block) {
      for (int x = -half_cells_; x <= half_cells_; x += block) {
        const double score = Bound(turn, x, y, top, reached_);
        if (score < reached_) continue;
        blocks.push_back({.turn = turn, .x = x, .y = y, .score = score});
      }
    }
  }
  std::stable_sort(
      blocks.begin(), blocks.end(),
      [](const Pose& a, const Pose& b) { return a.score > b.score; });
  Pose best;
  for (const Pose& pose : blocks) {
    if (pose.score <= best.score) break;
    Descend(pose, top, &best);
  }
  return best;
}

Eigen::Matrix3d Search::Spread(const Pose& best) const {
  constexpr int kWidth = 2 * kAround + 1;
  static_assert(kWidth == kSumWindow);
  double total = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (int turn = best.turn - kAround; turn <= best.turn + kAround; ++turn) {
    const bool kept = std::abs(turn) <= half_turns_;
    const RotatedScan rotated = kept ? RotatedScan{} : Rotate(turn);
    const RotatedScan& at = kept ? At(turn) : rotated;
    WindowSums sums;
    const uint8_t* corner =
        grid_.level(0) + (best.y - kAround) * grid_.width() + best.x - kAround;
    SumWindows(corner, at.offsets, grid_.width(), sums);
    for (int i = 0; i < kWidth * kWidth; ++i) {
      const int dx = i % kWidth - kAround;
      const int dy = i / kWidth - kAround;
      const double score =
          sums[static_cast<size_t>(i / kWidth * kSumRow + i % kWidth)] *
              per_point_ -
          translation_penalty_ * (Square(best.x + dx) + Square(best.y + dy)) -
          yaw_penalty_ * Square(turn);
      const double p = std::exp(log_scale_ * (score - best.score));
      const Eigen::Vector3d step(dx * grid_.cell_m(), dy * grid_.cell_m(),
                                 (turn - best.turn) * angle_step_rad_);
      total += p;
      mean += p * step;
      square += p * step * step.transpose();
    }
  }
  mean /= total;
  return square / total - mean * mean.transpose();
}

Covariance3 ToCovariance(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1),
          m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

Eigen::Matrix3d WholeSearch(const MatchSearch& search) {
  // Of a uniform distribution over the search.
  return Eigen::Vector3d(Square(search.half_extent_m) / 3,
                         Square(search.half_extent_m) / 3,
                         Square(search.half_angle_rad) / 3)
      .asDiagonal();
}

// Precision of the guess. A search without one is still bounded.
Eigen::Matrix3d GuessPrecision(const MatchSearch& search) {
  const double m = 1 / Square(search.guess_sigma_m) +
                   1e-3 / std::max(1e-6, Square(search.half_extent_m));
  const double rad = 1 / Square(search.guess_sigma_rad) +
                     1e-3 / std::max(1e-6, Square(search.half_angle_rad));
  return Eigen::Vector3d(m, m, rad).asDiagonal();
}

struct Normal {
  Eigen::Matrix3d precision = Eigen::Matrix3d::Zero();
  // The part of it that is not known to be real; see kReturnNoise_m.
  Eigen::Matrix3d pretended = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double response = 0;
};

// What is known, without what is only pretended.
Eigen::Matrix3d HonestPrecision(const Normal& normal, double weight,
                                const Eigen::Matrix3d& prior) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      weight * (normal.precision - normal.pretended) + prior);
  const Eigen::Vector3d least =
      (solver.eigenvectors().transpose() * prior * solver.eigenvectors())
          .diagonal();
  const Eigen::Vector3d values = solver.eigenvalues().cwiseMax(least);
  return solver.eigenvectors() * values.asDiagonal() *
         solver.eigenvectors().transpose();
}

using Jacobian = std::array<double, 3>;

// How a point moves in a direction with x, y and yaw.
Jacobian JacobianOf(geometry::Vec2 arm, geometry::Vec2 direction) {
  return {direction.x, direction.y, geometry::Cross(arm, direction)};
}

// A sum of weight * j * j', which is symmetric.
struct ProductSum {
  std::array<double, 6> upper{};

  void Add(double weight, const Jacobian& j) {
    upper[0] += weight * j[0] * j[0];
    upper[1] += weight * j[0] * j[1];
    upper[2] += weight * j[0] * j[2];
    upper[3] += weight * j[1] * j[1];
    upper[4] += weight * j[1] * j[2];
    upper[5] += weight * j[2] * j[2];
  }
  Eigen::Matrix3d Matrix() const {
    Eigen::Matrix3d m;
    m << upper[0], upper[1], upper[2],  //
        upper[1], upper[3], upper[4],   //
        upper[2], upper[4], upper[5];
    return m;
  }
};

// Distances to the surfaces, linearised at `pose`.
Normal Linearize(const SurfaceGrid& grid, const ScanOutline& scan,
                 const geometry::Rigid2& pose) {
  Normal normal;
  ProductSum precision;
  ProductSum pretended;
  std::array<double, 3> gradient{};
  const double c = std::cos(pose.yaw_rad);
  const double s = std::sin(pose.yaw_rad);
  const double inverse_2sigma2 = 1 / (2 * Square(grid.sigma_m()));
  for (const geometry::Vec2& p : scan.points_m) {
    const geometry::Vec2 arm = {c * p.x - s * p.y, s * p.x + c * p.y};
    const geometry::Vec2 point = pose.translation + arm;
    const SurfaceGrid::Piece* piece = grid.NearestPiece(point);
    if (piece == nullptr) continue;
    const geometry::Vec2 along = piece->end - piece->begin;
    const double length2 = geometry::Dot(along, along);
    const geometry::Vec2 from = point - piece->begin;
    geometry::Vec2 off = from;
    const bool is_line = length2 > 1e-12;
    if (is_line) {
      const double t = geometry::Dot(from, along) / length2;
      off = from - std::clamp(t, 0.0, 1.0) * along;
    }
    const double weight = std::exp(-geometry::Dot(off, off) * inverse_2sigma2);
    normal.response += weight;
    if (is_line) {
      // A surface holds a point only at right angles to itself: where it ends
      // is where the reference's view of it did.
      const double length = std::sqrt(length2);
      const geometry::Vec2 across = {-along.y / length, along.x / length};
      const double off_m = geometry::Dot(from, across);
      const Jacobian j = JacobianOf(arm, across);
      precision.Add(weight, j);
      for (size_t i = 0; i < 3; ++i) gradient[i] += weight * off_m * j[i];
      pretended.Add(
          weight * std::min(1.0, kPretends * Square(kReturnNoise_m) / length2),
          JacobianOf(arm, (1 / length) * along));
    } else {
      const Jacobian x = JacobianOf(arm, {1, 0});
      const Jacobian y = JacobianOf(arm, {0, 1});
      precision.Add(weight, x);
      precision.Add(weight, y);
      for (size_t i = 0; i < 3; ++i) {
        gradient[i] += weight * off.x * x[i] + weight * off.y * y[i];
      }
      pretended.Add(weight * kDotPretends, x);
      pretended.Add(weight * kDotPretends, y);
    }
  }
  normal.precision = precision.Matrix();
  normal.pretended = pretended.Matrix();
  normal.gradient = Eigen::Vector3d(gradient.data());
  normal.response /= static_cast<double>(scan.size());
  return normal;
}

}  // namespace

absl::Status ScanMatcherOptions::Validate() const {
  if (!(cell_m > 0) || !(sigma_m >= 0.5 * cell_m) || !(sigma_m < 10) ||
      !(point_weight > 0) || !(point_weight <= 1) || !(angle_quantile > 0) ||
      !(angle_quantile <= 1)) {
    return absl::InvalidArgumentError(
        "scan matcher: cell_m must be above 0, sigma_m at least half of it, "
        "point_weight and angle_quantile from 0 to 1");
  }
  return absl::OkStatus();
}

SurfaceGrid MakeSurfaceGrid(std::span<const PlacedScan> references,
                            const ScanOutline& scan,
                            const geometry::Rigid2& guess,
                            const MatchSearch& search,
                            const ScanMatcherOptions& options) {
  const int half_cells = CellsOf(search.half_extent_m, options.cell_m);
  const int levels = LevelsFor(half_cells);
  const double margin_m =
      (half_cells + kAround + (2 << levels) + 2) * options.cell_m;
  const double turn_rad =
      search.half_angle_rad +
      (kAround + 1) * (scan.empty() ? 0
                                    : AngleStep_rad(scan, options.cell_m,
                                                    options.angle_quantile));
  const Box box = BoxOf(scan, guess, turn_rad);
  const geometry::Vec2 margin = {margin_m, margin_m};
  SurfaceGrid grid(guess.translation, FarthestPoint_m(scan) + margin_m,
                   box.low - margin, box.high + margin, options.cell_m,
                   options.sigma_m);
  for (const PlacedScan& reference : references) grid.Draw(reference);
  grid.BuildPyramid(levels);
  return grid;
}

ScanMatch RefineMatch(const SurfaceGrid& grid, const ScanOutline& scan,
                      const geometry::Rigid2& start,
                      const geometry::Rigid2& guess, const MatchSearch& search,
                      const ScanMatcherOptions& options) {
  ScanMatch match = {.target_from_scan = start,
                     .points = static_cast<int>(scan.size())};
  const Eigen::Matrix3d prior = GuessPrecision(search);
  if (scan.empty()) {
    match.covariance = ToCovariance(WholeSearch(search));
    return match;
  }
  const double weight = options.point_weight / Square(grid.sigma_m());
  Eigen::Matrix3d precision = prior;
  Eigen::Matrix3d honest = prior;
  for (int i = 0; i <= kRefinements; ++i) {
    geometry::Rigid2& pose = match.target_from_scan;
    const Normal normal = Linearize(grid, scan, pose);
    match.response = normal.response;
    precision = weight * normal.precision + prior;
    honest = HonestPrecision(normal, weight, prior);
    if (i == kRefinements) break;
    const Eigen::Vector3d off(
        pose.translation.x - guess.translation.x,
        pose.translation.y - guess.translation.y,
        geometry::NormalizedAngle_rad(pose.yaw_rad - guess.yaw_rad));
    const Eigen::Vector3d step =
        -precision.llt().solve(weight * normal.gradient + prior * off);
    // Surfaces are only known within reach.
    const double limit =
        std::min(1.0, grid.sigma_m() / std::max(1e-9, step.head<2>().norm()));
    pose.translation.x += limit * step.x();
    pose.translation.y += limit * step.y();
    pose.yaw_rad =
        geometry::NormalizedAngle_rad(pose.yaw_rad + limit * step.z());
    if (step.head<2>().norm() < 1e-5 && std::abs(step.z()) < 1e-6) break;
  }
  match.covariance = ToCovariance(honest.inverse());
  return match;
}

ScanMatch MatchScan(const SurfaceGrid& grid, const ScanOutline& scan,
                    const geometry::Rigid2& guess, const MatchSearch& search,
                    const ScanMatcherOptions& options) {
  if (scan.empty()) {
    return RefineMatch(grid, scan, guess, guess, search, options);
  }
  Search steps(grid, scan, guess, search, options);
  const Search::Pose best = steps.FindBest();
  ScanMatch match =
      RefineMatch(grid, scan, steps.PoseOf(best), guess, search, options);
  match.is_at_border = steps.IsAtBorder(best);
  const Eigen::Matrix3d spread = steps.Spread(best);
  for (int i = 0; i < 9; ++i) {
    match.covariance[static_cast<size_t>(i)] += spread(i / 3, i % 3);
  }
  return match;
}

}  // namespace treeline::mapping

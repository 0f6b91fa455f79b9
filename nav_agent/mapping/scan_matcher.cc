#include "nav_agent/mapping/scan_matcher.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace treeline::mapping {
namespace {

constexpr int kMaxLevels = 7;
// The response around the best cell is looked at this far, in steps.
constexpr int kAround = 5;
constexpr int kRefinements = 12;
// Below this angle nothing is gained; above, near things are missed.
constexpr double kMinAngleStep_rad = 0.0015;
constexpr double kMaxAngleStep_rad = 0.02;

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
  double farthest_m = 0;
  for (const geometry::Vec2& point : scan.points_m) {
    farthest_m = std::max(farthest_m, geometry::Norm(point));
  }
  return farthest_m;
}

// Steps that move `quantile` of the points by less than a cell.
double AngleStep_rad(const ScanOutline& scan, double cell_m, double quantile) {
  std::vector<double> ranges_m;
  ranges_m.reserve(scan.size());
  for (const geometry::Vec2& point : scan.points_m)
    ranges_m.push_back(geometry::Norm(point));
  const auto nth =
      ranges_m.begin() +
      static_cast<ptrdiff_t>(quantile * static_cast<double>(scan.size() - 1));
  std::nth_element(ranges_m.begin(), nth, ranges_m.end());
  return std::clamp(cell_m / std::max(*nth, cell_m), kMinAngleStep_rad,
                    kMaxAngleStep_rad);
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
    double score = -1e300;
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
  // The largest score of the poses (x..x+2^h-1, y..y+2^h-1).
  double Bound(int turn, int x, int y, int h) const;
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
  const double last = grid_.width() - 1 - margin;
  for (const geometry::Vec2& p : scan_.points_m) {
    const double x = std::floor((offset.x + c * p.x - s * p.y) * scale);
    const double y = std::floor((offset.y + s * p.x + c * p.y) * scale);
    if (!(x >= margin) || !(y >= margin) || !(x <= last) || !(y <= last)) {
      continue;
    }
    rotated.offsets.push_back(static_cast<int32_t>(y) * grid_.width() +
                              static_cast<int32_t>(x));
  }
  return rotated;
}

double Search::Bound(int turn, int x, int y, int h) const {
  const uint8_t* cells = grid_.level(h) + y * grid_.width() + x;
  uint32_t sum = 0;
  for (const int32_t offset : At(turn).offsets) sum += cells[offset];
  const int reach = (1 << h) - 1;
  // How far the nearest pose of the block is from the guess.
  const double dx = std::max({x, -(x + reach), 0});
  const double dy = std::max({y, -(y + reach), 0});
  return sum * per_point_ - translation_penalty_ * (dx * dx + dy * dy) -
         yaw_penalty_ * turn * turn;
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
    part.score = Bound(part.turn, part.x, part.y, h - 1);
    parts[static_cast<size_t>(count++)] = part;
  }
  std::stable_sort(
      parts.begin(), parts.begin() + count,
      [](const Pose& a, const Pose& b) { return a.score > b.score; });
  for (int i = 0; i < count; ++i) {
    Descend(parts[static_cast<size_t>(i)], h - 1, best);
  }
}

Search::Pose Search::FindBest() {
  const int top = grid_.levels() - 1;
  const int block = 1 << top;
  std::vector<Pose> blocks;
  for (int turn = -half_turns_; turn <= half_turns_; ++turn) {
    for (int y = -half_cells_; y <= half_cells_; y += block) {
      for (int x = -half_cells_; x <= half_cells_; x += block) {
        blocks.push_back(
            {.turn = turn, .x = x, .y = y, .score = Bound(turn, x, y, top)});
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
  double total = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (int turn = best.turn - kAround; turn <= best.turn + kAround; ++turn) {
    const bool kept = std::abs(turn) <= half_turns_;
    const RotatedScan rotated = kept ? RotatedScan{} : Rotate(turn);
    const RotatedScan& at = kept ? At(turn) : rotated;
    std::array<uint32_t, kWidth * kWidth> sums{};
    const uint8_t* corner =
        grid_.level(0) + (best.y - kAround) * grid_.width() + best.x - kAround;
    for (const int32_t offset : at.offsets) {
      for (int y = 0; y < kWidth; ++y) {
        const uint8_t* row = corner + offset + y * grid_.width();
        for (int x = 0; x < kWidth; ++x) {
          sums[static_cast<size_t>(y * kWidth + x)] += row[x];
        }
      }
    }
    for (int i = 0; i < kWidth * kWidth; ++i) {
      const int dx = i % kWidth - kAround;
      const int dy = i / kWidth - kAround;
      const double score =
          sums[static_cast<size_t>(i)] * per_point_ -
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

// Distances to the surfaces, linearised at `pose`.
Normal Linearize(const SurfaceGrid& grid, const ScanOutline& scan,
                 const geometry::Rigid2& pose) {
  Normal normal;
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
    const auto jacobian = [&arm](geometry::Vec2 direction) {
      return Eigen::Vector3d(direction.x, direction.y,
                             geometry::Cross(arm, direction));
    };
    const auto add = [&](geometry::Vec2 direction, double distance_m) {
      const Eigen::Vector3d j = jacobian(direction);
      normal.precision += weight * j * j.transpose();
      normal.gradient += weight * distance_m * j;
    };
    const auto pretend = [&](geometry::Vec2 direction, double part) {
      const Eigen::Vector3d j = jacobian(direction);
      normal.pretended += weight * part * j * j.transpose();
    };
    if (is_line) {
      // A surface holds a point only at right angles to itself: where it ends
      // is where the reference's view of it did.
      const double length = std::sqrt(length2);
      const geometry::Vec2 across = {-along.y / length, along.x / length};
      add(across, geometry::Dot(from, across));
      pretend((1 / length) * along,
              std::min(1.0, kPretends * Square(kReturnNoise_m) / length2));
    } else {
      add({1, 0}, off.x);
      add({0, 1}, off.y);
      pretend({1, 0}, kDotPretends);
      pretend({0, 1}, kDotPretends);
    }
  }
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
  SurfaceGrid grid(guess.translation, FarthestPoint_m(scan) + margin_m,
                   options.cell_m, options.sigma_m);
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

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/planning/timing/path_timing_curve.h"

namespace sinew::planning {
namespace {

constexpr double kCellsMin = 64;        // over a whole path
constexpr double kEndCells = 32;        // so many times narrower are the first and the last one
constexpr std::size_t kBendCells = 16;  // of a piece whose third derivative changes
constexpr double kUneven = 2;           // times as wide as those near by a cell may be
constexpr std::size_t kNear = 3;        // cells on each side
constexpr double kShortest = 1e-6;      // of the path: cells below that are not for this
constexpr double kFastest = 1e4;        // where nothing moves, 1/s

}  // namespace

/// The borders of cells: where pieces and sections begin, and between them.
bool SpeedCurve::cut(const PlannedPath& path) {
  borders_.clear();
  const std::size_t room = borders_.capacity();
  const double widest = length_ / kCellsMin;
  std::size_t section = 1;
  for (std::size_t i = 0; i < path.joints.size(); ++i) {
    double from = path.joints.begin(i);
    const double piece_end = path.joints.begin(i + 1);
    // A parabola that is the same at three places is level.
    PathPoint at[3];
    for (std::size_t x = 0; x < 3; ++x) {
      path.joints.sample_piece(i, (piece_end - from) * static_cast<double>(x) / 2, at[x]);
    }
    const bool bends = at[0].dddq != at[1].dddq || at[1].dddq != at[2].dddq;
    while (from < piece_end) {
      double to = piece_end;
      while (section < path.sections.size() && path.sections[section].begin <= from) ++section;
      if (section < path.sections.size()) to = std::min(to, path.sections[section].begin);
      const double parts =
          std::max(std::ceil((to - from) / widest), bends ? static_cast<double>(kBendCells) : 1.0);
      if (borders_.size() + static_cast<std::size_t>(parts) + 1 > room) return false;
      for (double p = 0; p < parts; ++p) borders_.push_back(from + (to - from) * p / parts);
      from = to;
    }
  }
  borders_.push_back(length_);
  return true;
}

/// Cells much wider than those near by are halved until none is left.
void SpeedCurve::even_out() {
  bool again = true;
  while (again) {
    again = false;
    borders_next_.clear();
    const std::size_t n = borders_.size() - 1;
    const auto wide = [&](std::size_t k) { return borders_[k + 1] - borders_[k]; };
    for (std::size_t k = 0; k < n; ++k) {
      double most = std::numeric_limits<double>::infinity();
      const auto neighbours = [&](std::size_t from, std::size_t to) {
        if (from == to) return;
        const double all = borders_[to] - borders_[from];
        most = std::min(most, kUneven * all / static_cast<double>(to - from));
      };
      neighbours(k - std::min<std::size_t>(k, kNear), k);
      neighbours(k + 1, std::min(k + 1 + kNear, n));
      // The ends, where it starts from rest, are looked at more closely.
      if (k == 0 || k + 1 == n) most = std::min(most, length_ / kCellsMin / kEndCells);
      borders_next_.push_back(borders_[k]);
      if (wide(k) > most * (1 + 1e-9) &&
          borders_next_.size() + (n - k) < borders_next_.capacity()) {
        borders_next_.push_back(borders_[k] + wide(k) / 2);
        again = true;
      }
    }
    borders_next_.push_back(length_);
    std::swap(borders_, borders_next_);
  }
}

void SpeedCurve::look(Cell& cell, double end) {
  const double from = path_->joints.begin(cell.piece);
  PathPoint at;
  const auto place = [&](double s, Place& out) {
    path_->joints.sample_piece(cell.piece, s - from, at);
    for (std::size_t j = 0; j < kMaxJoints; ++j) {
      out.d1[j] = at.dq[j] * per_jerk_[j];
      out.d2[j] = at.ddq[j] * per_jerk_[j];
      out.d3[j] = at.dddq[j] * per_jerk_[j];
    }
  };
  place(cell.begin, cell.left);
  place(end, cell.right);
  Place middle;
  place(cell.begin + (end - cell.begin) / 2, middle);
  cell.bends = cell.left.d3 != middle.d3 || middle.d3 != cell.right.d3;
  path_->joints.bound_piece(cell.piece, cell.begin - from, end - from, at);
  double most = 0, shared = 0;
  for (std::size_t j = 0; j < joints_; ++j) {
    most = std::max(most, at.dq[j] * per_velocity_[j]);
    shared += at.dq[j] * per_shared_;
  }
  cell.v_joints = std::min(kFastest, 1 / std::max(most, shared));
  const PathSection& section = path_->sections[cell.section];
  const ToolRate& tool = path_->tool[cell.piece];
  cell.v_tool = tool.speed > 0 ? section.tool_speed / tool.speed : kFastest;
  cell.tool_speed = tool.speed / section.tool_acceleration;
  cell.tool_curvature = tool.curvature / section.tool_acceleration;
  cell.share = section.joint_share;
}

bool SpeedCurve::prepare(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
                         double shared_velocity) {
  path_ = &path;
  length_ = path.joints.length();
  joints_ = limits.size();
  cells_.clear();
  stage_ = Stage::kFailed;
  per_velocity_ = per_acceleration_ = per_jerk_ = {};
  jerk_per_velocity_ = jerk_per_acceleration_ = jerk_per_shared_ = {};
  per_shared_ = 1 / shared_velocity;
  for (std::size_t j = 0; j < joints_; ++j) {
    per_velocity_[j] = 1 / limits[j].velocity;
    per_acceleration_[j] = 1 / limits[j].acceleration;
    per_jerk_[j] = 1 / limits[j].jerk;
    jerk_per_velocity_[j] = limits[j].jerk / limits[j].velocity;
    jerk_per_acceleration_[j] = limits[j].jerk / limits[j].acceleration;
    jerk_per_shared_[j] = limits[j].jerk * per_shared_;
  }
  fineness_ = 1;
  return lay_cells();
}

bool SpeedCurve::refine() {
  fineness_ *= 3;
  return lay_cells();
}

bool SpeedCurve::lay_cells() {
  const PlannedPath& path = *path_;
  cells_.clear();
  stage_ = Stage::kFailed;
  if (!cut(path)) return false;
  even_out();
  if (borders_.size() - 1 > cells_.capacity()) return false;
  std::size_t piece = 0, section = 0;
  for (std::size_t k = 0; k + 1 < borders_.size(); ++k) {
    const double middle = borders_[k] + (borders_[k + 1] - borders_[k]) / 2;
    if (borders_[k + 1] - borders_[k] < kShortest * length_) {
      cells_.clear();
      return false;
    }
    piece = path.joints.piece_at(middle, piece);
    while (section + 1 < path.sections.size() && path.sections[section + 1].begin <= middle) {
      ++section;
    }
    Cell& cell = cells_.emplace_back();
    cell.begin = borders_[k];
    cell.piece = static_cast<std::uint32_t>(piece);
    cell.section = static_cast<std::uint32_t>(section);
    look(cell, borders_[k + 1]);
  }
  return true;
}

}  // namespace sinew::planning

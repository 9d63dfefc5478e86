#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "sinew/planning/paths/path_grid.h"
#include "sinew/planning/timing/time_law.h"

namespace sinew::planning {

/// A piece of constant jerk inside one cell, during which the acceleration keeps its sign.
struct Stretch {
  PathState from;
  PathState to;
  double jerk = 0;
  double duration = 0;  ///< s
};

/// Time until a motion that begins with v >= 0 has come `distance` further; the acceleration keeps
/// its sign on the way. Infinite where it stops before. @rt
double time_over(double distance, const PathState& state, double jerk);

/// The motion through `stretch` at place s inside of it. @rt
PathState state_at(const Stretch& stretch, double s);

/// The cells of a grid in the order in which a motion comes by: forwards, or from the end back to
/// the beginning with time running backwards, where s counts from the end of the path and every
/// limit is the same.
class CellsInOrder {
 public:
  CellsInOrder(const PathGrid& grid, bool forwards) : grid_(&grid), forwards_(forwards) {}

  std::size_t size() const { return grid_->size(); }
  const PathCell& operator[](std::size_t k) const {
    return (*grid_)[forwards_ ? k : size() - 1 - k];
  }
  double begin(std::size_t k) const {
    return forwards_ ? grid_->begin(k) : grid_->length() - grid_->begin(size() - k);
  }
  double end(std::size_t k) const { return begin(k + 1); }

 private:
  const PathGrid* grid_;
  bool forwards_;
};

/// Where a sweep stands: a state within a cell.
struct SweepState {
  std::size_t cell = 0;
  PathState state;
};

/// The quickest way up under the speeds of the cells, from a >= 0: largest jerk, largest
/// acceleration, and the acceleration taken back to 0 in time, so that the speed never leaves a
/// cell's. It never brakes. Where the next cell is slower it arrives with a = 0 and goes on at that
/// cell's speed, as if the speed could jump: what a sweep from the other side is for.
///
/// Where the cells' speeds rise steadily it slides along them: the largest steady jerk that stays
/// below them for some cells, instead of the quickest way, which would be full jerk up and down
/// under every cell.
///
/// One state is as good as any other where its acceleration can still be taken back to 0 with the
/// largest jerk below all speeds and accelerations on the way: that is the test of every step.
class UpSweep {
 public:
  UpSweep(const PathGrid& grid, bool forwards) : cells_(grid, forwards) {}

  const CellsInOrder& cells() const { return cells_; }
  /// One decision: appends the stretches of it and goes on to their end. The caller gives room for
  /// what a cell can need, and stops at the last cell. @rt
  void step(SweepState& at, std::vector<Stretch>& out) const;

 private:
  /// What a state that takes its acceleration back runs into.
  struct Wall {
    std::size_t cell = kNone;  ///< at whose beginning, or within the one before
    bool speed = false;        ///< of a cell, not its acceleration
    bool none() const { return cell == kNone; }
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  Wall level_off(SweepState at) const;
  struct Push {
    Stretch parts[2];
    std::size_t size = 0;
  };
  Push push(const SweepState& at) const;
  /// How far (in cells) a slide looks, and how far it goes then.
  static constexpr std::size_t kSlideLook = 8;
  static constexpr std::size_t kSlideGo = 4;
  bool on_a_slope(std::size_t from, std::size_t wall) const;
  bool slides(SweepState at, double jerk) const;
  bool ride(SweepState& at, std::vector<Stretch>& out) const;
  bool slide(SweepState& at, std::vector<Stretch>& out) const;
  void glide(SweepState& at, double jerk, std::vector<Stretch>* out) const;
  void cruise(SweepState& at, std::vector<Stretch>& out) const;
  void follow_level_off(SweepState& at, std::size_t stop, std::vector<Stretch>& out) const;
  bool enters(const SweepState& at) const;

  CellsInOrder cells_;
};

}  // namespace sinew::planning

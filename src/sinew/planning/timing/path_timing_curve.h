#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/motion/rest_to_rest.h"
#include "sinew/planning/paths/path_grid.h"
#include "sinew/planning/paths/planned_path.h"
#include "sinew/planning/timing/time_law.h"

namespace sinew::planning {

/// The quickest motion along a curved path, found by optimisation instead of by sweeps.
///
/// With b = v^2 as a function of s, the velocities and accelerations of the joints are linear in b
/// and b', and a jerk is sqrt(b) (q''' b + 3/2 q'' b' + 1/2 q' b''). So b is a spline: parabolas
/// over the cells of the path, times a weight that rises with s^(4/3), as b does from rest. A
/// barrier keeps it inside of all limits while Newton's steps (five diagonals, so a step costs the
/// same for each cell) make the motion quicker. At the borders of the cells its speeds and
/// accelerations are joined by two phases of constant jerk each, and whether those hold all limits
/// at every instant is proven by bounds (not by samples); what does not is made slower.
///
/// The work is cut into parts: advance(n) looks at n cells at most (and sums over all cells where a
/// pass over them ends, some ns a cell), so a real-time loop can spread it over as many cycles as
/// it takes. @rt except the constructor.
class SpeedCurve {
 public:
  /// Steps of Newton's, and looks at each cell of a whole plan.
  static constexpr int kIterationsMax = 120;
  static constexpr double kStretchSettled = 1.02;
  static constexpr std::size_t kLooksMax = 3 * (kIterationsMax + 1) + 10;

  explicit SpeedCurve(std::size_t cells_max);

  /// Looks at a path, that outlives this, from the beginning to the end.
  /// @return false: not for this way of planning (too many cells).
  bool prepare(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
               double shared_velocity);
  /// Cells a third as wide, for a path that bends more than they show.
  bool refine();
  void clear() { cells_.clear(); }
  bool prepared() const { return size() > 0; }
  std::size_t size() const { return cells_.size(); }

  /// Begins to plan from rest at `s` to rest at the end. @param feed  as PathTiming::plan.
  void begin(double s, double feed);
  double start() const { return start_; }
  /// Works on; at most `cells` cells (or borders) are looked at. @return done
  bool advance(std::size_t cells);
  /// After that: whether there is a motion.
  bool found() const { return stage_ == Stage::kDone; }
  /// That motion is the quickest one; else it is inside of all limits and not more.
  bool settled() const {
    return iteration_ <= kIterationsMax && stretch_ <= kStretchSettled && !squeezed_;
  }
  int iterations() const { return iteration_; }  ///< Newton's steps

  /// `jerk` holds for `duration` from `from` on.
  struct Phase {
    PathState from;
    double jerk, duration;
  };
  /// Calls use(phase, its end, what limits it, section of the path) for each phase of the motion
  /// that was found.
  template <class Use>
  void for_each_phase(Use&& use) const {
    for (std::size_t k = first_; k < size(); ++k) {
      Joint two;
      if (!join(k, two)) return;
      const PathState* const ends[2] = {&two.phases[1].from, &two.to};
      for (std::size_t p = 0; p < 2; ++p) {
        const Phase& phase = two.phases[p];
        use(Phase{slowed(phase.from), phase.jerk / (stretch_ * stretch_ * stretch_),
                  phase.duration * stretch_},
            slowed(*ends[p]), binding_[k], cells_[k].section);
      }
    }
  }

 private:
  enum class Stage : unsigned char {
    kGuess,
    kGuessBack,
    kScale,
    kCollect,
    kBack,
    kReach,
    kVerify,
    kDone,
    kFailed
  };
  /// q', q'', q''' of the joints at one place, over their jerk limits.
  struct Place {
    JointArray d1, d2, d3;
  };
  struct Cell {
    Place left, right;
    double begin = 0;
    double v_joints = 0;  ///< by all of the joints' velocity, each and together
    double v_tool = 0;    ///< asked for
    double cap = 0;       ///< of b, at the present feed
    double share = 1;
    double tool_speed = 0, tool_curvature = 0;  ///< over the tool's acceleration
    std::uint32_t piece = 0, section = 0;
    bool bends = false;  ///< its third derivatives change
  };
  /// b, b' and b'' as linear forms of the three coefficients around a cell.
  struct Form {
    double b[3], d[3], dd[3];
  };
  struct Forms {
    Form left, right;
    double middle[3];  ///< of the parabola, without the weight
    double time;       ///< that the cell takes where that is 1
  };
  struct Values {
    double b, d, dd;
  };
  struct Bend {
    JointArray d4, d5;
  };
  struct Joint {
    Phase phases[2];
    PathState to;
  };
  struct Weight {
    double w, d, dd;
  };

  PathState slowed(const PathState& state) const {
    return {state.s, state.v / stretch_, state.a / (stretch_ * stretch_)};
  }
  bool lay_cells();
  bool cut(const PlannedPath& path);
  void even_out();
  void look(Cell& cell, double end);
  double border(std::size_t k) const { return k < size() ? cells_[k].begin : length_; }
  double begin_of(std::size_t k) const { return k == first_ ? start_ : border(k); }
  double width(std::size_t k) const { return border(k + 1) - begin_of(k); }
  Weight weight(double s) const;
  void make_forms(std::size_t k);
  static Values values(const Form& form, const double* c) {
    return {form.b[0] * c[0] + form.b[1] * c[1] + form.b[2] * c[2],
            form.d[0] * c[0] + form.d[1] * c[1] + form.d[2] * c[2],
            form.dd[0] * c[0] + form.dd[1] * c[1] + form.dd[2] * c[2]};
  }
  double load(const Cell& cell, const Place& place, const Values& at) const;
  double load_of(std::size_t k) const;
  void guess(std::size_t k);
  void guess_back(std::size_t k);
  bool work(std::size_t cells);
  void go_to(Stage stage);
  void turn_over();
  void scale();
  void tie_ends();
  void take_step();
  void judge();
  struct Sums;
  void collect(std::size_t k);
  void add_place(const Cell& cell, const Place& place, const Values& at, Sums& sums) const;
  /// The first of the three coefficients that cell k uses.
  std::size_t index(std::size_t k) const {
    return std::clamp(k, first_ + 1, size() - 2) - first_ - 1;
  }
  void eliminate(std::size_t i);
  void substitute(std::size_t i);
  double reach(std::size_t k) const;
  bool join(std::size_t k, Joint& out) const;
  void bend_of(std::size_t k, Bend& out) const;
  Values phase_bounds(std::size_t k, std::size_t j, const Bend& bend, const Phase& phase,
                      const PathState& end) const;
  static double top_speed(const Phase& phase, const PathState& end);
  double verify(std::size_t k);
  PathState state_at_border(std::size_t k) const;
  std::size_t unknowns() const { return size() - first_; }

  const PlannedPath* path_ = nullptr;
  double length_ = 0;
  std::size_t joints_ = 0;
  JointArray per_velocity_{}, per_acceleration_{}, per_jerk_{};
  JointArray jerk_per_velocity_{}, jerk_per_acceleration_{};  ///< of the limits
  JointArray jerk_per_shared_{};                              ///< velocity of all joints together
  double per_shared_ = 0;
  std::vector<Cell> cells_;
  std::vector<double> borders_, borders_next_;

  // Of the plan at hand; cell k uses the coefficients k - first_ .. k - first_ + 2.
  std::size_t first_ = 0;
  double start_ = 0;
  double feed_ = 1;
  double ramp_ = 1;  ///< of the weight
  std::vector<Forms> forms_;
  std::vector<double> squeeze_;  ///< >= 1: on the loads of a cell, so that its phases stay inside
  std::vector<double> phase_loads_;  ///< of the phases of a cell, as stretches of time
  std::vector<PathLimit> binding_;
  std::vector<double> c_, before_, step_, g_, d0_, d1_, d2_;
  double stretch_ = 1;  ///< of time at last
  Stage stage_ = Stage::kFailed;
  std::size_t at_ = 0;
  int iteration_ = 0;
  int rounds_ = 0;
  double weight_ = 0, last_weight_ = 0;
  bool measured_ = false;
  bool squeezed_ = false;  ///< some cells are too wide to tell what the joints do in them
  double fineness_ = 1;
  double promise_ = 0;  ///< of a step, of the merit: twice what it gains
  double time_pull_ = 0, limit_pull_ = 0;
  double worst_ = 0;
};

}  // namespace sinew::planning

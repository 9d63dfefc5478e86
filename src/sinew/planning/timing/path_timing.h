#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sinew/core/error.h"
#include "sinew/planning/paths/path_grid.h"
#include "sinew/planning/timing/path_sweep.h"
#include "sinew/planning/timing/path_timing_curve.h"
#include "sinew/planning/timing/time_law.h"

namespace sinew::planning {

/// How long each limit held a motion back, s.
class LimitTimes {
 public:
  void add(const PathLimit& limit, double duration) { seconds_[index(limit)] += duration; }
  void add(const LimitTimes& other);
  double of(const PathLimit& limit) const { return seconds_[index(limit)]; }
  double total() const;
  /// What held it back for longest: what to change to make it quicker.
  PathLimit largest() const;

 private:
  static constexpr std::size_t kKinds = 7;
  static std::size_t index(const PathLimit& limit) {
    return static_cast<std::size_t>(limit.kind) * (kMaxJoints + 1) +
           static_cast<std::size_t>(limit.joint + 1);
  }
  std::array<double, kKinds*(kMaxJoints + 1)> seconds_{};
};

/// What a law is for.
enum class LawUse : unsigned char {
  kQuickest,    ///< as quick as the limits allow, followed as it is
  kChangeable,  ///< a little slower: from each of its instants another plan or a stop can begin
};

/// Time along a path: s(t) in phases of constant jerk, as quick as the joints' velocities,
/// accelerations and jerks and the asked-for speeds of the tool allow, ending at rest at the path's
/// end.
///
/// A law to be followed as it is (kQuickest), along a path that bends in joint space, comes from
/// SpeedCurve: 1.02 times the time of a long optimisation, at most 1.08, over random ways.
///
/// A changeable one comes from sweeps over the cells of a PathGrid, within which speed,
/// acceleration and jerk may be anything, together: so whatever a plan begins with is allowed. It
/// takes 1.13 times the time of a long optimisation. plan() sweeps from the end backwards, with
/// time running backwards, as quickly as it can, which gives the quickest motion that still can
/// stop; and forwards from the start, as quickly as it can, until the two meet: the last instant
/// from which the forward motion still passes over into the backward one, without a jump in
/// acceleration. With limits that do not change this is the time-optimal profile of seven phases,
/// and both kinds of law are that.
///
/// The motion holds the limits at every instant, to rounding (1e-9). @rt except the constructor.
class PathTiming {
 public:
  static constexpr std::size_t kCellsMax = 2 * JointPath::kPiecesMax;
  static constexpr std::size_t kSectionsMax = 1024;

  static constexpr std::size_t kLooksMax = SpeedCurve::kLooksMax;

  explicit PathTiming(std::size_t cells_max = kCellsMax);
  /// Of a law for this, so that nothing is allocated.
  std::size_t phases_max() const { return kStretchesPerCell * grid_.capacity(); }

  /// Looks at a path, which stays as it is until the next prepare().
  /// @param limits  one per joint, all > 0 and finite.
  /// @param feed    the largest that plan() will be asked for, > 0: the limits of s leave room for
  ///                the speeds of a motion at that feed and not for more.
  /// @param use     of all laws along this path.
  /// @param shared_velocity  the sum of the joints' speeds at most, > 0; may be infinite.
  /// @error kMotionInput (index: joint, or -1: the path or the feed), kProgramTooLong.
  std::optional<Error> prepare(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
                               double feed = 1, LawUse use = LawUse::kQuickest,
                               double shared_velocity = std::numeric_limits<double>::infinity());

  /// The motion from `start` to rest at the end of the path.
  /// @param feed  (0, that of prepare()]: scales the tool speed and the share of the joints'
  ///              velocities that were asked for, never beyond what the joints may do. A start that
  ///              is quicker brakes first.
  /// @error kMotionInput: start or feed is no number or outside its range, or start moves and the
  ///        path was prepared for kQuickest; kMotionInput (limit: the path's length) where it
  ///        cannot stop before the end of the path, or rarely where no law that was found from a
  ///        moving start holds what its cells allow (measured, limit: s). No law is given out then.
  std::optional<Error> plan(const PathState& start, double feed, TimeLaw& out);

  /// plan() from rest at `s` in parts, for a loop that has little time: begin(), then advance()
  /// until it says that `out` is the law. One call looks at `cells` cells at most, and a law takes
  /// at most kLooksMax looks for each cell of SpeedCurve; the last call also writes the law. Only
  /// for kQuickest and a path that bends.
  /// @error of begin(): as plan(); kMotionInput where the law does not come from SpeedCurve.
  std::optional<Error> begin(double s, double feed);
  /// @return done; `out` is empty where there is no such law after all: then plan() has one.
  bool advance(std::size_t cells, TimeLaw& out);
  /// Cells that begin() and advance() look at.
  std::size_t curve_cells() const { return curve_.size(); }

  /// To rest on the path, as soon as the limits allow. Not for kQuickest.
  std::optional<Error> stop(const PathState& start, TimeLaw& out);
  /// The same of a motion that has followed `at_hand`, which this gave out, for `t` s. Where no
  /// braking that begins here holds the limits, it begins behind the narrow place that is in the
  /// way; where the law at hand rests no later than that, or nothing else is found, it is the rest
  /// of that law. There is always such a law. @param out  another one than `at_hand`.
  std::optional<Error> stop(const TimeLaw& at_hand, double t, TimeLaw& out);

  /// What limited the last plan, for each section of the path and over all.
  std::span<const LimitTimes> section_limit_times() const { return limit_times_; }
  LimitTimes limit_times() const;

  const PathGrid& grid() const { return grid_; }

 private:
  static constexpr std::size_t kStretchesPerCell = 6;

  /// Full jerk of one sign, from a state until its acceleration is that of the backward motion at
  /// the same place (or 0, of a motion that only stops).
  struct Meeting {
    bool found = false;
    bool at_once = false;  ///< it already was so at the start
    double gap = 0;        ///< of the speeds there: other minus own
    PathState own;
    std::size_t down = 0;  ///< stretch of the backward motion
  };
  enum class Target : unsigned char { kDown, kRest };

  bool write_curve(TimeLaw& out);
  std::optional<std::size_t> broken_cell(const TimeLaw& law, double feed_most) const;
  double feed_at(const PathState& start) const;
  void give_out(const TimeLaw& law, double feed, double feed_most);
  void follow(const TimeLaw& law, double t, double to, TimeLaw& out);
  bool brake(TimeLaw& out);
  PathState begun(PathState start) const;
  std::optional<Error> plan_sweeps(const PathState& start, double feed, TimeLaw& out);
  void refine();
  void begin_law(const PathState& start, TimeLaw& out);
  void emit(const Stretch& stretch, TimeLaw& out);
  static void put(const PathState& state, TimeLaw& out);
  static double exact_duration(const Stretch& stretch, const TimeLaw& out);
  PathLimit binding(const Stretch& stretch) const;
  bool has_room(const std::vector<Stretch>& stretches, std::size_t cell, std::size_t steps) const;
  bool sweep_back(double to);
  PathState down_at(std::size_t stretch, double s, Target target) const;
  std::size_t down_stretch(double s) const;
  Meeting meet(SweepState from, double sign, Target target, std::vector<Stretch>* way) const;
  struct Leg {
    Stretch own;
    bool stops = false;
  };
  static Leg leg(const PathState& x, double jerk, double end);
  double meeting_place(const Stretch& own, double sign, Target target, std::size_t down) const;
  bool stays_below(const SweepState& at) const;
  SweepState in_cell(const PathState& state) const;

  Error not_planned(const PathState& start) const;
  std::optional<Error> go(const PathState& start, TimeLaw& out);
  bool rise(SweepState& at, TimeLaw& out);
  void level_up(SweepState& at);
  bool pass_over(SweepState& at, TimeLaw& out);
  void follow_down(SweepState& at, TimeLaw& out);
  /// What becomes of a state that brakes, if it takes its braking back now.
  struct Look {
    bool lands = false;       ///< on the target or below it
    std::size_t blocked = 0;  ///< the cell that allows less braking than it then has
    double slower = 0;  ///< than rest would be, if that is the target; below 0: it still moves
    bool goes_on(std::size_t none) const { return !lands && blocked == none; }
  };
  Look look(const SweepState& from, Target target) const;
  double goes_on_until(const SweepState& at, const Stretch& part, Target target, Look& fails,
                       double& after) const;
  std::optional<bool> descend(SweepState& at, Target target, TimeLaw& out);
  std::size_t blocked_at(SweepState at) const;
  void relax_until(SweepState& at, std::size_t cell, TimeLaw& out);
  bool land(SweepState& at, Target target, TimeLaw& out);
  std::size_t brake_parts(const SweepState& at, Stretch (&parts)[3]) const;

  PathGrid grid_;
  SpeedCurve curve_;
  LawUse use_ = LawUse::kQuickest;
  bool refined_ = false;
  std::vector<Stretch> down_;  ///< the backward motion, in the order of s
  std::vector<Stretch> up_;    ///< the forward motion since it left the backward one
  std::vector<Stretch> way_;
  std::vector<double> speeds_;  ///< the largest in each cell, of the last plan
  std::vector<LimitTimes> limit_times_;
  std::size_t cell_ = 0;  ///< of what was emitted last
  bool unbroken_ = true;  ///< so far each stretch of the law began where the last one ended
  TimeLaw draft_;
  double feed_max_ = 1;
  // Of the law that was given out last: it is quicker than its feed allows, though not than
  // another, up to a place.
  double feed_given_ = 1;
  double feed_most_ = 1;
  double quick_until_ = -1;  ///< s
  double ceiling_ = 1;       ///< feed of which no speed of the law at hand is beyond
};

}  // namespace sinew::planning

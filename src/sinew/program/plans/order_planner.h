#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sinew/program/plans/program_plan.h"

namespace sinew::program {

/// What is told of one row of a program that is only checked.
struct RowVerdict {
  enum class Kind : std::uint8_t {
    kNothing,    ///< it does nothing by itself: loop, if, else, end
    kFine,       ///< in every round, from every place where it may begin
    kRefused,    ///< in one of them, the first: `refusal`, `round`
    kUnchecked,  ///< where it begins is not known, because row `because` is refused
  } kind = Kind::kNothing;
  double time_min = 0, time_max = 0;  ///< s, of one round; of a motion of several rows at its first
  std::size_t motion = 0;             ///< place of the first row of its motion
  std::shared_ptr<const Refusal> refusal{};  ///< of kRefused
  int round = 1;
  std::size_t because = 0;  ///< place of a row
};

/// Turns the rows of a program, in the order in which they come, into orders. Behind an `if` it
/// plans from several places at once.
class OrderPlanner {
 public:
  /// @param robot, homing  outlive this
  OrderPlanner(const RobotModel& robot, const Standing& start, const Homing& homing);

  /// Goes on behind a refused row, from where it would have left the machine, as far as that is
  /// known, and writes down what becomes of each row.
  /// @param verdicts  one per step; outlives this
  void judge(std::vector<RowVerdict>& verdicts) { verdicts_ = &verdicts; }

  /// Shown each motion, and may refuse it.
  void show_to(const WayLook& look);

  std::optional<Refusal> take_all(const Program& program);
  Plan& plan() { return plan_; }

 private:
  /// Where the machine may be, and how it came there.
  struct Stand {
    Start q;
    ToolState tool;
    double least = 0, most = 0;            ///< s since the start
    double homing = 0;                     ///< s of them, at most
    std::optional<std::size_t> lost_by{};  ///< place of a refused row, where judging
  };
  struct Planned {
    std::size_t rows = 0;
    JointVector q_end;
    double duration = 0;
    CornerStopReason stop = CornerStopReason::kNone;
    double stop_saves = 0;
    bool first_move = false;
    planning::LimitTimes limits{};
  };
  /// The rows of a motion and where it begins: loops come by the same ones again and again.
  struct Key {
    std::vector<std::size_t> places;
    std::vector<double> q_start;
    std::optional<double> jaws, held;
    auto operator<=>(const Key&) const = default;
  };
  /// What a `place` row leaves.
  struct Placed {
    ToolState tool;
    double duration = 0;  ///< s
  };
  struct Round {
    int round = 1;
    int rounds = 1;
  };
  struct OpenIf {
    std::size_t branch = 0;  ///< its order
    std::vector<Stand> before;
    std::optional<std::size_t> jump{};  ///< order, behind the first branch
    std::vector<Stand> then_ends{};
  };
  /// A loop whose rounds are asked for.
  struct OpenRounds {
    std::vector<std::size_t> branches{};  ///< orders, one a round
    std::vector<Stand> ends{};            ///< where it may be left
    std::optional<double> longest{};      ///< s, where no more rounds are expected
  };
  using Rows = std::span<const Step>;
  using Places = std::span<const std::size_t>;

  RowPlanner& planner();
  std::optional<Refusal> take(const Step& step, std::size_t place, Round round);
  std::optional<Refusal> take_alone(const Step& step, std::size_t place, Order& order);
  std::optional<Refusal> take_tool(const Step& step, std::size_t place, Order& order);
  Expected<void> check_jaws(const Stand& stand, double to);
  std::optional<Refusal> take_home(const Step& step, std::size_t place, Order& order);
  std::optional<Refusal> finish();
  std::optional<Refusal> take_pick(const Step& step, std::size_t place, Order& order);
  std::optional<Refusal> take_place(const Step& step, std::size_t place, Order& order);
  std::expected<Placed, Refusal> planned_place(const Stand& stand, const Step& step,
                                               std::size_t place);
  int expected_rounds(const Condition& goes_on) const;
  void pass_time(double least, double most);
  std::optional<Refusal> begin_round(const Step& step, const Condition& goes_on, std::size_t place,
                                     Round round);
  std::optional<Refusal> end_rounds(const Step& step);
  std::optional<Refusal> check_places(const Step& step) const;
  std::optional<Refusal> begin_branch(const Step& step, const IfStep& branch, std::size_t place);
  std::optional<Refusal> other_branch(const Step& step);
  std::optional<Refusal> end_branch(const Step& step);
  std::optional<Refusal> condition_refusal(const Condition& condition, const Step& step) const;
  /// A refusal, or where judging its verdict.
  std::optional<Refusal> refuse(const Refusal& refusal, std::size_t place);
  std::optional<Refusal> add(Order order);
  std::expected<Planned, Refusal> advance(Stand& stand, Rows rows, Places places);
  std::expected<Planned, Refusal> plan_motion(const Stand& stand, Rows rows, Places places);
  std::expected<HomeOrder, Refusal> plan_home(int line);
  void recover(Stand& stand, const Step& row, std::size_t place, const Refusal& refusal);
  Planned lost(Stand& stand, const Step& row, std::size_t place);
  void tell_fine(Places places, double least, double most);
  static bool same(const Stand& a, const Stand& b);
  static void merge(std::vector<Stand>& into, const std::vector<Stand>& more);

  const RobotModel& robot_;
  const Homing& homing_;
  std::vector<Stand> stands_;               ///< all different, at least one
  std::shared_ptr<const HomeReturn> back_;  ///< the same for each `home`
  Plan plan_;
  std::vector<OpenIf> open_;
  std::vector<OpenRounds> rounds_;
  std::unique_ptr<RowPlanner> planner_;
  std::map<Key, Planned> known_;
  std::map<Key, Placed> placed_;
  const TableTop* table_ = nullptr;  ///< null: not known
  int unexpected_ = 0;               ///< loops in a round that is not expected
  std::vector<Step> rows_;           ///< that wait for the next one to blend with
  std::vector<std::size_t> places_;
  Round first_;
  Round now_;
  std::vector<RowVerdict>* verdicts_ = nullptr;
};

}  // namespace sinew::program

#pragma once

#include <deque>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/control/machine.h"
#include "sinew/core/quantity.h"
#include "sinew/program/plans/home_return.h"

/// Work that a person and a program do together on a machine: homing, recovery, commissioning. A
/// procedure is a list of steps; most of them ask something, some move something, some look.
namespace sinew::program {

/// What an automatic look at the machine found.
struct Verdict {
  bool good = true;
  std::string words;  ///< with its numbers
  std::optional<double> number{};
};

struct StepResult;
class Procedure;

/// Something to read, or to do by hand. Answer: yes.
struct TellStep {};
/// Looks by itself; nothing while it cannot say yet.
struct CheckStep {
  std::function<std::optional<Verdict>(const Procedure&)> look;
  Duration patience = std::chrono::seconds(2);
};
/// Moves one joint by a little, asks which way it went, and moves it back. A machine that does not
/// know where it is needs a device that can be nudged. Answers: go, then plus, minus, nothing or
/// other, or again.
struct MotionStep {
  std::size_t joint = 0;
  double way = 0;     ///< rad or m; the other way where that would leave the joint's limits
  std::string plus;   ///< what people see where the joint grows
  std::string minus;  ///< and where it shrinks
  bool asks = true;   ///< else it only goes there
};
/// One joint by hand, as often as it takes: an amount with its sign moves it, done ends it.
/// `all` before the amount moves every joint by it, in turns of one small step each.
struct AdjustStep {
  std::size_t joint = 0;
};
/// One of these words.
struct ChoiceStep {
  std::vector<std::string> words;
};
/// A number with its unit.
struct NumberStep {
  Measure measure = Measure::kLength;
  double lower = 0;  ///< SI
  double upper = 0;
  /// Why a number within them is none all the same: a sentence; nothing where it may be.
  std::function<std::optional<std::string>(const Procedure&, double)> refuses{};
};
/// Finds the zeros. The longest time of each joint's search, s; may be empty.
struct SearchStep {
  FixedVector<double, kMaxJoints> times{};
};
/// A slow first move to the robot's home, from nobody knows where.
struct FirstMoveStep {};
/// From where it knows that it stands to the robot's home, as a program's `home` row ends.
struct HomeMoveStep {};
/// A tool at work, or a service of the device: whatever ends by itself.
struct GiveStep {
  control::CommandWhat what;
};
/// Where the machine stands, from somebody who looks: one of these names, a value a joint, or
/// `shown` where it stands as its intervals say, which stay. Where something else is known,
/// `NAME moved: REASON`.
struct PlaceStep {
  struct Place {
    std::string name;
    JointVector q;
  };
  std::vector<Place> places;
};

struct ProcedureStep {
  std::string id;    ///< unique in its procedure, stable: answers are kept by it
  std::string text;  ///< what a person reads
  std::variant<TellStep, CheckStep, MotionStep, AdjustStep, ChoiceStep, NumberStep, SearchStep,
               FirstMoveStep, HomeMoveStep, GiveStep, PlaceStep>
      what;
  std::string hint{};     ///< where it went wrong: what helps
  bool optional = false;  ///< may be answered with: skip
  /// Only where this holds.
  std::function<bool(const Procedure&)> when{};
};

struct StepResult {
  enum class State : std::uint8_t { kOpen, kDone, kSkipped, kFailed } state = State::kOpen;
  std::string answer;  ///< as it was given
  std::string words;   ///< what was found
  std::optional<double> number{};
};

struct ProcedurePlan {
  std::string id;     ///< "home", "recover", "commission"
  std::string title;  ///< for people
  std::vector<ProcedureStep> steps;
};

/// Goes through a plan as a client of its machine, as Run does with a program: no clock, no port;
/// poll() follows each step of the machine's controller. It stands here and not in control because
/// it plans motions, and because the controller need not know who its clients are.
///
///   phase      | what happens                       | next
///   -----------+------------------------------------+------------------------------------------
///   kOpening   | the machine is ready               | kWorking or kAsking
///   kAsking    | answer()                           | the same, kWorking, or the next step's
///   kWorking   | a look, or something that moves, ends | kAsking, or the next step's
///   kAsking    | back()                             | kAsking: the step before, anew
///   any        | cancel()                           | kCancelling, or kCancelled where nothing
///   moves kCancelling| the machine rests                  | kCancelled; nothing is given behind it
///   any        | a fault                            | kFailed
///   kOpening   | the lease is lost                  | kFailed
///   kAsking, kWorking | the lease is lost           | kAsking at the same step, left() until
///              |                                    | rejoin() has it again
///   last step  | done                               | kDone
class Procedure {
 public:
  enum class Phase : std::uint8_t {
    kOpening,
    kAsking,
    kWorking,
    kCancelling,
    kDone,
    kCancelled,
    kFailed,
  };

  /// @param machine  outlives this
  Procedure(ProcedurePlan plan, control::Machine& machine);

  /// What was answered before, of the steps that only ask: those are not asked again. Before
  /// start().
  void keep(std::string_view step, const StepResult& result);
  void take_over() { take_over_ = true; }
  /// Where a way home begins if nobody knows it: of simulated machines.
  void assume(const JointVector& q) { assumed_ = q; }
  /// A sentence on an error, from somebody who knows more of it than the machine does; nothing
  /// where that one does not.
  void explain_by(std::function<std::optional<std::string>(const Error&)> explain) {
    explain_ = std::move(explain);
  }

  void start(Instant now);
  void poll(Instant now);
  /// @error  a sentence; nothing moves then, and the question stands
  std::expected<void, std::string> answer(std::string_view text, Instant now);
  /// @error  a sentence
  std::expected<void, std::string> back(Instant now);
  void cancel(Instant now);
  /// The lease is lost: what moved has been stopped, and the question stands.
  bool left() const { return left_alone_; }
  /// The lease is lost, and an answer to the question would move something.
  bool waits_for_control() const;
  /// Asks for the lease again, where it was left or its machine acts for another client now.
  void rejoin(bool take_over);

  Phase phase() const { return phase_; }
  bool finished() const { return phase_ >= Phase::kDone; }
  const ProcedurePlan& plan() const { return plan_; }
  const control::Machine& machine() const { return machine_; }
  /// Counted from 0; as many as there are steps behind the last.
  std::size_t place() const { return place_; }
  /// Only while place() is below the number of steps: a procedure that is done stands at none.
  const ProcedureStep& step() const { return plan_.steps[place_]; }
  const std::vector<StepResult>& results() const { return results_; }
  const StepResult* result(std::string_view id) const;
  /// What is to be answered now; empty where nothing is.
  std::string question() const;
  std::vector<std::string> choices() const;
  /// What goes on while nobody is asked; the joint that is searched for, and for how long.
  std::string progress(Instant now) const;
  /// s since what goes on has begun; of a search, that of its joint.
  double working_for(Instant now) const;
  /// s that the search of this joint may take; nothing where nobody knows or nothing is searched.
  std::optional<double> working_at_most() const;
  /// That the step under way moves or searches; nothing where it is about none.
  std::optional<std::size_t> joint() const;
  /// Why the question stands still, or why the procedure has failed: a sentence.
  const std::string& trouble() const { return trouble_; }
  /// A motion given to the controller may still be looked at by it.
  bool motion_in_use() const { return command_ != 0 && motion_; }

 private:
  using Event = control::ControlEvent;

  void take(const Event& event, Instant now);
  void take_lease(const Event& event);
  void opening();
  void enter(Instant now);
  void begin_work(Instant now);
  void work(Instant now);
  void next(Instant now);
  void end_step(StepResult::State state, std::string words, std::optional<double> number = {});
  void command_done(Instant now);
  void ask_again(std::string trouble);
  void fail(std::string trouble);
  bool asks_first() const;
  std::size_t moving_joint() const;
  std::optional<std::string> go(double way);
  std::optional<std::string> follow(const JointVector& from, const RowMotion& motion,
                                    const planning::PlannedMotion& planned,
                                    std::vector<LinkPair> overlaps = {});
  Expected<RowMotion> slow_way(const JointVector& from, JointStep row);
  std::optional<std::string> first_move(Instant now);
  std::optional<std::string> blind_first_move();
  std::optional<std::string> home_move();
  std::optional<std::string> next_leg();
  std::expected<void, std::string> answer_motion(const MotionStep& step, std::string_view text,
                                                 Instant now);
  std::expected<void, std::string> answer_adjust(std::string_view text, Instant now);
  std::expected<void, std::string> answer_place(const PlaceStep& step, std::string_view text);
  bool shows_all() const;
  bool nudge_next();
  std::expected<void, std::string> answer_rest(std::string_view text, Instant now);
  void follow_search(Instant now);
  void end_search(Instant now);
  std::string sentence(const Error& error) const;

  ProcedurePlan plan_;
  control::Machine& machine_;
  const RobotModel& robot_;
  std::vector<StepResult> results_;
  std::vector<std::size_t> asked_;  ///< steps that have been gone through, for back()
  std::size_t place_ = 0;
  Phase phase_ = Phase::kOpening;
  bool take_over_ = false;
  bool enabling_ = false;
  bool begun_ = false;  ///< the lease has been had
  bool left_alone_ = false;
  bool ends_held_ = false;  ///< a motion that the loss of the lease holds on its path
  std::string trouble_;
  std::function<std::optional<std::string>(const Error&)> explain_;

  // Of the step under way.
  Instant since_{};
  std::uint32_t command_ = 0;
  std::unique_ptr<control::MotionSource> motion_;
  std::unique_ptr<RowPlanner> planner_;
  std::deque<HomeLeg> homeward_;  ///< what is left of the way home
  std::optional<JointVector> assumed_;
  bool assumes_ = false;  ///< it is being declared
  double way_ = 0;        ///< that the joint was sent
  double left_ = 0;       ///< of it
  double part_ = 0;       ///< of it, that each joint goes by in this turn
  bool all_ = false;      ///< joints go by it
  std::size_t turn_ = 0;  ///< the joint of this turn, where all of them go
  double adjusted_ = 0;
  bool went_ = false;
  bool comes_back_ = false;
  std::string said_;  ///< which way it went
  std::string given_;
  std::optional<std::size_t> searching_;
  bool search_begun_ = false;  ///< of this step: what it has found is not searched for again
  Instant searching_since_{};
  std::array<double, kMaxJoints> searched_{};  ///< s
};

/// "done", "skipped", ..
std::string_view name(StepResult::State state);
std::string_view name(Procedure::Phase phase);

}  // namespace sinew::program

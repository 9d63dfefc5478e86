#include "sinew/program/procedures/procedure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/control/piece_motion.h"
#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/model/error_sentence.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/program/plans/holdable_motion.h"
#include "sinew/program/plans/home_return.h"
#include "sinew/program/plans/program_plan.h"
#include "sinew/program/procedures/procedure_words.h"

namespace sinew::program {

using control::MachineState;

namespace {

/// Of a joint's speed, for what somebody stands beside.
constexpr double kSlowShare = 0.1;

/// What answers to this step never move anything.
bool moves_nothing(const ProcedureStep& step) {
  return std::holds_alternative<TellStep>(step.what) ||
         std::holds_alternative<ChoiceStep>(step.what) ||
         std::holds_alternative<NumberStep>(step.what);
}

/// Steps that only ask: their answers hold when the machine is another day's.
bool only_asks(const ProcedureStep& step) {
  return moves_nothing(step) ||
         (std::holds_alternative<MotionStep>(step.what) && std::get<MotionStep>(step.what).asks);
}

}  // namespace

std::string_view name(StepResult::State state) {
  constexpr std::array<std::string_view, 4> kNames{"open", "done", "skipped", "failed"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string_view name(Procedure::Phase phase) {
  constexpr std::array<std::string_view, 7> kNames{"opening", "asking",    "working", "cancelling",
                                                   "done",    "cancelled", "failed"};
  return kNames[static_cast<std::size_t>(phase)];
}

Procedure::Procedure(ProcedurePlan plan, control::Machine& machine)
    : plan_(std::move(plan)),
      machine_(machine),
      robot_(machine.robot()),
      results_(plan_.steps.size()) {
  SINEW_ASSERT(!plan_.steps.empty());
}

void Procedure::keep(std::string_view step, const StepResult& result) {
  for (std::size_t k = 0; k < plan_.steps.size(); ++k) {
    const bool answered =
        result.state == StepResult::State::kDone || result.state == StepResult::State::kSkipped;
    if (plan_.steps[k].id == step && only_asks(plan_.steps[k]) && answered) results_[k] = result;
  }
}

const StepResult* Procedure::result(std::string_view id) const {
  for (std::size_t k = 0; k < plan_.steps.size(); ++k) {
    if (plan_.steps[k].id == id) return &results_[k];
  }
  return nullptr;
}

std::string Procedure::sentence(const Error& error) const {
  if (explain_) {
    if (auto told = explain_(error)) return std::move(*told);
  }
  return sentence_of(error, robot_);
}

void Procedure::start(Instant now) {
  since_ = now;
  machine_.give(control::TakeLease{.take_over = take_over_});
}

void Procedure::fail(std::string trouble) {
  if (finished()) return;
  if (command_ != 0) machine_.give(control::Stop{});
  trouble_ = std::move(trouble);
  phase_ = phase_ == Phase::kCancelling ? Phase::kCancelled : Phase::kFailed;
}

void Procedure::cancel(Instant /*now*/) {
  if (finished() || phase_ == Phase::kCancelling) return;
  machine_.give(control::Stop{});
  phase_ = command_ != 0 ? Phase::kCancelling : Phase::kCancelled;
}

void Procedure::poll(Instant now) {
  while (const auto event = machine_.take_event()) take(*event, now);
  if (finished()) return;
  // Not before it rests: a stop that comes late would end what the next client begins.
  if (ends_held_ && command_ != 0 && machine_.state() == MachineState::kHeld) {
    ends_held_ = false;
    machine_.give(control::Stop{});
  }
  if (begun_ && machine_.state() == MachineState::kFault) {
    return fail(machine_.latched() ? sentence(machine_.latched()->error)
                                   : "the machine is in a fault");
  }
  if (phase_ == Phase::kOpening) {
    opening();
    if (begun_ && machine_.state() == MachineState::kReady) enter(now);
  }
  // A doubt of the driver's, or somebody's motion that comes to rest.
  if (phase_ == Phase::kWorking && (command_ != 0 || machine_.state() == MachineState::kReady)) {
    work(now);
  }
}

/// Lease and power, one after the other.
void Procedure::opening() {
  if (machine_.lease().epoch == 0) return;
  begun_ = true;
  if (machine_.state() != MachineState::kOff || enabling_) return;
  enabling_ = true;
  machine_.give(control::Enable{});
}

void Procedure::take(const Event& event, Instant now) {
  using Kind = Event::Kind;
  if (finished()) {
    if (is_end(event.kind) && event.command == command_) command_ = 0;
    return;
  }
  if (event.kind == Kind::kLease && begun_) return take_lease(event);
  const bool ended_badly = event.kind == Kind::kRefused || event.kind == Kind::kFailed;
  if (phase_ == Phase::kOpening && ended_badly) return fail(sentence(event.error));
  if (command_ == 0 || event.command != command_ || !is_end(event.kind)) return;
  command_ = 0;
  ends_held_ = false;
  if (phase_ == Phase::kCancelling) {
    phase_ = Phase::kCancelled;
    return;
  }
  switch (event.kind) {
    case Kind::kDone:
      return command_done(now);
    case Kind::kStopped:
      if (left_alone_) return ask_again("control was lost on the way");
      if (event.cause == control::StopCause::kLeaseEnded) {
        // The next client has control already, and nothing is wrong.
        ask_again({});
        return trouble_.clear();
      }
      return ask_again(event.cause == control::StopCause::kClient
                           ? "stopped on the way"
                           : "stopped on the way: " +
                                 std::string(control::stop_rule(event.cause).name));
    default:
      return ask_again(sentence(event.error));
  }
}

/// Without the lease nothing goes on: the machine brings to rest what moves, and the step is asked
/// for again.
void Procedure::take_lease(const Event& event) {
  if (machine_.lease().epoch != 0) {
    if (left_alone_) trouble_.clear();
    left_alone_ = false;
    return;
  }
  const std::string why = event.lease.epoch != 0 ? "another client has taken control"
                                                 : "the client that had control is gone";
  if (phase_ == Phase::kOpening) return fail(why);
  left_alone_ = true;
  if (phase_ == Phase::kCancelling) return;
  ends_held_ = command_ != 0;
  if (!ends_held_) ask_again(why);
}

bool Procedure::waits_for_control() const {
  return left_alone_ && !finished() && !moves_nothing(step());
}

void Procedure::rejoin(bool take_over) {
  if (machine_.lease().epoch == 0) machine_.give(control::TakeLease{.take_over = take_over});
}

/// The question of the step under way once more: something did not go.
void Procedure::ask_again(std::string trouble) {
  const std::string& hint = step().hint;
  trouble_ = std::move(trouble) + (hint.empty() ? "" : "; " + hint);
  went_ = comes_back_ = assumes_ = false;
  left_ = 0;
  homeward_.clear();
  searching_.reset();
  phase_ = Phase::kAsking;
}

/// Something has to be said before it begins.
bool Procedure::asks_first() const {
  return !std::holds_alternative<CheckStep>(step().what);
}

/// The step under way, from its beginning; those that are answered or do not apply are passed.
void Procedure::enter(Instant now) {
  for (; place_ < plan_.steps.size(); ++place_) {
    if (results_[place_].state != StepResult::State::kOpen) continue;
    if (!step().when || step().when(*this)) break;
    results_[place_].state = StepResult::State::kSkipped;
    results_[place_].words = "not needed";
  }
  went_ = comes_back_ = false;
  left_ = way_ = adjusted_ = 0;
  all_ = false;
  searching_.reset();
  search_begun_ = false;
  trouble_.clear();
  since_ = now;
  if (place_ == plan_.steps.size()) {
    phase_ = Phase::kDone;
    return;
  }
  phase_ = asks_first() ? Phase::kAsking : Phase::kWorking;
}

void Procedure::next(Instant now) {
  ++place_;
  enter(now);
}

void Procedure::end_step(StepResult::State state, std::string words, std::optional<double> number) {
  results_[place_] = {state, given_, std::move(words), number};
  asked_.push_back(place_);
  given_.clear();
}

void Procedure::work(Instant now) {
  if (std::holds_alternative<SearchStep>(step().what)) return follow_search(now);
  const auto* check = std::get_if<CheckStep>(&step().what);
  if (check == nullptr || command_ != 0) return;
  const auto verdict = check->look(*this);
  if (!verdict && now - since_ < check->patience) return;
  if (!verdict) return ask_again("the machine does not tell");
  if (!verdict->good) {
    results_[place_].words = verdict->words;
    return ask_again(verdict->words);
  }
  end_step(StepResult::State::kDone, verdict->words, verdict->number);
  next(now);
}

// What moves.

std::size_t Procedure::moving_joint() const {
  if (const auto* motion = std::get_if<MotionStep>(&step().what)) return motion->joint;
  return all_ ? turn_ : std::get<AdjustStep>(step().what).joint;
}

/// All joints go by one small step each before any goes by a second one: a platform keeps level.
bool Procedure::nudge_next() {
  if (!all_ || part_ == 0 || turn_ + 1 >= robot_.joints.size()) return false;
  ++turn_;
  command_ = machine_.give(control::Nudge{static_cast<std::uint8_t>(turn_), part_});
  return true;
}

/// @return  why it does not begin
std::optional<std::string> Procedure::go(double way) {
  turn_ = 0;
  const std::size_t joint = moving_joint();
  const double most = nudge_max(robot_, joint);
  left_ = way;
  part_ = 0;
  if (const auto from = machine_.reference()) {
    JointStep row{.q = home_joints(robot_), .given = 0, .how = {}};
    for (double& q : row.q) q = 0;
    for (std::size_t j = 0; j < row.q.size(); ++j) {
      if (j != joint && !all_) continue;
      row.q[j] = way;
      row.given = row.relative = static_cast<std::uint8_t>(row.given | 1U << j);
    }
    const auto motion = slow_way(*from, row);
    if (!motion) return sentence(motion.error());
    if (motion->pieces.empty()) return "there is no way to go";
    left_ = 0;
    return follow(*from, *motion, planner_->motion());
  }
  if (!(most > 0)) {
    return "nobody knows where the machine is, and it cannot be moved by a little from there";
  }
  part_ = std::clamp(way, -most, most);
  left_ = way - part_;
  command_ = machine_.give(control::Nudge{static_cast<std::uint8_t>(joint), part_});
  phase_ = Phase::kWorking;
  return std::nullopt;
}

/// @return  why it does not begin
std::optional<std::string> Procedure::follow(const JointVector& from, const RowMotion& motion,
                                             const planning::PlannedMotion& planned,
                                             std::vector<LinkPair> overlaps) {
  auto made = holdable_motion(robot_, from, motion, planned, 1, std::move(overlaps));
  if (!made) return sentence(made.error());
  motion_ = std::move(*made);
  command_ = machine_.give(control::Begin{.motion = motion_.get()});
  phase_ = Phase::kWorking;
  return std::nullopt;
}

/// A joint move, slow where the device can be.
Expected<RowMotion> Procedure::slow_way(const JointVector& from, JointStep row) {
  row.how.joint_share = robot_.device.capability.takes_speed ? kSlowShare : 1;
  const Step one{0, row};
  if (!planner_) planner_ = std::make_unique<RowPlanner>(robot_);
  auto planned = planner_->plan(from, machine_.tool(), std::span(&one, 1));
  if (!planned) return std::unexpected(planned.error().error);
  return std::move(*planned);
}

std::optional<std::string> Procedure::first_move(Instant now) {
  const JointVector q = home_joints(robot_);
  if (const auto from = machine_.reference(); from && plannable(*from, robot_)) {
    // Somebody knows where it is already: a way as any other, and none where it stands there.
    JointStep row{.q = q, .given = 0, .how = {}};
    row.given = static_cast<std::uint8_t>((1U << q.size()) - 1);
    const auto motion = slow_way(*from, row);
    // A limp arm may lie against itself: it goes as one whose place nobody knows.
    if (!motion && motion.error().code == ErrorCode::kCollision) return blind_first_move();
    if (!motion) return sentence(motion.error());
    if (motion->pieces.empty()) {
      end_step(StepResult::State::kDone, "it stands there already");
      next(now);
      return std::nullopt;
    }
    return follow(*from, *motion, planner_->motion());
  }
  return blind_first_move();
}

std::optional<std::string> Procedure::blind_first_move() {
  const JointVector q = home_joints(robot_);
  JointMove move{.q = q, .qd = {}, .duration = from_seconds(first_move_duration(robot_))};
  move.qd.resize(q.size());
  motion_ = std::make_unique<control::PieceMotion>(machine_.reference().value_or(JointVector{}),
                                                   std::vector<JointMove>(1, move), robot_);
  command_ = machine_.give(control::Begin{.motion = motion_.get(), .recovers = true});
  phase_ = Phase::kWorking;
  return std::nullopt;
}

std::optional<std::string> Procedure::home_move() {
  homeward_.clear();
  const auto from = machine_.reference();
  if (!from && assumed_) {
    control::Declare declare;
    for (const double q : *assumed_) {
      declare.positions.push_back({PositionQuality::kCommanded, q, q, q});
    }
    assumes_ = true;
    command_ = machine_.give(declare);
    phase_ = Phase::kWorking;
    return std::nullopt;
  }
  if (!from) return "position unknown; sinew recover ROBOT (the procedure recover) finds it";
  auto back = home_return(robot_, *from, 0);
  if (!back) {
    const char* slowly = "; sinew recover ROBOT (the procedure recover) goes there slowly";
    // Where a recovery asks for small steps, or searches the zeros, it ends with this same way.
    const bool helps = robot_.device.capability.nudge_max == 0 && boards_of(robot_.device).empty();
    return sentence(back.error().error) + (helps ? slowly : "");
  }
  for (HomeLeg& leg : back->legs) {
    if (!leg.motion.pieces.empty()) homeward_.push_back(std::move(leg));
  }
  if (homeward_.empty()) {
    const auto out = first_left_out(robot_);
    if (out && *from != home_joints(robot_)) {
      end_step(StepResult::State::kSkipped, "while " + robot_.joints[*out].name +
                                                " is left out no way home is known to be clear");
    } else {
      end_step(StepResult::State::kDone, "the robot is at its home pose");
    }
    next(since_);
    return std::nullopt;
  }
  return next_leg();
}

/// @return  why it does not begin
std::optional<std::string> Procedure::next_leg() {
  HomeLeg leg = std::move(homeward_.front());
  homeward_.pop_front();
  return follow(machine_.reference().value_or(JointVector{}), leg.motion, leg.planned,
                std::move(leg.overlaps));
}

void Procedure::begin_work(Instant now) {
  trouble_.clear();
  since_ = now;
  std::optional<std::string> why;
  if (const auto* motion = std::get_if<MotionStep>(&step().what)) {
    way_ = motion->way;
    const JointPosition& at = machine_.positions()[motion->joint];
    const Joint& joint = robot_.joints[motion->joint];
    if (at.quality != PositionQuality::kLost && !within_limits(joint, at.q + way_)) way_ = -way_;
    why = go(way_);
  } else if (std::holds_alternative<FirstMoveStep>(step().what)) {
    why = first_move(now);
  } else if (std::holds_alternative<HomeMoveStep>(step().what)) {
    why = home_move();
  } else if (std::holds_alternative<SearchStep>(step().what)) {
    if (!search_begun_) searched_.fill(0);
    searching_.reset();
    command_ = machine_.give(control::Home{.resumes = search_begun_});
    phase_ = Phase::kWorking;
  } else if (const auto* order = std::get_if<GiveStep>(&step().what)) {
    command_ = machine_.give(order->what);
    phase_ = Phase::kWorking;
  }
  if (why) ask_again(*why);
}

void Procedure::follow_search(Instant now) {
  const auto joint = machine_.homing_joint();
  if (joint == searching_) return;
  search_begun_ = true;
  if (searching_ && *searching_ < kMaxJoints) {
    searched_[*searching_] = to_seconds(now - searching_since_);
  }
  searching_ = joint;
  searching_since_ = now;
}

void Procedure::end_search(Instant now) {
  follow_search(now);
  std::string words;
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    if (searched_[j] <= 0) continue;
    words += (words.empty() ? "" : ", ") + robot_.joints[j].name + " " + seconds_text(searched_[j]);
  }
  end_step(StepResult::State::kDone, words.empty() ? "zeros found" : "zeros found: " + words);
  next(now);
}

void Procedure::command_done(Instant now) {
  if (std::holds_alternative<SearchStep>(step().what)) return end_search(now);
  if (std::exchange(assumes_, false)) {
    assumed_.reset();
    return begin_work(now);
  }
  if (!homeward_.empty()) {
    if (const auto why = next_leg()) ask_again(*why);
    return;
  }
  if (nudge_next()) return;
  if (left_ != 0) {
    if (const auto why = go(left_)) ask_again(*why);
    return;
  }
  if (std::holds_alternative<AdjustStep>(step().what)) {
    adjusted_ += way_;
    all_ = false;
    phase_ = Phase::kAsking;
    return;
  }
  if (const auto* motion = std::get_if<MotionStep>(&step().what)) {
    went_ = true;
    if (!motion->asks) {
      end_step(StepResult::State::kDone, "went " + way_text(way_, robot_.joints[motion->joint]),
               way_);
      return next(now);
    }
    if (!comes_back_) {
      phase_ = Phase::kAsking;
      return;
    }
    const bool grew = said_ == "plus";
    const bool sent_plus = way_ > 0;
    const double sense = grew == sent_plus ? 1 : -1;
    const std::string words = sense > 0 ? "turns as the model counts" : "turns against the model";
    if (said_ == "plus" || said_ == "minus") {
      end_step(StepResult::State::kDone, words, sense);
    } else {
      end_step(StepResult::State::kDone,
               said_ == "nothing" ? "did not move" : "another joint moved", 0);
    }
    return next(now);
  }
  if (std::holds_alternative<PlaceStep>(step().what)) {
    end_step(StepResult::State::kDone, "declared");
  } else {
    end_step(StepResult::State::kDone, "done in " + seconds_text(to_seconds(now - since_)));
  }
  next(now);
}

}  // namespace sinew::program

#include "sinew/program/procedures/procedure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/control/local_machine.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/procedures/procedures.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

using namespace std::chrono_literals;
using ProcedurePhase = Procedure::Phase;
using State = StepResult::State;

/// Does what it is told in the time it is told; knows where it is or not, and turns its joints the
/// right way or not.
class FakeDriver final : public Driver {
 public:
  explicit FakeDriver(std::size_t joints) { positions_.resize(joints); }

  void open(Instant) override {
    closed_ = false;
    tell(DriverEvent::Kind::kReady);
  }
  void close(Instant) override { closed_ = true; }
  DriverState state() const override {
    if (closed_) return DriverState::kClosed;
    if (fault_) return DriverState::kFault;
    return until_ ? DriverState::kMoving : DriverState::kReady;
  }
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override {
    return {positions_.data(), positions_.size()};
  }
  DriverHealth health() const override { return {}; }
  bool wants_move(Instant) const override { return !until_; }
  Expected<void> move(const JointMove& move, Instant now) override {
    ++motions;
    for (std::size_t j = 0; j < positions_.size(); ++j) {
      positions_[j] = {PositionQuality::kCommanded, move.q[j], move.q[j], move.q[j]};
    }
    return begin(move.duration, now);
  }
  Expected<void> nudge(std::size_t joint, double way, Duration duration, Instant now) override {
    ++motions;
    nudges.emplace_back(joint, way);
    return begin(duration, now);
  }
  Expected<void> home(Instant now, std::uint8_t joints) override {
    ++motions;
    homes_ = true;
    homed.push_back(joints);
    return begin(2s, now);
  }
  std::optional<std::size_t> homing_joint() const override {
    return homes_ && until_ ? std::optional(searched) : std::nullopt;
  }
  Expected<void> tool(const ToolAction&, Instant now) override { return begin(1s, now); }
  void stop(Instant) override {
    until_.reset();
    homes_ = false;
    tell(DriverEvent::Kind::kStopped);
  }
  void declare_positions(std::span<const JointPosition> positions) override {
    positions_ = FixedVector<JointPosition, kMaxJoints>(positions);
  }
  void poll(Instant now) override {
    if (!until_ || now < *until_) return;
    until_.reset();
    if (failure) {
      fault_ = failure;
      return tell(DriverEvent::Kind::kFailed, *failure);
    }
    for (JointPosition& joint : positions_) {
      if (homes_) joint = {PositionQuality::kCommanded, homed_at, homed_at, homed_at};
    }
    homes_ = false;
    tell(DriverEvent::Kind::kDone);
  }
  std::optional<Instant> next_deadline() const override { return until_; }
  std::optional<DriverEvent> take_event() override { return events_.take_front(); }

  std::optional<Error> failure;
  double homed_at = 0;  ///< rad, where a search leaves each joint
  int motions = 0;
  std::vector<std::pair<std::size_t, double>> nudges;
  std::vector<std::uint8_t> homed;  ///< joints of each search
  std::size_t searched = 0;
  /// The zero of the joint that it searches for is found.
  void find_zero() {
    positions_[searched++] = {PositionQuality::kCommanded, homed_at, homed_at, homed_at};
  }

 private:
  Expected<void> begin(Duration duration, Instant now) {
    until_ = now + duration;
    return {};
  }
  void tell(DriverEvent::Kind kind, const Error& error = {}) { events_.push_back({kind, error}); }

  bool closed_ = true;
  bool homes_ = false;
  std::optional<Instant> until_;
  std::optional<Error> fault_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  FixedVector<DriverEvent, 64> events_;
};

struct Bench {
  Bench(const char* id, ProcedurePlan plan)
      : robot(test::robot(id)),
        driver(robot.joints.size()),
        controller(robot, driver, {}, {}),
        machine(controller, 7),
        procedure(std::move(plan), machine) {}
  explicit Bench(const char* id) : Bench(id, recovery_procedure(test::robot(id), {})) {}

  void cycle() {
    now += 10ms;
    driver.poll(now);
    machine.take(controller.step({.commands = machine.commands(now)}, now));
    procedure.poll(now);
  }
  void begin() {
    procedure.start(now);
    ASSERT_TRUE(until([&] { return procedure.phase() != ProcedurePhase::kOpening; }));
  }
  template <class Done>
  bool until(Done done, Duration longest = 300s) {
    for (const Instant end = now + longest; now < end;) {
      if (done()) return true;
      cycle();
    }
    return done();
  }
  /// Waits for the question, answers, and lets it happen. @return why not, as a sentence
  std::string say(std::string_view text) {
    EXPECT_TRUE(until(
        [&] { return procedure.phase() == ProcedurePhase::kAsking || procedure.finished(); }));
    const auto taken = procedure.answer(text, now);
    if (!taken) return taken.error();
    until([&] { return procedure.phase() != ProcedurePhase::kWorking; });
    return {};
  }

  RobotModel robot;
  FakeDriver driver;
  control::Controller controller;
  control::LocalMachine machine;
  Procedure procedure;
  Instant now{};
};

ProcedurePlan all_kinds() {
  ProcedurePlan plan{"test", "test", {}};
  plan.steps.push_back({.id = "tell", .text = "look", .what = TellStep{}});
  plan.steps.push_back({.id = "check", .text = "it looks", .what = CheckStep{[](const Procedure&) {
                                                             return Verdict{true, "3 of 3", 3.0};
                                                           }}});
  plan.steps.push_back(
      {.id = "way", .text = "which way", .what = MotionStep{2, from_deg(3), "up", "down"}});
  plan.steps.push_back({.id = "choice", .text = "which", .what = ChoiceStep{{"a", "b"}}});
  plan.steps.push_back({.id = "number",
                        .text = "how far",
                        .what = NumberStep{Measure::kLength, from_mm(1), from_mm(5)},
                        .hint = {},
                        .optional = true});
  plan.steps.push_back({.id = "search", .text = "zeros", .what = SearchStep{}});
  plan.steps.push_back({.id = "place",
                        .text = "where",
                        .what = PlaceStep{{{"home", home_joints(test::robot("bigrobotarm"))}}}});
  return plan;
}

const std::vector<const char*> kAnswers{"yes", "go", "up", "b", "2.5mm", "go", "home"};

TEST(Procedure, goes_through_every_kind_of_step_and_keeps_what_was_found) {
  Bench bench("bigrobotarm", all_kinds());
  bench.begin();
  for (const char* answer : kAnswers) EXPECT_EQ(bench.say(answer), "") << answer;
  ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone);
  for (const StepResult& result : bench.procedure.results()) EXPECT_EQ(result.state, State::kDone);
  EXPECT_EQ(bench.procedure.result("check")->number, 3);
  EXPECT_EQ(bench.procedure.result("way")->number, 1);
  EXPECT_EQ(bench.procedure.result("choice")->answer, "b");
  EXPECT_DOUBLE_EQ(*bench.procedure.result("number")->number, from_mm(2.5));
  EXPECT_TRUE(bench.machine.reference());
  // 3 deg in steps of 2 at most, and back.
  ASSERT_EQ(bench.driver.nudges.size(), 4U);
  double sum = 0;
  for (const auto& [joint, way] : bench.driver.nudges) {
    EXPECT_EQ(joint, 2U);
    EXPECT_LE(std::abs(way), from_deg(2) + 1e-12);
    sum += way;
  }
  EXPECT_NEAR(sum, 0, 1e-12);
}

TEST(Procedure, cancelled_at_any_step_nothing_moves_behind_it) {
  for (std::size_t stop_at = 0; stop_at <= kAnswers.size(); ++stop_at) {
    for (const Duration later : {Duration{0}, Duration{50ms}, Duration{700ms}}) {
      Bench bench("bigrobotarm", all_kinds());
      bench.begin();
      for (std::size_t k = 0; k < stop_at && k < kAnswers.size(); ++k) {
        bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; }, 60s);
        if (k + 1 < stop_at) {
          ASSERT_EQ(bench.say(kAnswers[k]), "");
        } else {
          ASSERT_TRUE(bench.procedure.answer(kAnswers[k], bench.now));
        }
      }
      bench.until([] { return false; }, later);
      const bool over = bench.procedure.finished();
      bench.procedure.cancel(bench.now);
      ASSERT_TRUE(bench.until([&] { return bench.procedure.finished(); }, 2s));
      EXPECT_EQ(bench.procedure.phase(), over ? ProcedurePhase::kDone : ProcedurePhase::kCancelled);
      bench.until([] { return false; }, 100ms);
      const int motions = bench.driver.motions;
      bench.until([] { return false; }, 20s);
      EXPECT_EQ(bench.driver.motions, motions) << stop_at;
      EXPECT_FALSE(control::may_move(bench.controller.state()));
      EXPECT_FALSE(bench.procedure.answer("go", bench.now));
    }
  }
}

TEST(Procedure, a_wrong_answer_is_refused_with_a_sentence_and_nothing_moves) {
  Bench bench("bigrobotarm", all_kinds());
  bench.begin();
  const std::vector<std::pair<const char*, std::vector<const char*>>> wrong{
      {"yes", {"no", "", "42", "\x1b[2J"}},
      {"go", {"later", "up"}},
      {"down", {"left", "", "go"}},
      {"a", {"c", "", "A"}},
      {"skip", {"2.5", "six", "9mm", "-2mm", "nan mm", "3deg"}},
      {"go", {"now"}},
      {"0deg,0deg,0deg,0deg,0deg",
       {"there", "0deg", "0deg,0deg,0deg,0deg,0deg,0deg", "0mm,0deg,0deg,0deg,0deg",
        "home moved:", "home moved:  "}},
  };
  for (const auto& [right, others] : wrong) {
    for (const char* other : others) {
      const std::size_t place = bench.procedure.place();
      const int motions = bench.driver.motions;
      EXPECT_NE(bench.say(other), "") << other;
      EXPECT_EQ(bench.procedure.place(), place);
      EXPECT_EQ(bench.driver.motions, motions);
      EXPECT_EQ(bench.procedure.phase(), ProcedurePhase::kAsking);
    }
    EXPECT_EQ(bench.say(right), "") << right;
  }
  EXPECT_EQ(bench.procedure.phase(), ProcedurePhase::kDone);
  EXPECT_EQ(bench.procedure.result("way")->number, -1);
  EXPECT_EQ(bench.procedure.result("number")->state, State::kSkipped);
}

TEST(Procedure, a_place_outside_the_limits_is_refused_by_the_machine_and_asked_again) {
  Bench bench("bigrobotarm");
  bench.begin();
  for (int j = 0; j < 5; ++j) EXPECT_EQ(bench.say("done"), "");
  EXPECT_EQ(bench.say("0deg,300deg,0deg,0deg,0deg"), "");
  EXPECT_EQ(bench.procedure.phase(), ProcedurePhase::kAsking);
  EXPECT_NE(bench.procedure.trouble().find("300 deg"), std::string::npos)
      << bench.procedure.trouble();
  EXPECT_FALSE(bench.machine.reference());
  EXPECT_EQ(bench.say("home"), "");
  EXPECT_EQ(bench.procedure.phase(), ProcedurePhase::kDone);
  EXPECT_TRUE(bench.machine.reference());
}

TEST(Procedure, recovery_moves_each_joint_by_hand_as_often_as_it_takes) {
  Bench bench("hexapod");
  bench.begin();
  EXPECT_EQ(bench.say("-1.2mm"), "");
  EXPECT_EQ(bench.say("0.2mm"), "");
  EXPECT_NE(bench.say("200mm"), "");
  EXPECT_NE(bench.say("0mm"), "");
  for (int leg = 0; leg < 6; ++leg) EXPECT_EQ(bench.say("done"), "");
  EXPECT_EQ(bench.procedure.result("adjust.leg1")->words, "went -1 mm in all");
  ASSERT_EQ(bench.driver.nudges.size(), 4U);
  for (const auto& [leg, way] : bench.driver.nudges) EXPECT_EQ(leg, 0U);
  EXPECT_EQ(bench.say("lowered"), "");
  ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone);
  EXPECT_EQ((*bench.machine.reference())[5], bench.robot.joints[5].lower);
}

TEST(Procedure, recovery_moves_all_legs_together_in_turns_of_one_small_step) {
  Bench bench("hexapod");
  bench.begin();
  EXPECT_NE(bench.say("all"), "");
  EXPECT_NE(bench.say("all 200mm"), "");
  EXPECT_EQ(bench.say("all -1.2mm"), "");
  for (int k = 0; k < 18 && bench.procedure.phase() == ProcedurePhase::kWorking; ++k) {
    bench.until([&] { return bench.procedure.phase() != ProcedurePhase::kWorking; });
  }
  ASSERT_EQ(bench.driver.nudges.size(), 18U) << bench.procedure.trouble();
  for (std::size_t k = 0; k < 18; ++k) {
    EXPECT_EQ(bench.driver.nudges[k].first, k % 6);
    EXPECT_NEAR(bench.driver.nudges[k].second, k < 12 ? -0.5e-3 : -0.2e-3, 1e-12);
  }
  EXPECT_EQ(bench.say("0.1mm"), "") << "of leg1 alone again";
  EXPECT_EQ(bench.driver.nudges.size(), 19U);
}

TEST(Procedure, a_place_is_confirmed_as_it_is_shown_and_its_intervals_stay) {
  Bench bench("hexapod");
  bench.begin();
  for (int leg = 0; leg < 6; ++leg) EXPECT_EQ(bench.say("done"), "");
  EXPECT_NE(bench.say("shown"), "") << "nothing is shown where all is lost";
  FixedVector<JointPosition, kMaxJoints> within;
  for (const Joint& joint : bench.robot.joints) {
    within.push_back(
        {PositionQuality::kUncertain, joint.home, joint.home - 20e-6, joint.home + 32e-6});
  }
  bench.driver.declare_positions({within.data(), within.size()});
  EXPECT_EQ(bench.say("shown"), "");
  ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone) << bench.procedure.trouble();
  const JointPosition& leg = bench.driver.positions()[3];
  EXPECT_EQ(leg.quality, PositionQuality::kCommanded);
  EXPECT_NEAR(leg.q, bench.robot.joints[3].home + 6e-6, 1e-12);
  EXPECT_NEAR(leg.lower, bench.robot.joints[3].home - 20e-6, 1e-12);
  EXPECT_NEAR(leg.upper, bench.robot.joints[3].home + 32e-6, 1e-12);
}

TEST(Procedure, servos_recover_by_a_slow_first_move) {
  Bench bench("learm");
  bench.begin();
  EXPECT_EQ(bench.say("yes"), "");
  EXPECT_EQ(bench.say("go"), "");
  ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone) << bench.procedure.trouble();
  EXPECT_EQ(*bench.machine.reference(), home_joints(bench.robot));
}

TEST(Procedure, goes_one_step_back_past_what_looks_by_itself) {
  Bench bench("bigrobotarm", all_kinds());
  bench.begin();
  EXPECT_FALSE(bench.procedure.back(bench.now));
  bench.say("yes");
  ASSERT_EQ(bench.procedure.step().id, "way");
  ASSERT_TRUE(bench.procedure.back(bench.now));
  EXPECT_EQ(bench.procedure.step().id, "tell");
  EXPECT_EQ(bench.procedure.result("check")->state, State::kOpen);
  bench.say("yes");
  bench.say("go");
  bench.say("up");
  ASSERT_EQ(bench.procedure.step().id, "choice");
  ASSERT_TRUE(bench.procedure.back(bench.now));
  EXPECT_EQ(bench.procedure.step().id, "way");
  EXPECT_TRUE(bench.procedure.answer("go", bench.now));
  EXPECT_FALSE(bench.procedure.back(bench.now));
}

TEST(Procedure, a_fault_of_the_machine_fails_it_with_the_reason) {
  Bench bench("bigrobotarm", all_kinds());
  bench.begin();
  bench.say("yes");
  bench.driver.failure = Error{ErrorCode::kStalled, 2};
  EXPECT_EQ(bench.say("go"), "");
  ASSERT_TRUE(bench.until([&] { return bench.procedure.finished(); }, 20s));
  EXPECT_EQ(bench.procedure.phase(), ProcedurePhase::kFailed);
  EXPECT_NE(bench.procedure.trouble().find("elbow"), std::string::npos)
      << bench.procedure.trouble();
}

/// What a client that is none of the bench's gives.
void stranger_gives(Bench& bench, const control::CommandWhat& what) {
  bench.now += 10ms;
  const control::Command command{9999, control::LeaseToken{.client = 99}, what};
  bench.machine.take(bench.controller.step({.commands = {&command, 1}}, bench.now));
  bench.procedure.poll(bench.now);
}

void expect_left_and_ready(Bench& bench) {
  stranger_gives(bench, control::TakeLease{.take_over = true});
  ASSERT_TRUE(bench.until(
      [&] {
        return bench.procedure.left() && bench.procedure.phase() == ProcedurePhase::kAsking &&
               bench.machine.state() == control::MachineState::kReady;
      },
      2s));
}

TEST(Procedure, a_search_that_lost_its_client_goes_on_with_the_joints_that_it_has_not_found) {
  ProcedurePlan plan{"home", "home", {}};
  plan.steps.push_back({.id = "search", .text = "zeros", .what = SearchStep{}});
  plan.steps.push_back({.id = "again", .text = "once more", .what = SearchStep{}});
  Bench bench("bigrobotarm", std::move(plan));
  bench.begin();
  const auto finds = [&](int joints) {
    for (int k = 0; k < joints; ++k) {
      bench.cycle();
      bench.driver.find_zero();
    }
    bench.until([] { return false; }, 50ms);
  };
  ASSERT_TRUE(bench.procedure.answer("go", bench.now));
  bench.until([] { return false; }, 50ms);
  finds(2);
  expect_left_and_ready(bench);
  bench.procedure.rejoin(true);
  ASSERT_TRUE(bench.until([&] { return !bench.procedure.left(); }, 2s));
  EXPECT_EQ(bench.say("go"), "");
  ASSERT_EQ(bench.driver.homed, (std::vector<std::uint8_t>{kAllJoints, 0b11111100}));
  EXPECT_EQ(bench.procedure.step().id, "again");
  EXPECT_EQ(bench.say("go"), "");
  EXPECT_EQ(bench.driver.homed.back(), kAllJoints) << "this one looks for all of them";
}

TEST(Procedure, a_question_that_moves_nothing_is_answered_without_control) {
  Bench bench("bigrobotarm", all_kinds());
  bench.begin();
  expect_left_and_ready(bench);
  EXPECT_EQ(bench.procedure.step().id, "tell");
  EXPECT_TRUE(bench.procedure.answer("yes", bench.now));
  ASSERT_TRUE(bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; }, 2s));
  EXPECT_EQ(bench.procedure.step().id, "way");
  EXPECT_EQ(bench.procedure.answer("go", bench.now).error(),
            "control was lost; take it, then answer");
  EXPECT_EQ(bench.driver.motions, 0);
}

TEST(Procedure, another_clients_stop_and_a_take_over_leave_the_question) {
  Bench bench("bigrobotarm", all_kinds());
  bench.begin();
  bench.say("yes");
  ASSERT_TRUE(bench.procedure.answer("go", bench.now));
  bench.until([] { return false; }, 100ms);
  stranger_gives(bench, control::Stop{});
  ASSERT_TRUE(bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; }, 2s));
  EXPECT_EQ(bench.procedure.trouble(), "stopped on the way");
  ASSERT_TRUE(bench.procedure.answer("go", bench.now));
  bench.until([] { return false; }, 100ms);
  stranger_gives(bench, control::TakeLease{.take_over = true});
  ASSERT_TRUE(bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; }, 2s));
  EXPECT_TRUE(bench.procedure.left());
  EXPECT_EQ(bench.procedure.trouble(), "control was lost on the way");
  EXPECT_EQ(bench.procedure.step().id, "way");
  ASSERT_TRUE(bench.until([&] { return bench.machine.state() == control::MachineState::kReady; }));
  EXPECT_EQ(bench.procedure.answer("go", bench.now).error(),
            "control was lost; take it, then answer");
  bench.procedure.rejoin(true);
  ASSERT_TRUE(bench.until([&] { return !bench.procedure.left(); }, 2s));
  EXPECT_TRUE(bench.procedure.answer("go", bench.now));
}

TEST(Procedure, what_was_answered_before_is_not_asked_again_and_what_moves_is_done_again) {
  Bench bench("bigrobotarm", all_kinds());
  bench.procedure.keep("tell", {State::kDone, "yes", "", {}});
  bench.procedure.keep("choice", {State::kDone, "a", "", 0.0});
  bench.procedure.keep("search", {State::kDone, "", "", {}});
  bench.procedure.keep("number", {State::kFailed, "", "", {}});
  bench.begin();
  ASSERT_TRUE(bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; }, 2s));
  EXPECT_EQ(bench.procedure.step().id, "way");
  for (const char* answer : {"go", "up", "3mm", "go", "home"}) EXPECT_EQ(bench.say(answer), "");
  EXPECT_EQ(bench.procedure.phase(), ProcedurePhase::kDone);
}

TEST(Procedure, robots_without_end_stops_move_to_their_home_pose_where_their_position_is_known) {
  for (const char* id : {"learm", "hexapod", "maxarm", "bigrobotarm"}) {
    SCOPED_TRACE(id);
    Bench bench(id, homing_procedure(test::robot(id), {}));
    JointVector q = home_joints(bench.robot);
    q[0] += bench.robot.joints[0].kind == JointKind::kPrismatic ? 0.01 : 0.1;
    FixedVector<JointPosition, kMaxJoints> known;
    for (const double one : q) known.push_back({PositionQuality::kCommanded, one, one, one});
    bench.driver.declare_positions({known.data(), known.size()});
    bench.begin();
    EXPECT_EQ(bench.say("yes"), "");
    EXPECT_EQ(bench.say("go"), "");
    ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone) << bench.procedure.trouble();
    EXPECT_EQ(*bench.machine.reference(), home_joints(bench.robot));
    EXPECT_GT(bench.driver.motions, 0);

    Bench there(id, homing_procedure(test::robot(id), {}));
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double home = there.robot.joints[j].home;
      known[j] = {PositionQuality::kCommanded, home, home, home};
    }
    there.driver.declare_positions({known.data(), known.size()});
    there.begin();
    EXPECT_EQ(there.say("yes"), "");
    EXPECT_EQ(there.say("go"), "");
    EXPECT_EQ(there.procedure.phase(), ProcedurePhase::kDone) << there.procedure.trouble();
    EXPECT_EQ(there.driver.motions, 0);

    // A simulated machine is assumed at its start until something moves it.
    Bench assumed(id, homing_procedure(test::robot(id), {}));
    assumed.procedure.assume(q);
    assumed.begin();
    EXPECT_EQ(assumed.say("yes"), "");
    EXPECT_EQ(assumed.say("go"), "");
    EXPECT_EQ(assumed.procedure.phase(), ProcedurePhase::kDone) << assumed.procedure.trouble();
    EXPECT_EQ(*assumed.machine.reference(), home_joints(assumed.robot));

    Bench lost(id, homing_procedure(test::robot(id), {}));
    lost.begin();
    EXPECT_EQ(lost.say("yes"), "");
    EXPECT_EQ(lost.say("go"), "");
    EXPECT_EQ(lost.procedure.phase(), ProcedurePhase::kAsking);
    EXPECT_NE(lost.procedure.trouble().find("recover"), std::string::npos);
    EXPECT_EQ(lost.driver.motions, 0);
  }
}

TEST(Procedure, homing_of_machines_with_end_stops_searches_them_twice) {
  Bench bench("robot-arm-2", homing_procedure(test::robot("robot-arm-2"), {}));
  bench.driver.homed_at = 0.05;
  bench.begin();
  EXPECT_EQ(bench.say("yes"), "");
  ASSERT_TRUE(bench.procedure.answer("go", bench.now));
  bench.until([] { return false; }, 500ms);
  EXPECT_NE(bench.procedure.progress(bench.now).find("zero of base (1 of 6)"), std::string::npos)
      << bench.procedure.progress(bench.now);
  bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; });
  EXPECT_EQ(bench.say("go"), "");
  EXPECT_NE(bench.procedure.result("seen")->words.find("is not measured"), std::string::npos);
  // From where the search left it to its home, as a program's row does.
  ASSERT_FALSE(bench.procedure.finished());
  ASSERT_EQ(bench.procedure.step().id, "home");
  EXPECT_EQ(bench.say("go"), "");
  ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone) << bench.procedure.trouble();
  EXPECT_EQ(*bench.machine.reference(), home_joints(bench.robot));
}

TEST(Procedure,
     how_far_two_searches_lie_apart_is_told_in_steps_and_too_far_is_not_as_it_should_be) {
  std::string steps = "0.500";
  const DeviceFact fact = [&](std::string_view what,
                              std::size_t joint) -> std::optional<std::string> {
    if (joint != 1) return std::nullopt;
    if (what == "zero_shift_steps") return steps;
    return what == "zero_shift_deg" ? std::optional<std::string>("0.003") : std::nullopt;
  };
  const auto seen = [&] {
    Bench bench("robot-arm-2", homing_procedure(test::robot("robot-arm-2"), {}, fact));
    bench.begin();
    for (const char* answer : {"yes", "go", "go"}) EXPECT_EQ(bench.say(answer), "");
    bench.until([&] { return bench.procedure.phase() == ProcedurePhase::kAsking; });
    const bool stands = !bench.procedure.finished() && bench.procedure.step().id == "seen";
    return stands ? "! " + bench.procedure.trouble() : bench.procedure.result("seen")->words;
  };
  const std::string fine = seen();
  EXPECT_EQ(fine.find("!"), std::string::npos) << fine;
  EXPECT_NE(fine.find("apart by steps: shoulder 0.500 (0.003 deg)"), std::string::npos) << fine;
  steps = "-32.500";
  const std::string far = seen();
  EXPECT_TRUE(far.starts_with("! ")) << far;
  EXPECT_NE(far.find("More than 32 steps: shoulder"), std::string::npos) << far;
}

TEST(Commissioning, a_board_that_turns_against_the_model_is_not_as_it_should_be) {
  Bench bench("robot-arm-2", *commissioning_procedure(test::robot("robot-arm-2"), {}, {}));
  bench.begin();
  const auto reach = [&](const std::string& id) {
    return bench.until([&] {
      if (bench.procedure.phase() != ProcedurePhase::kAsking || bench.procedure.step().id == id) {
        return bench.procedure.finished() || bench.procedure.phase() == ProcedurePhase::kAsking;
      }
      const auto& what = bench.procedure.step().what;
      const bool moved = bench.procedure.choices()[0] == "plus";
      const bool last = bench.procedure.step().id == "direction.flange_roll";
      const char* go = std::holds_alternative<TellStep>(what) ? "yes" : "go";
      EXPECT_TRUE(bench.procedure.answer(moved ? (last ? "minus" : "plus") : go, bench.now));
      return false;
    });
  };
  ASSERT_TRUE(reach("senses"));
  ASSERT_EQ(bench.procedure.step().id, "senses") << bench.procedure.trouble();
  EXPECT_NE(bench.procedure.trouble().find("against the model: flange_roll."), std::string::npos);
  EXPECT_EQ(bench.say("skip"), "");
  ASSERT_EQ(bench.procedure.phase(), ProcedurePhase::kDone);
  EXPECT_EQ(bench.procedure.result("senses")->state, State::kFailed);
  EXPECT_TRUE(found_settings(bench.procedure).empty());
}

TEST(Commissioning, every_robot_has_a_list_whose_steps_have_names_of_their_own) {
  for (const char* id : {"learm", "hexapod", "maxarm", "bigrobotarm", "robot-arm-2"}) {
    const auto plan = commissioning_procedure(test::robot(id), {}, {});
    ASSERT_TRUE(plan) << id;
    std::vector<std::string> names;
    for (const ProcedureStep& step : plan->steps) {
      EXPECT_FALSE(step.text.empty());
      names.push_back(step.id);
    }
    std::ranges::sort(names);
    EXPECT_EQ(std::ranges::adjacent_find(names), names.end()) << id;
  }
  EXPECT_FALSE(commissioning_procedure(test::robot("puma560"), {}, {}));
}

TEST(Commissioning, a_servo_number_that_is_another_ones_is_refused_and_two_may_be_swapped) {
  Bench bench("learm", *commissioning_procedure(test::robot("learm"), {}, {}));
  const auto& device = bench.robot.device.settings.get<LscDevice>();
  const auto id = [&](std::size_t j) { return std::to_string(device.servos[j].id); };
  bench.begin();
  for (const char* answer : {"yes", "yes", "go", "go", "left", "go", "other", "go", "other", "go",
                             "forward", "go", "left"}) {
    ASSERT_EQ(bench.say(answer), "") << answer << " at " << bench.procedure.step().id;
  }
  ASSERT_EQ(bench.procedure.step().id, "id.shoulder");
  EXPECT_EQ(bench.say(id(0)), "'" + id(0) + "': is base's");
  EXPECT_EQ(bench.say(std::to_string(device.gripper.id)),
            "'" + std::to_string(device.gripper.id) + "': is the gripper's");
  // The elbow's is free: that one has another number too.
  EXPECT_EQ(bench.say(id(2)), "");
  ASSERT_EQ(bench.procedure.step().id, "id.elbow");
  EXPECT_EQ(bench.say(id(2)), "'" + id(2) + "': is shoulder's");
  EXPECT_EQ(bench.say(id(1)), "");
  const FoundSettings found = found_settings(bench.procedure);
  RobotModel arm = test::robot("learm");
  ASSERT_TRUE(use_settings(arm, found));
  EXPECT_EQ(arm.device.settings.get<LscDevice>().servos[1].id, device.servos[2].id);
}

TEST(Commissioning, settings_that_give_two_joints_one_servo_are_refused) {
  const RobotModel arm = test::robot("learm");
  const auto& device = arm.device.settings.get<LscDevice>();
  for (const int taken : {static_cast<int>(device.servos[1].id), int{device.gripper.id}}) {
    RobotModel robot = arm;
    const auto used = use_settings(robot, {{"joint.elbow.servo_id", std::to_string(taken)}});
    ASSERT_FALSE(used) << taken;
    EXPECT_NE(used.error().find("servo " + std::to_string(taken) + " would be elbow's"),
              std::string::npos)
        << used.error();
    EXPECT_EQ(robot.device.settings.get<LscDevice>().servos[2].id, device.servos[2].id);
  }
}

TEST(Commissioning, settings_that_were_found_change_the_device_and_nothing_else_is_one) {
  RobotModel legs = test::robot("hexapod");
  const double units = legs.device.settings.get<IcpDevice>().units_per_m;
  ASSERT_TRUE(use_settings(
      legs, {{"joint.leg2.turn", "other"}, {"units_per_down", "2"}, {"way_factor", "0.5"}}));
  const auto& icp = legs.device.settings.get<IcpDevice>();
  EXPECT_TRUE(icp.legs[1].invert);
  EXPECT_FALSE(icp.legs[0].invert);
  EXPECT_EQ(icp.units_per_down, 2);
  EXPECT_DOUBLE_EQ(icp.units_per_m, 2 * units);
  RobotModel arm = test::robot("learm");
  ASSERT_TRUE(use_settings(arm, {{"joint.roll.turn", "other"},
                                 {"joint.base.trim_rad", "0.1"},
                                 {"joint.elbow.servo_id", "9"}}));
  const auto& lsc = arm.device.settings.get<LscDevice>();
  EXPECT_LT(lsc.servos[4].units_per_rad, 0);
  EXPECT_EQ(lsc.servos[2].id, 9);
  EXPECT_DOUBLE_EQ(lsc.servos[0].trim, 0.1 * lsc.servos[0].units_per_rad);
  // The classic kit opens at 1500 us and closes at 2500, the other one at 500 and 1500.
  RobotModel kit = test::robot("learm");
  const auto jaws = [&]() -> LscGripper& { return kit.device.settings.get<LscDevice>().gripper; };
  EXPECT_EQ(jaws_tried(kit), std::get<SerialGeometry>(kit.geometry).gripper->width_max);
  ASSERT_TRUE(use_settings(kit, {{"jaws_turn", "other"}}));
  EXPECT_EQ(jaws().open, 500);
  EXPECT_EQ(jaws().closed, 1500);
  EXPECT_EQ(jaws_tried(kit), 0);
  ASSERT_TRUE(use_settings(kit, {{"jaws_turn", "other"}}));
  EXPECT_EQ(jaws().open, 1500);
  EXPECT_EQ(jaws().closed, 2500);
  kit.device.settings.get<LscDevice>().profile = LscProfile::kBus;
  jaws().open = 200, jaws().closed = 700;
  ASSERT_TRUE(use_settings(kit, {{"jaws_turn", "other"}}));
  EXPECT_EQ(jaws().open, 700);
  EXPECT_EQ(jaws().closed, 200);
  const std::vector<std::pair<std::string, std::string>> wrong{{"joint.leg7.turn", "other"},
                                                               {"jaws_turn", "other"},
                                                               {"joint.leg1.turn", "yes"},
                                                               {"units_per_down", "3"},
                                                               {"way_factor", "0"},
                                                               {"way_factor", "1e9"},
                                                               {"way_factor", "nan"},
                                                               {"joint.leg1.trim_rad", "0"},
                                                               {"joint.", "x"},
                                                               {"", ""}};
  for (const auto& [name, value] : wrong) {
    RobotModel robot = test::robot("hexapod");
    const auto used = use_settings(robot, {{"joint.leg3.turn", "other"}, {name, value}});
    ASSERT_FALSE(used) << name;
    EXPECT_FALSE(robot.device.settings.get<IcpDevice>().legs[2].invert);
  }
}

}  // namespace
}  // namespace sinew::program

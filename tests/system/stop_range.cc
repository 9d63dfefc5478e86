#include "system/stop_range.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sinew/control/machine_identity.h"
#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/runtime/homing_time.h"
#include "support/allocation_guard.h"
#include "system/some_motion.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using control::MachineState;

bool has_legs(const RobotModel& robot) {
  return robot.joints[0].kind == JointKind::kPrismatic;
}

control::ControllerSettings settings_of(const RobotModel& robot, StopRange::Journal journal) {
  control::ControllerSettings settings;
  settings.opening_limit = robot.device.settings->opening().limit;
  if (journal == StopRange::Journal::kKept) settings.journal = control::journal_settings(robot);
  return settings;
}

}  // namespace

StopRange::Recorder::Recorder() : files(disk, "positions"), pump(files) {
  EXPECT_TRUE(files.lock());
  EXPECT_TRUE(files.load());
  files.continue_after({});
}

StopRange::StopRange(const RobotModel& robot, const std::optional<std::string>& profile,
                     std::uint64_t seed, Journal journal)
    : robot_(robot),
      random_(seed),
      cell_(robot, {.profile = profile, .seed = seed}, 1s),
      recorder_(journal == Journal::kKept ? std::make_unique<Recorder>() : nullptr),
      loop_(robot, cell_.driver(), settings_of(robot, journal), {},
            recorder_ ? &recorder_->pump : nullptr),
      ear_(stop_ear(robot.device)),
      next_cycle_(cell_.now()) {
  if (recorder_) {
    loop_.look = [this](const control::Outputs& outputs, Instant) {
      records_.insert(records_.end(), outputs.records.begin(), outputs.records.end());
      events_.insert(events_.end(), outputs.events.begin(), outputs.events.end());
    };
  }
  cell_.line().tap = [this](std::span<const std::uint8_t> bytes, Instant begins, Instant ends) {
    wire_free_ = ends;
    if (looking_) ends_.push_back(ends);
    if (!ear_) return;
    const auto frame = ear_->hear(bytes, begins);
    if (!frame || !armed_) return;
    if (!frame->stops) {
      ++moved_on_;
    } else if (!first_stop_) {
      first_stop_ = frame->begins;
    }
  };
}

void StopRange::look() {
  if (!looking_) return;
  Look look{cell_.now(), {}};
  const sim::Truth truth = cell_.machine().truth();
  for (const sim::JointTruth& joint : truth.joints) look.q.push_back(joint.q);
  looks_.push_back(look);
}

void StopRange::run_to(Instant end) {
  EXPECT_TRUE(cell_.run_to(end, 1ms, [this] {
    look();
    return false;
  }));
}

void StopRange::cycle() {
  run_to(next_cycle_);
  next_cycle_ = std::max(next_cycle_ + kCycle, cell_.now());
  if (recorder_ && recorder_->pump.work()) recorder_->pump.publish();
  const AllocationCounter counter;
  loop_.step(cell_.now());
  allocations_ += counter.count();
  run_to(cell_.now());  // what it said leaves
  while (loop_.machine().take_event()) continue;
}

void StopRange::cycles_until(Instant end) {
  while (next_cycle_ <= end) cycle();
  run_to(end);
}

bool StopRange::wait(const std::function<bool()>& condition, Duration longest) {
  const Instant end = cell_.now() + longest;
  while (!condition() && cell_.now() < end) cycle();
  return condition();
}

void StopRange::prepare() {
  control::LocalMachine& machine = loop_.machine();
  machine.give(control::TakeLease{});
  const auto ready = [&] {
    return machine.state() == MachineState::kReady && loop_.controller().task() == 0;
  };
  cycle();
  machine.give(control::Enable{});
  ASSERT_TRUE(wait(ready, 60s)) << robot_.id;
  cycle();
  // A limp arm is where it has sunk to.
  const bool servos = robot_.device.settings.is<LscDevice>();
  if (servos) {
    motion_ = first_motion(robot_);
    machine.give(control::Begin{motion_.get(), true});
  } else if (runtime::homing_of(robot_).rest) {
    machine.give(control::Home{});
  }
  cycle();
  ASSERT_TRUE(wait(ready, 600s)) << robot_.id;
}

/// A machine that was not measured, or that a stop has left somewhere in an interval: somebody
/// looks.
void StopRange::declare_truth() {
  control::Declare where;
  where.moved = true;  // an interval of its motor need not hold the play of its gear
  const sim::Truth truth = cell_.machine().truth();
  for (const sim::JointTruth& joint : truth.joints) {
    where.positions.push_back({PositionQuality::kCommanded, joint.q, joint.q, joint.q});
  }
  loop_.machine().give(where);
  cycle();
  ASSERT_TRUE(loop_.machine().reference()) << robot_.id;
}

/// To another place that the planner allows and that this wire can say.
void StopRange::begin_motion() {
  control::LocalMachine& machine = loop_.machine();
  const auto moves = [&] { return cell_.driver().state() == DriverState::kMoving; };
  const double way = has_legs(robot_) ? 3e-5 : 0.5;
  // A servo that sags by a limit may go slowly only.
  const double room = has_legs(robot_) ? 0 : 0.1;
  if (!machine.reference()) declare_truth();
  if (testing::Test::HasFatalFailure()) return;
  for (int tries = 0; tries < 100; ++tries) {
    const JointVector from = machine.reference().value();
    target_ = from;
    for (std::size_t j = 0; j < target_.size(); ++j) {
      const Joint& joint = robot_.joints[j];
      const double about = has_legs(robot_) ? from[j] : joint.home;
      target_[j] =
          std::clamp(about + random_.uniform(-way, way), joint.lower + room, joint.upper - room);
    }
    motion_ = motion_to(robot_, from, target_);
    if (!motion_) continue;
    planned_ = from_seconds(motion_->time_left());
    machine.give(control::Begin{motion_.get()});
    cycle();
    if (wait([&] { return moves() || loop_.controller().task() == 0; }, 5s) && moves()) return;
  }
  FAIL() << robot_.id << " takes no motion";
}

StopShot StopRange::shoot() {
  begin_motion();
  if (testing::Test::HasFatalFailure()) return {};
  // Not before some device has been asked what comes before a move, nor in its last fifth: what
  // has not begun, or is over by itself, needs no stop.
  const Duration begins = std::min<Duration>(100ms, planned_ / 5);
  cycles_until(cell_.now() + begins + from_seconds(to_seconds(planned_) * random_.uniform(0, 0.6)));
  const Instant asked = cell_.now();
  EXPECT_EQ(loop_.controller().state(), MachineState::kMoving) << robot_.id;
  looks_.clear();
  ends_.assign(1, std::max(asked, wire_free_));
  looking_ = true;
  run_to(next_cycle_);
  const Instant taken = std::max(asked, wire_free_);
  EXPECT_LE(wire_free_ - cell_.now(), 60ms) << "more than one frame waits for the wire";
  armed_ = true;
  first_stop_.reset();
  moved_on_ = 0;
  loop_.machine().give(control::Stop{});
  std::optional<Instant> goes_on;
  EXPECT_TRUE(wait(
      [&] {
        goes_on = std::max(goes_on, loop_.controller().driver().goes_on_until());
        return loop_.controller().state() == MachineState::kReady &&
               !cell_.machine().truth().moving;
      },
      30s))
      << robot_.id;
  wait([] { return false; }, 300ms);
  armed_ = looking_ = false;
  StopShot shot;
  if (goes_on) shot.goes_on = *goes_on - asked;
  if (first_stop_) {
    shot.first_byte = *first_stop_ - asked;
    shot.behind_wire = std::max(Duration{}, *first_stop_ - taken);
    const auto before = std::ranges::upper_bound(ends_, *first_stop_);
    shot.behind_last = *first_stop_ - (before == ends_.begin() ? asked : *std::prev(before));
  }
  shot.moved_on = moved_on_;
  shot.standstill = standstill_since(asked);
  for (std::size_t j = 0; j < target_.size(); ++j) {
    shot.short_of_target =
        std::max(shot.short_of_target, std::abs(looks_.back().q[j] - target_[j]));
  }
  return shot;
}

Duration StopRange::standstill_since(Instant asked) const {
  const double near = has_legs(robot_) ? 0.1e-6 : from_deg(0.25);
  const JointVector& rest = looks_.back().q;
  for (std::size_t k = looks_.size(); k-- > 0;) {
    for (std::size_t j = 0; j < rest.size(); ++j) {
      if (std::abs(looks_[k].q[j] - rest[j]) > near) return looks_[k].at - asked;
    }
  }
  return {};
}

}  // namespace sinew::test

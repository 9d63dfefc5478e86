#include "system/system_cell.h"

#include <algorithm>
#include <cmath>

#include "sinew/control/machine_identity.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/icp/icp_driver_leg.h"
#include "sinew/devices/icp/icp_machine.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/model/error_sentence.h"
#include "system/some_motion.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using control::MachineState;

constexpr std::int64_t kEpoch = 1'800'000'000'000'000'000;
constexpr Duration kWarmUp = 1s;

control::ControllerSettings settings_of(const RobotModel& robot) {
  control::ControllerSettings settings;
  settings.opening_limit = robot.device.settings->opening().limit;
  settings.journal = control::journal_settings(robot);
  return settings;
}

/// On its way, and not to rest.
bool goes(MachineState state) {
  return state == MachineState::kMoving || state == MachineState::kRecovering;
}

}  // namespace

Station::Host::Host(const RobotModel& robot, Driver& driver, Disk& disk)
    : files(disk, "positions") {
  if (!files.lock()) return;
  const auto bytes = files.load();
  if (!bytes) return;
  recovery = recover(bytes->files(), control::recovery_settings(robot));
  files.continue_after(recovery.end);
  pump = std::make_unique<runtime::JournalPump>(files);
  loop = std::make_unique<runtime::ControlLoop>(
      robot, driver, settings_of(robot),
      control::ControllerStart{recovery.positions, recovery.end, recovery.memory}, pump.get());
  opened = true;
}

Station::Station(const RobotModel& robot, const std::optional<std::string>& profile,
                 std::uint64_t seed, SystemCounts& counts, TraceHash& hash)
    : robot_(robot),
      random_(seed),
      counts_(counts),
      hash_(hash),
      cell_(robot, {.profile = profile, .seed = seed}, kWarmUp) {
  disk_.set_sync_time(1ms, 40ms, seed);
  begin_life();
}

/// How far a motor may stand beside what its wire can say of it; rad or m.
double Station::resolution(std::size_t joint, JournalKind kind) const {
  const auto& settings = robot_.device.settings;
  // A rotor that turns trails its field by up to a full step, 16 microsteps here. Until somebody
  // has looked at its modules nobody knows what they did without power: all that the driver allows
  // for. Who died while he looked left a record that says so.
  if (const auto* legs = settings.as<IcpDevice>()) {
    const bool unseen = browned_out_ || kind == JournalKind::kLook;
    return ((unseen ? IcpLegClaim::kPowerCutUnits : 0) + 17) / legs->units_per_m;
  }
  if (const BigRobotArmDevice* arm = big_robot_arm_of(*settings)) {
    const BigRobotArmJoint& own = arm->joints[joint];
    return 2 * own.steps_per_motor_rev / 200 / std::abs(own.steps_per_rad);
  }
  return from_deg(4);  // servos: their dead band, and what they sag by under way
}

void Station::begin_life() {
  disk_.set_wall(kEpoch + cell_.now().time_since_epoch().count());
  host_ = std::make_unique<Host>(robot_, cell_.driver(), disk_);
  ASSERT_TRUE(host_->opened);
  // What this life takes over is true already now, before anything is asked of the device.
  const sim::Truth truth = cell_.machine().truth();
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    const JointPosition& said = host_->recovery.positions[j];
    if (said.quality == PositionQuality::kLost) continue;
    const double room = resolution(j);
    EXPECT_GE(truth.joints[j].q, said.lower - room) << where();
    EXPECT_LE(truth.joints[j].q, said.upper + room) << where();
  }
  host_->loop->look = [this](const control::Outputs& outputs, Instant) { say(outputs); };
  host_->loop->machine().give(control::TakeLease{});
}

void Station::kill(bool power_too, Duration away, std::uint64_t seed) {
  ++counts_.kills;
  if (power_too) ++counts_.power_losses;
  host_.reset();
  if (power_too) {
    disk_.lose_power(seed);
  } else {
    disk_.kill_process();
  }
  cell_.replace_driver();
  host_returns_ = cell_.now() + away;
}

void Station::slice(Duration time) {
  if (host_returns_ && cell_.now() >= *host_returns_) {
    host_returns_.reset();
    begin_life();
  }
  act();
  if (!misfortunes_) {
    start_anew_where_disk_failed();
    switch_off_and_on();
  }
  const Instant end = cell_.now() + time;
  EXPECT_TRUE(cell_.run_to(end, 2ms, [this] {
    look();
    return false;
  })) << where();
  hash_.add(cell_.line().counts().trace);
  look_at_supply();
}

/// What its makers say that the supply is; nothing where a device knows nothing of it.
std::optional<double> nominal_volts(const RobotModel& robot) {
  if (robot.device.settings.is<IcpDevice>()) return 12.0;
  if (robot.device.settings.is<LscDevice>()) return 7.4;
  return std::nullopt;
}

/// Modules of the hexapod brown out below 8 V; servos sag only, as far as this battery sinks.
std::string Station::sink_supply(const Blow& blow) {
  const auto nominal = nominal_volts(robot_);
  if (!nominal) return "its supply holds";
  const bool modules = robot_.device.settings.is<IcpDevice>();
  const double volts = *nominal * (modules ? blow.volts : 0.8 + 0.2 * blow.volts);
  ++counts_.sunk_supplies;
  browned_out_ = browned_out_ || (modules && volts < 8);
  cell_.machine().disturb({sim::Disturbance::Kind::kSupply, -1, volts});
  supply_returns_ = cell_.now() + blow.cut;
  return "its supply sinks to " + std::to_string(volts) + " V for " +
         std::to_string(blow.cut / 1ms) + " ms";
}

void Station::look_at_supply() {
  if (supply_returns_ && cell_.now() >= *supply_returns_) {
    supply_returns_.reset();
    cell_.machine().disturb({sim::Disturbance::Kind::kSupply, -1, *nominal_volts(robot_)});
  }
  if (!browned_out_ || supply_returns_) return;
  // Its modules hold flags until somebody has read them: from then on he has to know.
  auto& hexapod = dynamic_cast<sim::IcpMachine&>(cell_.machine());
  bool told = true;
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const tmc222::Flags& flags = hexapod.module(leg).flags();
    told = told && !flags.vdd_reset && !flags.under_voltage && !flags.charge_pump_failure;
  }
  browned_out_ = !told;
}

void Station::look() {
  if (!host_) return;
  write();
  host_->loop->set_wall(kEpoch + cell_.now().time_since_epoch().count());
  host_->loop->step(cell_.now(), [this] {
    while (const auto event = host_->loop->machine().take_event()) {
      if (event->kind != control::ControlEvent::Kind::kDone) continue;
      counts_.motions_done += event->command != 0 ? 1 : 0;
    }
  });
  look_at_records();
  look_at_states();
  look_at_limits();
  look_at_disk();
}

/// The disk's side: one call at a time, which takes its time.
void Station::write() {
  disk_.set_wall(kEpoch + cell_.now().time_since_epoch().count());
  if (cell_.now() < host_->busy_until) return;
  host_->pump->publish();
  if (host_->pump->work()) host_->busy_until = cell_.now() + disk_.take_time();
}

void Station::say(const control::Outputs& outputs) {
  for (const control::ControlEvent& event : outputs.events) {
    hash_.add(static_cast<std::uint64_t>(event.kind) << 32 |
              static_cast<std::uint64_t>(event.state) << 16 |
              static_cast<std::uint64_t>(event.error.code));
    counts_.latched += event.kind == control::ControlEvent::Kind::kLatched ? 1 : 0;
    const bool state = event.kind == control::ControlEvent::Kind::kState;
    if (state && goes(event.state)) ++host_->begun;
    if (event.kind != control::ControlEvent::Kind::kLease) continue;
    look_at_lease(event.lease);
    if (event.lease.client == host_->stranger.client) host_->stranger = event.lease;
    if (event.lease.client == 1) host_->asked_for_lease = false;
  }
  for (const JournalRecord& record : outputs.records) {
    ++counts_.records;
    hash_.add(record.sequence << 8 | static_cast<std::uint64_t>(record.kind));
    host_->claims.push_back(record);
  }
}

/// The truth is in the last record that is safe, and in each one behind it.
void Station::look_at_records() {
  const std::uint64_t durable = host_->pump->durable_sequence();
  auto& claims = host_->claims;
  while (claims.size() > 1 && claims[1].sequence <= durable) claims.erase(claims.begin());
  const sim::Truth truth = cell_.machine().truth();
  for (const JournalRecord& claim : claims) {
    for (std::size_t j = 0; j < claim.positions.size(); ++j) {
      const JointPosition& said = claim.positions[j];
      if (said.quality == PositionQuality::kLost) continue;
      ++counts_.looks;
      const double room = resolution(j, claim.kind);
      if (truth.joints[j].q >= said.lower - room && truth.joints[j].q <= said.upper + room) {
        continue;
      }
      ADD_FAILURE() << where() << ": joint " << j + 1 << " stands at " << truth.joints[j].q
                    << ", record " << claim.sequence << " of kind " << static_cast<int>(claim.kind)
                    << " says " << said.lower << " to " << said.upper;
      return;
    }
  }
}

void Station::look_at_states() {
  const control::Controller& controller = host_->loop->controller();
  const MachineState state = controller.state();
  const DriverState driver = controller.driver().state();
  const bool moves = driver == DriverState::kMoving;
  // A tool works at ready.
  if (moves && !control::may_move(state) && controller.task() == 0) {
    ADD_FAILURE() << where() << ": its driver moves it in state " << name(state);
  }
  if (state == MachineState::kFault && !controller.latched()) {
    ADD_FAILURE() << where() << ": a fault without a cause";
  }
}

/// Nothing leads a joint beyond its limits; a limp arm may lie beyond one where it is found, or
/// fall there before anybody enables it. Servos sag by a little more once they hold it.
void Station::look_at_limits() {
  const MachineState state = host_->loop->controller().state();
  const bool held = state != MachineState::kOff && state != MachineState::kEnabling;
  const sim::Truth truth = cell_.machine().truth();
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    const double room = 2 * resolution(j);
    const double q = truth.joints[j].q;
    const bool inside = q >= robot_.joints[j].lower - room && q <= robot_.joints[j].upper + room;
    if (within_limits(robot_.joints[j], q) && held) been_inside_ |= 1U << j;
    if (inside || (been_inside_ >> j & 1) == 0) continue;
    ADD_FAILURE() << where() << ": joint " << j + 1 << " stands at " << q << ", beyond its limits";
    return;
  }
}

/// Where a disk takes nothing more: a hold within 100 ms, and no new motion.
void Station::look_at_disk() {
  if (!host_->pump->failed()) return;
  Host& host = *host_;
  if (!host.disk_failed_at) {
    host.disk_failed_at = cell_.now();
    host.begun_by_then = host.begun;
    ++counts_.disks_failed;
  }
  if (goes(host.loop->controller().state()) && cell_.now() > *host.disk_failed_at + 100ms) {
    ADD_FAILURE() << where() << ": goes on " << to_seconds(cell_.now() - *host.disk_failed_at)
                  << " s behind its disk's end";
  }
  if (host.begun != host.begun_by_then) {
    ADD_FAILURE() << where() << ": a motion begins whose end cannot be recorded";
    host.begun_by_then = host.begun;
  }
}

/// Each holder has a higher epoch than the one before, so there is one at a time.
void Station::look_at_lease(const control::LeaseToken& lease) {
  if (lease.epoch == 0) return;
  control::LeaseToken& last = host_->last_lease;
  EXPECT_GE(lease.epoch, last.epoch) << where() << ": an older lease is given again";
  if (lease.epoch == last.epoch) {
    EXPECT_EQ(lease.client, last.client) << where() << ": two have the same lease";
  }
  last = lease;
}

void Station::act() {
  if (!host_) return;
  if (misfortunes_ && random_.chance(0.02)) misfortune();
  if (host_ && random_.chance(0.12)) command();
}

Station::Blow Station::draw_blow() {
  const auto milliseconds = [&](std::int64_t lower, std::int64_t upper) {
    return Duration(std::chrono::milliseconds(random_.integer(lower, upper)));
  };
  Blow blow;
  blow.dice = random_.integer(0, supplies_sink_ ? 10 : 9);
  blow.seed = random_.bits();
  blow.recovers = random_.chance(0.4);
  blow.delay = milliseconds(1, 60);
  blow.cut = milliseconds(5, 900);
  blow.sync_max = milliseconds(20, 400);
  blow.power_too = random_.chance(0.3);
  blow.away = milliseconds(1, 1500);
  if (supplies_sink_) blow.volts = random_.uniform(0.35, 1);
  return blow;
}

void Station::misfortune() {
  const Blow blow = draw_blow();
  const std::uint64_t number = next_misfortune_++;
  if (spared_.contains(number)) return;
  const std::string where_it_was = where();
  happened_.push_back({number, where_it_was + ": " + strike(blow)});
}

/// On the BigRobotArm's byte wire a goto with a byte less is another goto, and half a request is
/// completed by the next host: nothing in its bytes says so. The page of the wire names both, and
/// its faults are measured by themselves.
bool Station::guarded() const {
  return !robot_.device.settings.is<BigRobotArmDevice>();
}

/// @return  what it was, for people
std::string Station::strike(const Blow& blow) {
  ++counts_.faults;
  sim::LinkFaultSpec spec;
  spec.seed = blow.seed;
  const auto time = [](Duration duration) { return std::to_string(duration / 1ms) + " ms"; };
  if (blow.dice < 3) {
    // Bytes that vanish, or come late; from time to time they come as they should again.
    const double chance = blow.recovers ? 0 : 0.002;
    for (sim::ByteFaults& bytes : spec.bytes) {
      bytes.drop = chance;
      bytes.delay = chance;
      bytes.delay_time = blow.delay;
    }
    if (!guarded()) spec.bytes[static_cast<std::size_t>(sim::LinkDirection::kToDevice)].drop = 0;
    cell_.line().set_faults(spec, cell_.now());
    return blow.recovers ? "its wire is whole"
                         : "its wire drops bytes, or keeps them for " + time(blow.delay);
  }
  if (blow.dice < 5) {
    // To a servo board as well half a frame is completed by the one behind the cut.
    const bool whole = guarded() && !robot_.device.settings.is<LscDevice>();
    const auto both_ways = std::optional<sim::LinkDirection>();
    spec.cuts.push_back({0ms, blow.cut, whole ? both_ways : sim::LinkDirection::kToHost});
    cell_.line().set_faults(spec, cell_.now());
    return "its wire is cut for " + time(blow.cut);
  }
  if (blow.dice < 6) {
    disk_.set_sync_time(1ms, blow.sync_max, blow.seed);
    return "its disk takes up to " + time(blow.sync_max);
  }
  if (blow.dice < 7) {
    disk_.fail_from_call(disk_.calls() + 1, {DiskErrorCode::kFull, 0});
    return "its disk is full";
  }
  if (blow.dice == 10) return sink_supply(blow);
  if (!guarded()) {
    cell_.run_to(cell_.now() + 200ms, 1ms, [this] {
      look();
      return cell_.line().quiet();
    });
  }
  kill(blow.power_too, blow.away, blow.seed);
  return (blow.power_too ? "its host loses power for " : "its host is killed, for ") +
         time(blow.away);
}

void Station::command() {
  control::LocalMachine& machine = host_->loop->machine();
  ++counts_.commands;
  const MachineState state = machine.state();
  const bool holds = machine.lease().epoch != 0;
  hash_.add(static_cast<std::uint64_t>(state));
  if (!holds) {
    if (!host_->asked_for_lease || random_.chance(0.2)) {
      machine.give(control::TakeLease{.take_over = random_.chance(0.5)});
      host_->asked_for_lease = true;
    }
    return;
  }
  if (state == MachineState::kOff) {
    machine.give(control::Enable{});
    return;
  }
  if (state == MachineState::kFault) {
    machine.give(control::Acknowledge{});
    return;
  }
  if (state == MachineState::kHeld) {
    if (random_.chance(0.7)) {
      machine.give(control::Resume{});
    } else {
      machine.give(control::Stop{});
    }
    return;
  }
  if (state == MachineState::kReady) return ask_to_move();
  const auto dice = random_.integer(0, 19);
  if (dice < 2) machine.give(control::Stop{});
  if (dice == 2) machine.give(control::Hold{});
  if (dice == 3) machine.give(control::SetFeed{random_.uniform(0.2, 1)});
  if (dice == 4) {
    static_cast<void>(host_->loop->post(
        {9, host_->stranger, control::TakeLease{.take_over = random_.chance(0.3)}}));
  }
  if (dice == 5) static_cast<void>(host_->loop->post({9, host_->stranger, control::Stop{}}));
}

/// Somebody looks, and says where it really stands.
void Station::declare_truth() {
  if (cell_.machine().truth().moving) return;
  control::Declare where;
  const sim::Truth truth = cell_.machine().truth();
  for (const sim::JointTruth& joint : truth.joints) {
    where.positions.push_back({PositionQuality::kCommanded, joint.q, joint.q, joint.q});
  }
  host_->loop->machine().give(where);
}

void Station::ask_to_move() {
  control::LocalMachine& machine = host_->loop->machine();
  const auto from = machine.reference();
  if (!from) {
    const bool streams_by_servos = robot_.device.settings.is<LscDevice>();
    if (!streams_by_servos) return declare_truth();
    host_->motions.push_back(first_motion(robot_));
    machine.give(control::Begin{host_->motions.back().get(), true});
    return;
  }
  const bool legs = robot_.joints[0].kind == JointKind::kPrismatic;
  JointVector to = *from;
  for (std::size_t j = 0; j < to.size(); ++j) {
    const double way = legs ? 3e-5 : 0.25;
    to[j] = std::clamp(to[j] + random_.uniform(-way, way), robot_.joints[j].lower,
                       robot_.joints[j].upper);
  }
  auto motion = motion_to(robot_, *from, to);
  if (!motion) return;
  host_->motions.push_back(std::move(motion));
  machine.give(control::Begin{host_->motions.back().get()});
}

void Station::heal() {
  misfortunes_ = false;
  if (supply_returns_) supply_returns_ = cell_.now();
  cell_.line().set_faults({}, cell_.now());
  disk_.set_sync_time(1ms, 20ms, 1);
  disk_.fail_from_call(0, {});
}

/// A run whose disk has failed does not trust it again. It may hear of it after the disk is mended.
void Station::start_anew_where_disk_failed() {
  if (host_ && host_->pump->failed()) kill(false, 1s, 1);
}

/// What the sentence of a supply that was away asks for, once in a while: the hexapod's firmware
/// gives its modules their parameters only when it is switched on.
void Station::switch_off_and_on() {
  if (!host_ || supply_returns_ || cell_.now() < next_switching_) return;
  const auto& why = host_->loop->controller().latched();
  if (!why || why->error.code != ErrorCode::kSupplyFlag) return;
  cell_.machine().disturb({sim::Disturbance::Kind::kSupply, -1, 0});
  browned_out_ = true;
  supply_returns_ = cell_.now() + 1s;
  next_switching_ = cell_.now() + 20s;
}

bool Station::ready() const {
  return host_ && host_->loop->controller().state() == MachineState::kReady &&
         host_->loop->controller().task() == 0;
}

std::string Station::where() const {
  std::string text =
      robot_.id + " at " + std::to_string(to_seconds(cell_.now().time_since_epoch()));
  if (!host_) return text;
  text += ", " + std::string(name(host_->loop->controller().state()));
  if (const auto& why = host_->loop->controller().latched()) {
    text += " (" + sentence_of(why->error, robot_) + ")";
  }
  return text;
}

}  // namespace sinew::test

#include "sinew/devices/bigrobotarm/bigrobotarm_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/split_mix.h"
#include "sinew/devices/arm_link/arm_link_device.h"

namespace sinew::sim {
namespace {

using bigrobotarm::kJoints;

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr double kTickSeconds = 1e-3;
constexpr double kNominalVolts = 12;  // ASSUMED: what such boards are fed with
constexpr double kOffVolts = 7;       // ASSUMED: the board's regulator gives up
/// Boot loader of an ATmega2560 board that waits for an upload.
constexpr Duration kBootLoader = std::chrono::milliseconds(1500);
/// ASSUMED: how far the mechanics go beyond the limits of the user interface.
constexpr double kEndMargin = 10 * kPi / 180;
constexpr double kFullStepsPerTurn = 200;

const BigRobotArmDevice& device_of(const RobotModel& robot) {
  const auto* device = robot.device.settings.as<BigRobotArmDevice>();
  SINEW_ASSERT(device != nullptr && robot.joints.size() == kJoints);
  return *device;
}

std::unique_ptr<BigRobotArmBoard> make_board(const BigRobotArmDevice& device, Instant boot,
                                             BigRobotArmProfile profile) {
  if (profile == BigRobotArmProfile::kOwn) {
    return std::make_unique<ArmLinkBoard>(device, boot);
  }
  return std::make_unique<BigRobotArmFirmware>(device, boot, profile);
}

BigRobotArmDevice with_dialect(BigRobotArmDevice device, BigRobotArmDialect dialect) {
  device.dialect = dialect;
  return device;
}

Dynamics dynamics_of(const RobotModel& robot) {
  const bool given = robot.dynamics.drives.size() == kJoints;
  return given ? robot.dynamics : big_robot_arm_dynamics(device_of(robot));
}

/// Signed: the firmware counts some joints against the model.
double joint_per_motor_of(const BigRobotArmJoint& joint) {
  return joint.steps_per_motor_rev / (joint.steps_per_rad * 2 * kPi);
}

}  // namespace

Dynamics big_robot_arm_dynamics(const BigRobotArmDevice& device) {
  // ASSUMED. Motors as other arms of this kind carry them: NEMA 17 (0.45 and 0.26 Nm) at base,
  // wrist and wrist rotate, NEMA 23 (1.26 Nm) at the elbow and a pair of them at the shoulder.
  // Rotors and corner speeds are usual for these sizes at 12 V. Friction of printed gears is such
  // that the arm, as its builders show, does not fall when the power goes.
  struct Assumed {
    double torque, motors, rotor, corner, friction;
  };
  constexpr std::array<Assumed, kJoints> kDrives{{{0.45, 1, 5.4e-6, 40, 0.8},
                                                  {1.26, 2, 30e-6, 30, 3.0},
                                                  {1.26, 1, 30e-6, 30, 1.5},
                                                  {0.26, 1, 3.5e-6, 40, 0.1},
                                                  {0.45, 1, 5.4e-6, 40, 0.3}}};
  Dynamics dynamics;
  for (std::size_t i = 0; i < kJoints; ++i) {
    StepperDrive drive;
    drive.holding_torque = kDrives[i].torque;
    drive.motors = static_cast<int>(kDrives[i].motors);
    drive.gear_ratio = std::abs(1 / joint_per_motor_of(device.joints[i]));
    drive.steps_per_turn = kFullStepsPerTurn;
    drive.microsteps = device.joints[i].steps_per_motor_rev / kFullStepsPerTurn;
    drive.rotor_inertia = kDrives[i].rotor;
    drive.corner_speed = kDrives[i].corner;
    drive.coulomb_friction = kDrives[i].friction;
    drive.viscous_friction = 0.02;
    dynamics.drives.push_back(drive);
  }
  // ASSUMED: printed links of this length with a motor in the upper arm, the forearm and the wrist.
  dynamics.links.push_back({0.80, {0, 0, 0}, {2e-3, 2e-3, 2e-3}});
  dynamics.links.push_back({0.90, {-0.11, 0, 0}, {1e-3, 4e-3, 4e-3}});
  dynamics.links.push_back({0.50, {0, 0, 0.06}, {1e-3, 1e-3, 4e-4}});
  dynamics.links.push_back({0.25, {0, 0.05, 0}, {3e-4, 2e-4, 3e-4}});
  dynamics.links.push_back({0.30, {0, 0, 0.06}, {4e-4, 4e-4, 2e-4}});
  return dynamics;
}

BigRobotArmMachine::Axis::Axis(const StepperDrive& stepper, double joint_inertia, double ratio,
                               double angle)
    : drive(stepper),
      inertia(stepper.rotor_inertia * stepper.motors + joint_inertia * ratio * ratio),
      joint_per_motor(ratio),
      motor(stepper, inertia, angle) {}

double BigRobotArmMachine::Axis::contact_torque() const {
  const double beyond = q() - std::clamp(q(), lower, upper);
  // As stiff as the tick can integrate.
  const double stiffness = 0.2 * inertia / (kTickSeconds * kTickSeconds);
  return -stiffness * beyond / joint_per_motor;
}

double BigRobotArmMachine::Axis::load(double weight) const {
  return (weight + extra_torque) * joint_per_motor + contact_torque();
}

std::array<BigRobotArmMachine::Axis, kJoints> BigRobotArmMachine::make_axes(
    const RobotModel& robot, const Dynamics& dynamics, ArmLoad& load, std::uint64_t seed) {
  // Stretched out it has the most to turn; one inertia for each motor, the slow one, for all time.
  load.update(std::array<double, kJoints>{0, kPi / 2, 0, 0, 0});
  SplitMix64 random(seed);
  const auto axis = [&](std::size_t i) {
    const double ratio = joint_per_motor_of(device_of(robot).joints[i]);
    const double full_step = 2 * kPi / kFullStepsPerTurn;
    return Axis(dynamics.drives[i], load.inertia(i), ratio,
                robot.joints[i].home / ratio + random.uniform(-2, 2) * full_step);
  };
  return {axis(0), axis(1), axis(2), axis(3), axis(4)};
}

BigRobotArmMachine::BigRobotArmMachine(const RobotModel& robot, BigRobotArmProfile profile,
                                       BigRobotArmDialect dialect, std::uint64_t seed, Instant boot)
    : device_(with_dialect(device_of(robot), dialect)),
      firmware_(make_board(device_, boot, profile)),
      load_(std::get<SerialGeometry>(robot.geometry), dynamics_of(robot)),
      axes_(make_axes(robot, dynamics_of(robot), load_, seed)),
      volts_(kNominalVolts),
      now_(boot),
      ticked_(boot) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    axes_[i].lower = lower_[i] = robot.joints[i].lower - kEndMargin;
    axes_[i].upper = upper_[i] = robot.joints[i].upper + kEndMargin;
  }
  update_load();
}

bool BigRobotArmMachine::supplied() const {
  return volts_ >= kOffVolts;
}

void BigRobotArmMachine::port_opened(Instant now) {
  advance(now);
  if (supplied()) restart(kBootLoader, false);
}

/// The worst that it can do: the power stages forget their phase as well.
void BigRobotArmMachine::restart(Duration deaf, bool power) {
  firmware_->restart(now_, deaf, power);
  const auto pulses = firmware_->rotor_steps(now_);
  for (std::size_t i = 0; i < kJoints; ++i) {
    axes_[i].motor.set_power(false);
    axes_[i].motor.set_power(true);
    axes_[i].pulses = pulses[i];
  }
}

void BigRobotArmMachine::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  now_ = now;
  while (ticked_ + kTick <= now) {
    if (at_rest()) {
      const Duration rest = now - ticked_;
      ticked_ += rest - rest % kTick;
      break;
    }
    tick(ticked_ + kTick);
  }
  if (supplied()) firmware_->advance(now);
}

bool BigRobotArmMachine::at_rest() const {
  if (supplied() && (firmware_->moving() || firmware_->next_event())) return false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Axis& axis = axes_[i];
    const double coulomb = axis.drive.coulomb_friction * std::abs(axis.joint_per_motor);
    if (axis.pulses != firmware_->rotor_steps(now_)[i]) return false;
    if (!axis.motor.settled(axis.load(load_.torque(i)), coulomb)) return false;
  }
  return true;
}

/// As physics has it. A motion that the firmware never ends, since a joint's speed is 0, is none.
bool BigRobotArmMachine::turning() const {
  const auto pulses = firmware_->rotor_steps(std::max(ticked_, now_));
  return std::ranges::any_of(axes_, [&](const Axis& axis) {
    const auto i = static_cast<std::size_t>(&axis - axes_.data());
    const double coulomb = axis.drive.coulomb_friction * std::abs(axis.joint_per_motor);
    return (supplied() && axis.pulses != pulses[i]) ||
           !axis.motor.settled(axis.load(load_.torque(i)), coulomb);
  });
}

void BigRobotArmMachine::tick(Instant end) {
  const bool on = supplied();
  if (on) firmware_->advance(end);
  const auto pulses = on ? firmware_->rotor_steps(end) : firmware_->rotor_steps(ticked_);
  update_load();
  for (std::size_t i = 0; i < kJoints; ++i) {
    Axis& axis = axes_[i];
    const double ratio = axis.joint_per_motor;
    const double turn =
        on ? (pulses[i] - axis.pulses) / device_.joints[i].steps_per_motor_rev * 2 * kPi : 0;
    axis.motor.advance(turn, axis.load(load_.torque(i)),
                       axis.drive.coulomb_friction * std::abs(ratio),
                       axis.drive.viscous_friction * ratio * ratio, kTickSeconds);
    axis.pulses = pulses[i];
  }
  ticked_ = end;
}

void BigRobotArmMachine::update_load() {
  std::array<double, kJoints> q{};
  for (std::size_t i = 0; i < kJoints; ++i) q[i] = axes_[i].q();
  load_.update(q);
}

std::optional<Instant> BigRobotArmMachine::next_event() const {
  return supplied() ? firmware_->next_event() : std::nullopt;
}

Truth BigRobotArmMachine::truth() const {
  Truth truth;
  const auto counted = firmware_->counted_steps(std::max(ticked_, now_));
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Axis& axis = axes_[i];
    truth.joints.push_back({.q = axis.q(),
                            .qd = axis.motor.speed() * axis.joint_per_motor,
                            .believed = counted[i] / device_.joints[i].steps_per_rad,
                            .at_end_stop = axis.contact_torque() != 0,
                            .lost_steps = axis.motor.slipped()});
  }
  truth.supply_volts = volts_;
  truth.moving = turning();
  truth.deaf = supplied() && firmware_->deaf();
  truth.tool = firmware_->gripper().position * kPi / 180;
  truth.bytes_lost = firmware_->bytes_lost();
  return truth;
}

LastingState BigRobotArmMachine::lasting_state() const {
  LastingState state;
  for (const Axis& axis : axes_) state.bodies.push_back({axis.motor.angle(), axis.motor.speed()});
  return state;
}

bool BigRobotArmMachine::restore(const LastingState& state) {
  if (state.bodies.size() != kJoints || !state.memory.empty()) return false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    axes_[i].motor.place(state.bodies[i].angle, state.bodies[i].speed);
  }
  update_load();
  return true;
}

void BigRobotArmMachine::disturb(const Disturbance& what) {
  const bool was_on = supplied();
  const auto joint = static_cast<std::size_t>(what.joint);
  const bool of_joint = what.joint >= 0 && joint < kJoints;
  switch (what.kind) {
    case Disturbance::Kind::kSupply:
      volts_ = what.value;
      for (Axis& axis : axes_) axis.motor.set_supply_ratio(volts_ / kNominalVolts);
      if (was_on && !supplied()) {
        for (Axis& axis : axes_) axis.motor.set_power(false);
        firmware_->restart(now_, Duration::zero(), true);
      }
      if (!was_on && supplied()) restart(kBootLoader, true);
      break;
    case Disturbance::Kind::kPayload:
      load_.set_payload(what.value);
      break;
    case Disturbance::Kind::kBlock:
      if (!of_joint) break;
      (axes_[joint].q() < what.value ? axes_[joint].upper : axes_[joint].lower) = what.value;
      break;
    case Disturbance::Kind::kUnblock:
      if (!of_joint) break;
      axes_[joint].lower = lower_[joint];
      axes_[joint].upper = upper_[joint];
      break;
    case Disturbance::Kind::kLoad:
      if (of_joint) axes_[joint].extra_torque = what.value;
      break;
    case Disturbance::Kind::kCoupling:
    case Disturbance::Kind::kMagnet:
    case Disturbance::Kind::kLead:
    case Disturbance::Kind::kProbe:
      break;  // it has none
  }
  update_load();
}

void BigRobotArmMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (supplied()) firmware_->receive(bytes, now);
}

std::size_t BigRobotArmMachine::take_output(std::span<std::uint8_t> out) {
  return supplied() ? firmware_->take_output(out) : 0;
}

}  // namespace sinew::sim

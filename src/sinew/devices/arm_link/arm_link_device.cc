#include "sinew/devices/arm_link/arm_link_device.h"

#include <algorithm>
#include <cmath>

namespace sinew {

using namespace bigrobotarm;

namespace {

constexpr Duration kSlice = std::chrono::milliseconds(1);
constexpr double kUnits = mcu::kUnitsPerStep;
constexpr double kServoUnits = mcu::kServoUnitsPerDegree;

}  // namespace

ArmLinkBoard::ArmLinkBoard(const BigRobotArmDevice& settings, Instant boot)
    : boot_(boot), sliced_(boot) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    facts_.axes[i] = {static_cast<std::uint16_t>(settings.joints[i].steps_per_motor_rev),
                      static_cast<std::uint16_t>(settings.joints[i].multiplier_boot)};
  }
  board_.emplace(facts_, kept_);
}

std::uint32_t ArmLinkBoard::ms() const {
  return static_cast<std::uint32_t>((sliced_ - boot_) / kSlice);
}

void ArmLinkBoard::restart(Instant now, Duration deaf, bool power) {
  advance(now);
  if (power) kept_ = {};
  port_.clear();
  board_.emplace(facts_, kept_);
  deaf_until_ = now + deaf;
}

void ArmLinkBoard::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  for (const std::uint8_t byte : bytes) {
    if (now < deaf_until_ || port_.full()) {
      ++bytes_lost_;
    } else {
      port_.push_back(byte);
    }
  }
  feed();
}

/// What its main loop does, again and again.
void ArmLinkBoard::feed() {
  while (!port_.empty() && board_->takes()) {
    const std::uint8_t byte = port_[0];
    port_.drop_front(1);
    board_->receive(byte, ms());
  }
  board_->poll(ms());
}

/// Something goes on by itself.
bool ArmLinkBoard::busy() const {
  const mcu::ArmMotion& motion = board_->motion();
  return motion.moving() || motion.queued_ms() > 0 || motion.gripper().moving() || !port_.empty();
}

void ArmLinkBoard::advance(Instant now) {
  while (sliced_ + kSlice <= now) {
    if (!busy()) {
      const Duration rest = now - sliced_;
      sliced_ += rest - rest % kSlice;
      // A session ends also at rest, and the stop line is looked at.
      board_->slice(stop_line_);
      board_->poll(ms());
      break;
    }
    slice();
  }
}

void ArmLinkBoard::slice() {
  feed();
  const mcu::ArmMotion& motion = board_->motion();
  std::array<std::int32_t, kJoints> before{};
  for (std::uint8_t i = 0; i < kJoints; ++i) before[i] = motion.position(i);
  board_->slice(stop_line_);
  for (int tick = 0; tick < mcu::StepPulses::kTicks; ++tick) board_->pulses().tick();
  for (std::uint8_t i = 0; i < kJoints; ++i) {
    rotor_[i] += (motion.position(i) - before[i]) / kUnits;
  }
  sliced_ += kSlice;
  board_->poll(ms());
}

std::size_t ArmLinkBoard::take_output(std::span<std::uint8_t> out) {
  mcu::ReplyBuffer& replies = board_->replies();
  std::size_t size = 0;
  for (; size < out.size() && !replies.empty(); ++size) out[size] = replies.take();
  return size;
}

std::optional<Instant> ArmLinkBoard::next_event() const {
  return busy() ? std::optional(sliced_ + kSlice) : std::nullopt;
}

std::array<double, kJoints> ArmLinkBoard::rotor_steps(Instant /*now*/) const {
  return rotor_;
}

std::array<double, kJoints> ArmLinkBoard::counted_steps(Instant /*now*/) const {
  std::array<double, kJoints> steps{};
  for (std::uint8_t i = 0; i < kJoints; ++i) {
    steps[i] = board_->motion().position(i) / kUnits;
  }
  return steps;
}

Gripper ArmLinkBoard::gripper() const {
  const double degrees = board_->motion().gripper().angle() / kServoUnits;
  return {board_->gripper_on(), static_cast<std::uint8_t>(std::lround(degrees))};
}

}  // namespace sinew

#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>

#include "firmware/emulation_avr/avr_board.h"
#include "support/board_under_test.h"

namespace sinew::emulation {

/// The BigRobotArm's board: an emulated ATmega2560 that runs the image which is flashed, with its
/// port and its pins as they are seen from outside.
class MegaBoard : public mcu::BoardUnderTest {
 public:
  static constexpr std::size_t kAxes = mcu::kArmAxes;
  static constexpr Duration kStart = std::chrono::milliseconds(400);  ///< until it is up

  /// Power has just come on, and the image has started.
  MegaBoard();

  void send(std::span<const std::uint8_t> bytes) override;
  void run_ms(int ms) override;
  /// @param time  since power came on
  void run_until(Duration time) { chip_->run_until(time); }
  mcu::Bytes take_output() override { return std::exchange(output_, {}); }
  std::int64_t steps(std::size_t axis) const override { return steps_[axis]; }
  double seconds() const override { return to_seconds(chip_->now()); }
  /// Of the last whole pulse; 0 before it.
  double gripper_us() const override { return servo_us_; }
  void set_stop_line(bool low) override;
  void restart() override;
  void power_cycle() override;

  /// There is current in the motor.
  bool enabled(std::size_t axis) const;
  bool lamp() const { return !chip_->drives_low('B', 7); }
  /// Shortest step pulse so far, s.
  double shortest_pulse() const { return shortest_pulse_; }
  /// The program does not go on, until its watchdog restarts it.
  void hang() { chip_->hang(); }
  int watchdog_restarts() const { return chip_->restarts(); }

 private:
  void watch_pins();
  void step(std::size_t axis, bool high);

  std::unique_ptr<AvrBoard> chip_;
  std::uint64_t noise_ = 0;
  std::deque<std::uint8_t> input_;
  bool sending_ = false;
  mcu::Bytes output_;
  std::array<std::int64_t, kAxes> steps_{};
  std::array<std::uint64_t, kAxes> raised_{};  ///< cycle
  std::array<bool, kAxes> high_{};
  std::array<bool, kAxes> backwards_{};
  double shortest_pulse_ = 1;
  std::uint64_t servo_raised_ = 0;
  double servo_us_ = 0;
};

/// Path of the image that is flashed.
std::string mega_image();

}  // namespace sinew::emulation

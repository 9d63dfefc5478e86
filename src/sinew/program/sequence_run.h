#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/program/sequence_plan.h"

namespace sinew::sequence {

/// What became of one order.
struct Record {
  const Order* order = nullptr;
  Instant asked{};
  Instant started{};  ///< when the device took a motion up; else as asked
  Instant done{};
  BigRobotArmAngles q_reported{};  ///< rad; the device reports its targets
};

/// Runs a program on a BigRobotArm through its driver, one order at a time. It has no clock and no
/// port: `poll` follows each receive() or poll() of the driver.
///
///   phase     | what happens                   | next
///   ----------+--------------------------------+-----------------------------
///   kOpening  | the device's first status      | kRunning, or kFailed (refused)
///   kOpening  | none within kOpeningLimit      | kFailed
///   kRunning  | an order is done               | kRunning, kDone after the last
///   kRunning  | stop()                         | kStopping
///   kRunning, | an order fails                 | kFailed
///   kStopping | the order under way is done,   | kStopped
///             | scaled settings are put back   |
///
/// The device has no stop: a motion that it took up is finished in any case.
class Run {
 public:
  /// Opening the port may reset the board, whose boot loader then listens for a second or two.
  static constexpr Duration kOpeningLimit = std::chrono::seconds(6);

  enum class Phase : std::uint8_t { kOpening, kRunning, kStopping, kDone, kStopped, kFailed };

  /// @param robot, driver  outlive the run
  Run(const Program& program, const RobotModel& robot, BigRobotArmDriver& driver,
      Duration opening_limit = kOpeningLimit);

  /// The port is open.
  void start(Instant now);
  void poll(Instant now);
  /// No further motion. Settings that were scaled for a synchronised move are still put back.
  void stop();

  Phase phase() const { return phase_; }
  bool finished() const { return phase_ >= Phase::kDone; }
  const Plan& plan() const { return plan_; }
  std::span<const Record> records() const { return records_; }
  /// The order under way, if any.
  std::optional<Record> under_way() const;

  /// Predicted motion that is behind the run, s.
  double progress(Instant now) const;

  /// Why the phase is kFailed: the line (0: before the first order) and the reason.
  const std::optional<PlanRefusal>& failure() const { return failure_; }
  /// The device answered with the values of power-up: it may have been reset, and its zero moved.
  bool looked_like_boot() const { return looked_like_boot_; }

 private:
  void take(const BigRobotArmDriver::StatusRead& read);
  void take(const BigRobotArmDriver::Failed& failed);
  void prepare_closing();
  const Order* next_order();
  void issue_next(Instant now);
  Expected<void> issue(const Order& order, Instant now);
  void fail(const Error& error);

  const Program& program_;
  const RobotModel& robot_;
  BigRobotArmDriver& driver_;
  Phase phase_ = Phase::kOpening;
  Duration opening_limit_;
  Instant opened_at_{};
  Error opening_trouble_;
  Plan plan_;
  std::size_t next_ = 0;
  FixedVector<Order, 2> closing_;  ///< what a stopped run still owes the device
  std::size_t closing_next_ = 0;
  std::optional<Record> current_;
  std::vector<Record> records_;
  std::optional<PlanRefusal> failure_;
  bool looked_like_boot_ = false;
};

}  // namespace sinew::sequence

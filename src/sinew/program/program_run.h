#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sinew/program/program_plan.h"

namespace sinew::program {

/// What became of one order.
struct Record {
  const Order* order = nullptr;
  Instant asked{};
  Instant done{};
  Start q_start;        ///< of a move, as it was really made
  JointVector q;        ///< where the move was sent
  double duration = 0;  ///< s, predicted at the moment it was asked; of `home` the upper bound
  double arrival = 0;   ///< s, of a motion: when its joints are predicted to be there
  FixedVector<JointPosition, kMaxJoints> reported;  ///< when it was done
};

/// What the driver told beside the orders: nothing broke, but somebody should know.
struct Notice {
  Instant at{};
  int line = 0;  ///< of the order under way; 0: of none
  Error error;
};

/// Runs a program on any robot through its driver, one order at a time; a motion is handed to the
/// driver in the pieces that its device takes, and a `home` ends with the way to the robot's home.
/// It has no clock and no port: `poll` follows each call of the driver's.
///
///   phase     | what happens                    | next
///   ----------+---------------------------------+-------------------------------------
///   kOpening  | the driver is ready             | kRunning, or kFailed (refused)
///   kOpening  | it is not within the limit, or  | kFailed
///             | cannot be before its fault ends |
///   kRunning  | an order is done                | kRunning, kDone after the last
///   kRunning  | stop()                          | kStopping, kStopped where nothing moves
///   kRunning  | an order fails                  | kFailed
///   kRunning  | the next one is due, and the    | kRunning once it is ready again, kFailed where
///             | driver is in doubt              | that takes longer than an opening may
///   kStopping | the driver has stopped          | kStopped
class Run {
 public:
  /// Opening a port may reset the board, whose boot loader then listens for a second or two.
  static constexpr Duration kOpeningLimit = std::chrono::seconds(5);
  /// So many notices are kept, the first ones; all are counted.
  static constexpr std::size_t kNoticesMax = 100;

  enum class Phase : std::uint8_t { kOpening, kRunning, kStopping, kDone, kStopped, kFailed };

  /// @param program, robot, driver  outlive the run
  Run(const Program& program, const RobotModel& robot, Driver& driver,
      Duration opening_limit = kOpeningLimit);

  /// Where somebody says the machine stands, for one that cannot know; it counts where the driver
  /// does not know better.
  void declare(const JointVector& q) { declared_ = q; }
  /// For the plan's estimate of `home`. Before start().
  void expect_homing(const Homing& homing) { homing_ = homing; }

  /// The port is open.
  void start(Instant now);
  void poll(Instant now);
  void stop(Instant now);

  Phase phase() const { return phase_; }
  bool finished() const { return phase_ >= Phase::kDone; }
  const Plan& plan() const { return plan_; }
  std::span<const Record> records() const { return records_; }
  const std::optional<Record>& under_way() const { return current_; }
  const Driver& driver() const { return driver_; }
  std::span<const Notice> notices() const { return notices_; }
  /// Also of those that were not kept.
  std::size_t notices_told() const { return notices_told_; }
  Instant opened_at() const { return opened_at_; }
  /// When the first order was given; nothing before.
  const std::optional<Instant>& begun_at() const { return begun_at_; }
  /// Share of the predicted duration that is behind the run, 0..1; homing counts with its bound.
  double progress(Instant now) const;
  /// When poll() should be called next even if the driver has nothing to do.
  std::optional<Instant> next_deadline(Instant now) const;
  /// Why the phase is kFailed: the line (0: before the first order) and the reason.
  const std::optional<Refusal>& failure() const { return failure_; }

 private:
  void take(const DriverEvent& event, Instant now);
  void take_notice(const Error& error, Instant now);
  bool in_doubt(Instant now);
  Error silence() const;
  void begin();
  void issue_next(Instant now);
  std::expected<void, Refusal> issue(const Order& order, Instant now);
  std::expected<void, Refusal> issue_move(Instant now);
  std::expected<void, Refusal> order_done(Instant now);
  std::expected<void, Refusal> motion_done(Instant now);
  std::expected<void, Refusal> go_home(Instant now);
  std::expected<void, Refusal> next_leg(Instant now);
  std::expected<void, Refusal> send_first(Instant now, int line);
  Expected<void> send_piece(Instant now);
  Expected<void> feed(Instant now);
  void finish_order(Instant now);
  void fail(const Error& error, Instant now);
  void fail(const Refusal& refusal, Instant now);
  Start known_positions() const;

  const Program& program_;
  const RobotModel& robot_;
  Driver& driver_;
  Duration opening_limit_;
  Homing homing_;
  Phase phase_ = Phase::kOpening;
  Instant opened_at_{};
  std::optional<Instant> begun_at_;
  Error trouble_;  ///< of an opening, or of a driver in doubt
  std::optional<Instant> doubt_since_;
  std::vector<Notice> notices_;
  std::size_t notices_told_ = 0;
  Plan plan_;
  std::size_t next_ = 0;
  std::optional<Record> current_;
  std::vector<Record> records_;
  std::optional<Refusal> failure_;

  Start declared_;
  Start q_;              ///< where the last order left the joints
  int outstanding_ = 0;  ///< commands that the driver accepted and has not ended
  std::unique_ptr<RowPlanner> planner_;
  std::span<const Step> rows_left_;  ///< of the order under way, behind its motion
  std::optional<HomeReturn> back_;   ///< behind the search of a `home` under way
  std::size_t leg_ = 0;              ///< of it, the next one
  std::vector<JointMove> pieces_;    ///< of the motion under way
  std::size_t pieces_sent_ = 0;
  std::optional<Instant> wait_end_;
};

}  // namespace sinew::program

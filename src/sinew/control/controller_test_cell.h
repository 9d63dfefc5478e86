#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <vector>

#include "sinew/control/controller.h"
#include "sinew/control/path_motion.h"
#include "sinew/control/piece_motion.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/motion_planner.h"
#include "support/property.h"
#include "support/robots.h"

/// A controller with a driver that only pretends, for what the controller does by itself. The real
/// ones with their devices are in tests/cell.
namespace sinew::control::test {

using namespace std::chrono_literals;

/// Takes pieces and lets their time pass. A streaming one takes the next piece 20 ms early.
class PretendDriver final : public Driver {
 public:
  PretendDriver(const RobotModel& robot) : robot_(robot) {
    for (const Joint& joint : robot.joints) {
      positions_.push_back({PositionQuality::kCommanded, joint.home, joint.home, joint.home});
    }
  }

  void open(Instant now) override {
    state_ = DriverState::kOpening;
    ready_at_ = now + opening;
  }
  void close(Instant) override {
    if (state_ == DriverState::kClosed) return;
    const bool opening_ends = state_ == DriverState::kOpening;
    if (!queue_.empty() || opening_ends) {
      tell(DriverEvent::Kind::kFailed, {ErrorCode::kPortClosed});
    }
    queue_.clear();
    clears_at_.reset();
    state_ = DriverState::kClosed;
  }
  DriverState state() const override { return state_; }
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override {
    return {positions_.data(), positions_.size()};
  }
  DriverHealth health() const override { return {}; }
  bool wants_move(Instant now) const override {
    if (deaf) return false;
    if (state_ == DriverState::kReady) return true;
    return state_ == DriverState::kMoving && queue_.size() < 2 && ends_.back() - now <= 20ms;
  }
  Expected<void> move(const JointMove& move, Instant now) override {
    if (refusal) return std::unexpected(*refusal);
    if (queue_.empty()) ends_ = {now};
    queue_.push_back(move);
    ends_.push_back(ends_.back() + move.duration);
    pieces.push_back(move);
    state_ = DriverState::kMoving;
    return {};
  }
  void stop(Instant now) override {
    ++stops;
    if (state_ == DriverState::kClosed) return;
    if (state_ == DriverState::kFault && !stops_in_fault) return;
    queue_.clear();
    if (state_ == DriverState::kOpening) return;
    state_ = DriverState::kStopping;
    ready_at_ = now + stop_takes;
  }
  std::optional<Instant> goes_on_until() const override {
    if (!tells_how_long || state_ != DriverState::kStopping) return std::nullopt;
    return ready_at_;
  }
  std::optional<JointInterval> counted(std::size_t joint) const override { return counts[joint]; }
  Expected<void> home(Instant now, std::uint8_t joints) override {
    homed.push_back(joints);
    state_ = DriverState::kMoving;
    homing_until_ = now + 2s;
    return {};
  }
  std::optional<std::size_t> homing_joint() const override { return searching; }
  Expected<void> service(DeviceService what, Instant now) override {
    services.push_back(what);
    state_ = DriverState::kMoving;
    homing_until_ = now + 200ms;
    return {};
  }
  bool free() const override {
    return !services.empty() && services.back() == DeviceService::kFree;
  }
  Expected<void> nudge(std::size_t joint, double way, Duration duration, Instant now) override {
    state_ = DriverState::kMoving;
    homing_until_ = now + duration;
    nudges.push_back(way);
    JointPosition& own = positions_[joint];
    own.q += way, own.lower += way, own.upper += way;
    return {};
  }
  Expected<void> may_probe() const override {
    if (probe_fault) return std::unexpected(*probe_fault);
    return {};
  }
  /// Touches half way.
  Expected<void> probe(std::size_t joint, double way, Duration duration, Instant now) override {
    probe_durations.push_back(duration);
    return nudge(joint, way / 2, duration / 2, now);
  }
  Expected<void> tool(const ToolAction&, Instant now) override {
    state_ = DriverState::kMoving;
    homing_until_ = now + 200ms;
    return {};
  }
  /// Finds its device anew, as the hexapod's driver does.
  Expected<void> clear_fault(Instant now) override {
    ++clears;
    if (cause_stays) return std::unexpected(*fault_);
    if (clearing_takes) {
      state_ = DriverState::kOpening;
      clears_at_ = now + *clearing_takes;
      return {};
    }
    fault_.reset();
    open(now);
    return {};
  }
  bool clearing() const override { return clears_at_.has_value(); }
  bool held_by_stop() const override { return held; }
  void remember(const DriverMemory& memory) override { remembered = memory; }
  void declare_positions(std::span<const JointPosition> positions) override {
    for (std::size_t j = 0; j < positions.size(); ++j) {
      if (!declarable) continue;
      positions_[j] = positions[j];
    }
  }
  void poll(Instant now) override {
    if (clears_at_ && now >= *clears_at_) {
      clears_at_.reset();
      ready_at_ = now;
      if (!clearing_fails) fault_.reset();
      state_ = clearing_fails ? DriverState::kFault : DriverState::kReady;
      tell(clearing_fails ? DriverEvent::Kind::kFailed : DriverEvent::Kind::kDone);
    }
    if (clears_at_) return;
    if (state_ == DriverState::kOpening && now >= ready_at_ && !silent) {
      state_ = DriverState::kReady;
      tell(DriverEvent::Kind::kReady);
    }
    if (state_ == DriverState::kStopping && now >= ready_at_) {
      state_ = fault_ ? DriverState::kFault : DriverState::kReady;
      homing_until_.reset();
      tell(DriverEvent::Kind::kStopped);
    }
    if (homing_until_ && now >= *homing_until_) {
      homing_until_.reset();
      state_ = DriverState::kReady;
      tell(DriverEvent::Kind::kDone);
    }
    while (!queue_.empty() && now >= ends_[1]) {
      const bool end = std::ranges::all_of(queue_[0].qd, [](double qd) { return qd == 0; });
      looking = looks_at_ends && end;
      if (looking && !looks_allowed) return;
      looking = false;
      for (std::size_t j = 0; j < positions_.size(); ++j) {
        const double q = queue_[0].q[j];
        positions_[j] = {PositionQuality::kCommanded, q, q, q};
      }
      queue_.drop_front(1);
      ends_.drop_front(1);
      tell(DriverEvent::Kind::kDone);
      if (queue_.empty()) state_ = DriverState::kReady;
    }
  }
  std::optional<Instant> next_deadline() const override { return std::nullopt; }
  std::optional<DriverEvent> take_event() override { return events_.take_front(); }

  void fail(const Error& error) {
    queue_.clear();
    homing_until_.reset();
    fault_ = error;
    state_ = DriverState::kFault;
    tell(DriverEvent::Kind::kFailed, error);
  }
  void notice(const Error& error) { tell(DriverEvent::Kind::kNotice, error); }
  void doubt(Instant now) {
    state_ = DriverState::kOpening;
    ready_at_ = now + opening;
  }
  bool looks() const override { return looking; }
  void allow_looks(bool allowed) override { looks_allowed = allowed; }
  void lose(std::size_t joint) { positions_[joint] = {}; }
  void set(std::size_t joint, const JointPosition& position) { positions_[joint] = position; }

  Duration opening = 30ms;
  Duration stop_takes = 30ms;
  bool tells_how_long = false;  ///< a stop takes
  bool stops_in_fault = false;  ///< as boards that latch each stop
  std::array<std::optional<JointInterval>, kMaxJoints> counts{};
  bool silent = false;
  bool deaf = false;
  bool cause_stays = false;
  /// Its device has to be told for so long, and a port that closes before ends that.
  std::optional<Duration> clearing_takes;
  bool clearing_fails = false;
  bool held = false;
  DriverMemory remembered;
  bool declarable = true;
  bool looks_at_ends = false;  ///< of motions, at a device that forgets by telling
  bool looking = false;
  bool looks_allowed = true;
  std::optional<Error> refusal;
  std::vector<JointMove> pieces;
  std::vector<double> nudges;
  std::optional<Error> probe_fault;
  std::vector<Duration> probe_durations;
  std::vector<std::uint8_t> homed;  ///< joints of each search
  std::optional<std::size_t> searching;
  std::vector<DeviceService> services;
  int stops = 0;
  int clears = 0;

 private:
  void tell(DriverEvent::Kind kind, const Error& error = {}) { events_.push_back({kind, error}); }

  const RobotModel& robot_;
  DriverState state_ = DriverState::kClosed;
  std::optional<Error> fault_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  FixedVector<JointMove, 4> queue_;
  FixedVector<Instant, 5> ends_;
  FixedVector<DriverEvent, 16> events_;
  Instant ready_at_{};
  std::optional<Instant> clears_at_;
  std::optional<Instant> homing_until_;
};

/// A controller, its pretended driver, a disk that is as quick as is said, and one cycle after the
/// other.
class ControlCell {
 public:
  static constexpr Duration kCycle = 10ms;

  explicit ControlCell(const char* id, bool journal = false, const ControllerStart& start = {})
      : robot(slow(id)), driver(robot), controller(robot, driver, settings(journal), start) {}

  /// One cycle with these commands; events are kept.
  void cycle(std::initializer_list<Command> commands = {}) {
    cycle(std::span(commands.begin(), commands.size()));
  }
  void cycle(std::span<const Command> commands) {
    now += kCycle;
    driver.poll(now);
    write();
    const Outputs& out = controller.step({.commands = commands,
                                          .port_open = port_open,
                                          .durable_sequence = durable,
                                          .journal_failed = disk_failed,
                                          .closing = closing,
                                          .wall_ns = 0},
                                         now);
    for (const ControlEvent& event : out.events) events.push_back(event);
    for (const JournalRecord& record : out.records) {
      records.push_back(record);
      waiting_.push_back({record.sequence, now + sync});
    }
  }
  void run(Duration time) {
    for (Duration t{}; t < time; t += kCycle) cycle(renewal());
  }
  template <class Condition>
  bool run_until(Condition condition, Duration longest = 60s) {
    for (Duration t{}; t < longest; t += kCycle) {
      if (condition()) return true;
      cycle(renewal());
    }
    return condition();
  }

  std::uint32_t give(const CommandWhat& what) {
    cycle({Command{++last_id, lease, what}});
    return last_id;
  }
  /// Lease and all, until it takes commands.
  void make_ready() {
    give(TakeLease{});
    for (const ControlEvent& event : events) {
      if (event.kind == ControlEvent::Kind::kLease) lease = event.lease;
    }
    give(Enable{});
    ASSERT_TRUE(run_until([&] { return controller.state() == MachineState::kReady; }));
    events.clear();
  }
  /// How the command ended; nothing while it has not.
  std::optional<ControlEvent> end_of(std::uint32_t command) const {
    using Kind = ControlEvent::Kind;
    for (const ControlEvent& event : events) {
      if (event.command == command && event.kind != Kind::kStarted) return event;
    }
    return std::nullopt;
  }
  std::vector<MachineState> states() const {
    std::vector<MachineState> all;
    for (const ControlEvent& event : events) {
      if (event.kind == ControlEvent::Kind::kState) all.push_back(event.state);
    }
    return all;
  }
  JointVector by(double way) const {
    JointVector q = controller.reference().value();
    q[0] += way;
    return q;
  }
  /// A motion that can be changed under way, from where it stands.
  MotionSource& path_to(const JointVector& q) {
    planning::MotionPlanner planner(robot);
    const auto from = *controller.reference();
    const auto start = planner.place_at({from.data(), from.size()});
    planning::Move move;
    planning::JointArray goal{};
    std::ranges::copy(q, goal.begin());
    move.way = planning::MoveJ{goal};
    planned = std::make_unique<planning::PlannedMotion>(planner.make_motion());
    EXPECT_TRUE(planner.plan(*start, std::span(&move, 1), 0, *planned));
    path = std::make_unique<PathMotion>(robot);
    EXPECT_FALSE(path->start(planned->path));
    return *path;
  }
  MotionSource& whole_move_to(const JointVector& q, Duration time = 2s) {
    JointMove move{.q = q, .qd = {}, .duration = time};
    move.qd.resize(q.size());
    pieces = std::make_unique<PieceMotion>(*controller.reference(), std::vector<JointMove>(1, move),
                                           robot);
    return *pieces;
  }

  RobotModel robot;
  PretendDriver driver;
  Controller controller;
  Instant now{};
  LeaseToken lease{.client = 7};
  bool renews = true;
  bool port_open = true;
  bool closing = false;
  std::uint32_t last_id = 0;
  std::vector<ControlEvent> events;
  std::vector<JournalRecord> records;
  Duration sync = 15ms;
  std::uint64_t durable = 0;
  bool disk_failed = false;
  std::unique_ptr<planning::PlannedMotion> planned;
  std::unique_ptr<PathMotion> path;
  std::unique_ptr<PieceMotion> pieces;

 private:
  /// So that there is time for something to happen on the way.
  static RobotModel slow(const char* id) {
    RobotModel robot = sinew::test::robot(id);
    for (Joint& joint : robot.joints) {
      joint.velocity_max = 0.5;
      joint.acceleration_max = 1;
      joint.jerk_max = 5;
    }
    return robot;
  }
  static ControllerSettings settings(bool journal) {
    ControllerSettings settings;
    if (!journal) return settings;
    settings.journal.emplace();
    for (int j = 0; j < 5; ++j) settings.journal->joints.push_back({.block = 0.1, .lead = 0.05});
    return settings;
  }
  std::span<const Command> renewal() {
    if (!renews || lease.epoch == 0) return {};
    renewal_ = {0, lease, RenewLease{}};
    return {&renewal_, 1};
  }
  void write() {
    while (!disk_failed && !waiting_.empty() && waiting_.front().second <= now) {
      durable = waiting_.front().first;
      waiting_.pop_front();
    }
  }

  Command renewal_;
  std::deque<std::pair<std::uint64_t, Instant>> waiting_;
};

}  // namespace sinew::control::test

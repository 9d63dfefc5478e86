#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sinew/control/machine.h"
#include "sinew/program/language/eyes.h"
#include "sinew/program/plans/cube_rows.h"
#include "sinew/program/plans/program_plan.h"

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
  std::optional<bool> holds{};                      ///< of an `if`: whether its condition does
  std::optional<grasping::Cube> cube{};             ///< of a `pick`: what it took
};

/// What the machine told beside the orders: nothing broke, but somebody should know.
struct Notice {
  Instant at{};
  int line = 0;  ///< of the order under way; 0: of none
  Error error;
  int file = 0;  ///< of Program::files
};

/// What a row with cubes decided by what was seen, for the record of a run.
struct Decision {
  enum class Kind : std::uint8_t { kPick, kHeld, kNotHeld, kPlace, kRefused };
  Kind kind = Kind::kRefused;
  int line = 0;
  std::optional<grasping::Cube> cube{};  ///< that it is about
  int grasp = 0;                         ///< of this cube, from 1
  std::optional<Error> why{};            ///< of kRefused
};
std::string_view name(Decision::Kind kind);

/// Where somebody says that the machine stands.
struct Statement {
  Start q;  ///< nothing: as it is shown (control::as_shown)
  /// It is held against all that is known otherwise, and the run is refused where they contradict;
  /// else it counts only where nothing else is known.
  bool has_looked = true;
  bool moved = false;            ///< by hand: what was known does not count
  JournalPositions last_said{};  ///< shown: of joints that are lost
};

/// Runs a program on a machine, one order at a time, as its client: it takes the lease, enables it
/// where it is off, and a `home` ends with the way to the robot's home. It has no clock and no
/// port: poll() follows each step of the machine's controller.
///
///   phase     | what happens                       | next
///   ----------+------------------------------------+-----------------------------------
///   kOpening  | the machine is ready               | kRunning, or kFailed (refused)
///   kOpening  | no lease, or it cannot be enabled  | kFailed
///   kRunning  | an order is done                   | kRunning, kDone after the last
///   kRunning  | pause()                            | kRunning, paused() until resume()
///   kRunning  | stop()                             | kStopping, kStopped where nothing moves
///   kRunning  | the lease is lost                  | kRunning, left() until resume() under another
///   kRunning  | somebody else stops the machine    | kStopped
///   kRunning  | an order fails, or a fault         | kFailed
///   kStopping | the machine has come to rest       | kStopped
class Run {
 public:
  /// So many notices are kept, the first ones; all are counted.
  static constexpr std::size_t kNoticesMax = 100;

  enum class Phase : std::uint8_t { kOpening, kRunning, kStopping, kDone, kStopped, kFailed };

  /// @param program, machine  outlive the run
  Run(const Program& program, control::Machine& machine);

  /// Where somebody says the machine stands. Before start().
  void declare(const Statement& statement) { declared_ = statement; }
  /// For the plan's estimate of `home`. Before start().
  void expect_homing(const Homing& homing) { homing_ = homing; }
  /// Ways of streaming devices are made so that they can be paused and slowed down; they take up to
  /// an eighth longer. Before start().
  void make_changeable() { changeable_ = true; }
  /// What conditions on the supply and the jaws ask; without it nobody tells. Before start().
  void measure_by(std::function<DriverHealth()> health) { health_ = std::move(health); }
  /// What rows that look do it with; outlives the run. Without it they are refused. Before start().
  void see_by(Eyes& eyes) { eyes_ = &eyes; }
  /// Each decision of rows with cubes, as it is made. Before start().
  void hear_decisions(std::function<void(const Decision&)> listener) {
    listener_ = std::move(listener);
  }
  /// So often a cube is grasped that is not held then; each time it is looked for anew. Then it is
  /// left where it lies, and another one is taken, as often.
  static constexpr int kGraspsMax = 3;
  /// All motions at this share (0, 1] of their speed: through the feed, where the device streams.
  /// Of one that takes whole moves see slowed() of program_part.h. Before start().
  void feed(double share) { feed_ = share; }
  /// Take the lease from whoever has it. Before start().
  void take_over() { take_over_ = true; }

  /// In a cell: what says of each planned motion whether something is in its way. Before start().
  void show_to(WayLook look) { look_ = std::move(look); }
  /// How long a motion waits for another robot to move out of its way.
  static constexpr Duration kRoomPatience = std::chrono::seconds(60);
  /// It does.
  bool waits_for_room() const { return room_since_.has_value(); }

  void start(Instant now);
  void poll(Instant now);
  void stop(Instant now);
  /// To rest on the way, or behind what cannot be interrupted; nothing new begins.
  void pause();
  void resume();
  /// Pauses behind each order, as somebody else's hold does (the lease, a late cycle); resume()
  /// then does the next one.
  void single_step(bool on) { single_step_ = on; }
  /// While paused between two orders: goes back to where the last one began, by a joint move that
  /// is planned like any other, and is paused there again; resume() then does that order anew.
  /// What an `if` decided is decided anew too.
  /// @error  kWrongState (not paused, or something is under way), kAtBeginning (nothing lies
  ///         behind it), kNotUndone (the last order was a tool's action or `home`),
  ///         kPositionUnknown (nobody knows where it began), those of RowPlanner::plan
  std::expected<void, Refusal> step_back(Instant now);

  Phase phase() const { return phase_; }
  bool paused() const { return paused_; }
  /// Why it paused by itself; nothing where a client asked for it, or it goes on.
  const std::optional<Error>& paused_by() const { return paused_by_; }
  /// The lease is lost: what moved is held, and resume() goes on once the machine has one again.
  bool left() const { return left_; }
  /// What is under way has come to rest until resume().
  bool stands_held() const;
  /// On the way that step_back() asked for; paused() all along.
  bool steps_back() const { return back_steps_ && current_.has_value(); }
  bool finished() const { return phase_ >= Phase::kDone; }
  const Plan& plan() const { return plan_; }
  /// What comes behind the order under way, as far as is known before its conditions are asked.
  const Order* next_order() const;
  std::span<const Record> records() const { return records_; }
  const std::optional<Record>& under_way() const { return current_; }
  const control::Machine& machine() const { return machine_; }
  const Program& program() const { return program_; }
  std::span<const Notice> notices() const { return notices_; }
  /// Also of those that were not kept.
  std::size_t notices_told() const { return notices_told_; }
  Instant opened_at() const { return opened_at_; }
  /// When the first order was given; nothing before.
  const std::optional<Instant>& begun_at() const { return begun_at_; }
  /// Share of the predicted duration that is behind the run, 0..1; homing counts with its bound.
  /// Time that it is held does not count.
  double progress(Instant now) const;
  /// s since the first order was given, without the time that it was held.
  double elapsed(Instant now) const;
  /// When poll() should be called next even if the machine has nothing to do.
  std::optional<Instant> next_deadline() const { return paused_ ? std::nullopt : wait_end_; }
  /// A wait for standstill or for a condition is under way: positions of each cycle count.
  bool watches() const;
  /// Why the phase is kFailed: the line (0: before the first order) and the reason.
  const std::optional<Refusal>& failure() const { return failure_; }
  /// Why the phase is kStopped; nothing where it was this run's own stop().
  const std::optional<control::StopCause>& stopped_by() const { return stopped_by_; }

 private:
  using Event = control::ControlEvent;

  void go_on(Instant now);
  void watch_view(Instant now);
  void forget_picture();
  /// Why the machine takes nothing more; nothing where it does.
  std::optional<Error> fault() const;
  void take(const Event& event, Instant now);
  void take_notice(const Error& error, Instant now);
  void take_end(const Event& event, Instant now);
  void leave(Instant now);
  void count_held(Instant now);
  void opening(Instant now);
  void begin(Instant now);
  void issue_next(Instant now);
  std::expected<void, Refusal> issue(const Order& order, Instant now);
  std::expected<void, Refusal> issue_move(Instant now);
  std::expected<void, Refusal> issue_branch(const BranchOrder& branch, Instant now);
  RowPlanner& planner();
  std::expected<bool, Refusal> sees();
  void take_sight(Instant now);
  bool handles() const;
  std::expected<void, Refusal> issue_pick(const PickOrder& pick, Instant now);
  std::expected<void, Refusal> issue_place(const PlaceOrder& place);
  std::expected<Standing, Refusal> standing() const;
  std::expected<void, Refusal> begin_tasks(std::expected<CubeRows, Refusal> rows);
  std::expected<void, Refusal> next_task(Instant now);
  std::expected<void, Refusal> tasks_done(Instant now);
  std::expected<void, Refusal> is_held(bool held, Instant now);
  void leave_out_given_up();
  void lift_from_beside();
  void decided(Decision::Kind kind, const std::optional<grasping::Cube>& cube,
               const std::optional<Error>& why = {}) const;
  Expected<bool> is_seen(const Condition& condition, Instant now);
  void look_at_wait(Instant now);
  std::expected<bool, Error> holds(const Condition& condition);
  bool settled(Instant now);
  Refusal refused(const Error& error) const;
  std::expected<void, Refusal> order_done(Instant now);
  std::expected<void, Refusal> motion_done(Instant now);
  std::expected<void, Refusal> go_home(Instant now);
  std::expected<void, Refusal> next_leg(Instant now);
  void send_first_move(const JointVector& q, double duration);
  std::expected<void, Refusal> send(const RowMotion& motion, const planning::PlannedMotion& planned,
                                    const RobotModel& limits, int line,
                                    const std::vector<LinkPair>& overlaps = {});
  void finish_order(Instant now);
  void ask(const control::CommandWhat& what);
  bool waits_for_room(const Error& error, Instant now);
  void fail(const Error& error, Instant now);
  void fail(const Refusal& refusal, Instant now);

  const Program& program_;
  control::Machine& machine_;
  const RobotModel& robot_;
  Homing homing_;
  bool changeable_ = false;
  bool take_over_ = false;
  double feed_ = 1;
  Phase phase_ = Phase::kOpening;
  Instant opened_at_{};
  std::optional<Instant> begun_at_;
  bool enabling_ = false;       ///< asked for
  bool declared_told_ = false;  ///< the declaration was given
  std::vector<Notice> notices_;
  std::size_t notices_told_ = 0;
  Plan plan_;
  std::size_t next_ = 0;
  std::optional<Record> current_;
  std::vector<Record> records_;
  std::optional<Refusal> failure_;
  std::optional<control::StopCause> stopped_by_;
  bool paused_ = false;
  std::optional<Error> paused_by_;
  bool resumes_ = false;  ///< as soon as it is held
  Instant polled_at_{};
  Duration held_{};           ///< since its first order
  Duration held_at_asked_{};  ///< .. when the order under way was given
  bool had_lease_ = false;
  bool left_ = false;
  bool searches_again_ = false;  ///< a search that the loss of the lease has ended
  bool single_step_ = false;

  std::optional<Statement> declared_;
  Start q_;                    ///< where the last order left the joints
  bool back_steps_ = false;    ///< the motion under way is a step back
  bool blind_ = false;         ///< the motion under way began nobody knows where
  std::uint32_t command_ = 0;  ///< under way
  std::unique_ptr<RowPlanner> planner_;
  std::span<const Step> rows_left_;  ///< of the order under way, behind its motion
  std::optional<HomeReturn> back_;   ///< behind the search of a `home` under way
  std::size_t leg_ = 0;              ///< of it, the next one
  std::unique_ptr<control::MotionSource> motion_;
  WayLook look_;
  std::optional<control::CommandWhat> asked_;  ///< the motion or search that was asked for last
  std::optional<Instant> room_since_;          ///< another robot is in its way
  std::optional<Instant> wait_end_;
  Eyes* eyes_ = nullptr;
  bool looks_ = false;                ///< a picture is looked at for the order under way
  bool looked_ = false;               ///< a picture was used at all
  bool watched_ = false;              ///< what comes into view is looked for
  bool watches_anew_ = true;          ///< .. the next time, beside how it is then
  std::optional<Sighting> sighting_;  ///< as long as nothing was moved on the table
  /// Of a `pick` or `place` under way: what it is made of, the next one, and whether that may
  /// begin.
  std::vector<Step> tasks_;
  std::size_t task_ = 0;
  bool task_waits_ = false;
  bool task_moves_ = false;
  bool verifies_ = false;  ///< a picture has to show whether the cube is still there
  int grasps_ = 0;
  std::optional<grasping::Cube> taken_;
  std::function<void(const Decision&)> listener_;
  bool carries_ = false;                  ///< what a `pick` has taken
  std::vector<grasping::Cube> given_up_;  ///< grasped in vain, as often as that is done
  int gave_up_ = 0;                       ///< so many in the `pick` under way
  std::optional<Sighting> beside_;        ///< as it was when that was taken, without it
  std::string camera_;                    ///< that rows look with; empty: the first
  std::vector<Vec3> released_;            ///< cubes over baskets, m in B
  std::vector<Vec3> lying_;               ///< .. and those that are seen in them
  std::optional<Vec3> released_at_;       ///< by the `place` under way
  std::function<DriverHealth()> health_;
  std::optional<JointVector> still_;  ///< where the joints are while `wait settled` looks at them
  Instant still_since_{};
};

}  // namespace sinew::program

#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "sinew/devices/statements.h"
#include "sinew/io/clock.h"
#include "sinew/runtime/cell_space.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/cycle_times.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/runtime/links/robot_link.h"
#include "sinew/runtime/records/run_recorder.h"
#include "sinew/runtime/station_view.h"

namespace sinew {
struct DeviceKind;
}  // namespace sinew

namespace sinew::runtime {

/// How a robot takes its place in a running cell.
struct StationOptions {
  std::string name;                 ///< unique in the cell
  std::optional<std::string> port;  ///< nothing: a simulated device
  SimulatedMachine simulated;
  std::optional<std::string> journal;  ///< its name; nothing is recorded without one
  std::string journal_folder;
  /// Where the last seconds before each fault are kept; empty: nowhere.
  std::string flight_folder;
  /// Where each job leaves a record; empty: in flight_folder, where the newest of all stay.
  std::string record_folder;
  bool records_jobs = false;
  /// Every byte of the wire, once the port is open; empty: nowhere.
  std::string byte_log;
  /// A simulated machine that cannot tell stands at its start when it begins, as if somebody had
  /// looked; else nothing is known of it.
  bool assumes_start = true;
  /// Of the cell, where there is more than this robot; outlives the station. Which one it is there.
  CellSpace* space = nullptr;
  std::size_t place = 0;
};

/// One robot in a thread of its own: its driver on its port, its controller, its journal. Others
/// hand commands in, and see what the last cycle left. Where the port cannot be opened or is lost,
/// it is tried again each second, and the trouble is told meanwhile.
class Station {
 public:
  /// Those who listen to events and give commands, at one time.
  static constexpr std::size_t kSlots = 64;
  /// Commands that wait for the next cycles.
  static constexpr std::size_t kMailboxMax = 128;
  static constexpr std::size_t kKeptForStops = 16;

  /// @param clock  outlives the station
  /// @error  what will not get better by waiting: a port of the wrong kind, a device that cannot be
  ///         simulated, a journal that cannot be had
  static io::IoResult<std::unique_ptr<Station>> start(RobotModel robot, StationOptions options,
                                                      const io::Clock& clock);
  /// Brings the machine to rest, records where it stands, and waits for that.
  ~Station();
  Station(const Station&) = delete;
  Station& operator=(const Station&) = delete;

  const std::string& name() const { return options_.name; }
  const io::Clock& clock() const { return clock_; }
  const RobotModel& robot() const { return robot_; }
  const StationOptions& options() const { return options_; }
  const std::string& port_name() const { return link_->name(); }
  bool simulated() const { return link_->simulated(); }
  /// What its device tells beside positions while somebody wants to know, as of when it last was
  /// ready. From any thread.
  void want_facts(bool wanted);
  std::optional<std::string> fact(std::string_view what, std::size_t joint) const;
  /// What passes over its wire; its time is the cell's.
  const WireRing& wire() const { return wire_; }
  /// Where a simulated machine that cannot tell stands when it begins, as if somebody had looked;
  /// nothing once anything was sent that moves it: from then on only looking helps.
  std::optional<JointVector> assumed_place() const;
  /// What the journal knew when the station was started; null without one.
  const JournalRecovery* recovery() const { return record_ ? &record_->recovery() : nullptr; }
  /// For people: PositionRecord::found() and note(); empty without one.
  std::string journal_found() const { return record_ ? record_->found() : std::string(); }
  std::string journal_note() const { return record_ ? record_->note() : std::string(); }

  /// @name From any thread
  /// @{
  StationView view() const;
  /// Why there is no port now, as a sentence; empty where there is one.
  std::string trouble() const;

  /// A place among those who give commands; nothing where there is none left.
  std::optional<std::uint8_t> take_slot();
  void leave_slot(std::uint8_t slot);
  /// What the events of a command are known by, > 0: `slot` gets them.
  std::uint32_t next_id(std::uint8_t slot);
  /// For the next cycle. A stop goes first, and what would have moved the machine and still waits
  /// ends with kStopped. So does what somebody gives who does not know of the last stop yet.
  /// @param stops_seen  StationView::stops as whoever gives it knows them
  /// @error kBusy: too many wait; kNotRecorded: a journal cannot be told of a motion that it does
  /// not follow
  Expected<void> post(const control::Command& command, std::uint32_t stops_seen);
  /// The view knows of every stop that was asked for: what is given from now on is behind them.
  bool stops_seen() const;
  /// What in its cell this error is about; nothing where it is about something else.
  std::optional<CellRefusal> refusal_of(const Error& error) const;
  /// The space that a command's motion needs, before it is given; true where it needs none.
  /// @error as CellSpace::ask
  Expected<void> claim(const control::Command& command);
  /// Why the last motion was refused it.
  std::optional<CellRefusal> refusal() const;
  /// A program of this robot is under way, or has ended.
  void works(bool busy);
  /// Whether a motion that is being planned would meet what does not move. @error kCellContact
  Expected<void> look(const planning::CellWay& way) const;
  /// What became of this slot's commands, and what concerns all; each once, in order.
  std::optional<control::ControlEvent> take_event(std::uint8_t slot);
  /// Events that this slot was too slow for.
  std::uint64_t dropped_events(std::uint8_t slot) const;
  /// Returns when there is something new to see, at the latest in the first cycle from `at` on or
  /// after `patience` of real time.
  void wait_for_cycle(Duration patience, std::optional<Instant> at = {}) const;

  /// Why the file of `byte_log` is not whole.
  std::optional<io::IoError> log_failure() const;
  /// What seems to be wrong with its boards while they do not answer as they should; as
  /// DeviceKind::suspicion, the most that was found.
  std::string suspicion() const;

  /// Whether what happens is recorded at all, faults too: what only shows something leaves nothing.
  void set_recorded(bool recorded) { recorded_ = recorded; }
  /// A job begins, or ends: its record, where there are such.
  /// @param place  of the record; nothing: named by program and time, in the station's folder
  void begin_record(const std::string& program, const std::optional<RecordPlace>& place = {});
  void end_record();
  /// What is kept of a fault is written now, however little is behind it.
  void end_flight();
  /// What a program looks at and decides by it, into the records.
  void record(const RunLook& look);
  /// The same of a record that somebody wants, beside that of a job.
  /// @error  a sentence: the file cannot be made
  io::IoResult<void> begin_wanted(const RecordPlace& place);
  std::optional<RecordTold> end_wanted();
  std::optional<RecordUnderWay> wanted() const;
  /// What became of records; each once.
  std::optional<RecordTold> take_record();
  /// @}

 private:
  Station(RobotModel robot, StationOptions options, const io::Clock& clock);

  io::IoResult<void> prepare();
  Expected<void> forget_port();
  io::IoResult<void> connect();
  void run();
  void turn(ControlLoop& loop, Instant& retry_at);
  bool at_rest(const control::Controller& controller) const;
  bool records() const;
  Duration retry_interval() const;
  bool take_mail(ControlLoop& loop);
  void note_cycle(const control::Controller& controller, Instant now);
  bool due(const control::Controller& controller, Instant now) const;
  void publish(const ControlLoop& loop, Instant now);
  CellStand stand(const control::Controller& controller, Instant now) const;
  bool look_around(ControlLoop& loop, Instant now);
  void watch_jog(ControlLoop& loop, Instant now);
  void deliver(const control::Outputs& outputs, Instant now);
  /// Under the mutex.
  void deliver(const control::ControlEvent& event);
  void overtaken(const control::Command& command);
  void look_for_facts(const control::Controller& controller, Instant now);
  std::unique_ptr<planning::CellWay> way_of(const control::Nudge& nudge) const;
  bool at_end(const ControlLoop& loop, Instant now) const;
  RecordPlace job_place(const std::string& program) const;

  RobotModel robot_;
  const DeviceKind& kind_;  ///< of its device
  StationOptions options_;
  const io::Clock& clock_;
  WireRing wire_;
  ByteLog log_;
  std::unique_ptr<PositionRecord> record_;
  std::mutex forgetting_;
  bool forgotten_ = false;  ///< under forgetting_
  std::optional<RobotLink> link_;
  std::unique_ptr<RunRecorder> recorder_;  ///< null: nothing is recorded
  std::atomic<bool> recorded_ = true;
  std::atomic<bool> works_ = false;  ///< a program is under way
  bool connected_ = false;           ///< of the control thread
  Instant truth_at_{};
  std::optional<Instant> closing_since_;
  Instant looked_at_{};  ///< around, for a jog
  Instant facts_at_{};
  std::vector<control::ControlEvent> undelivered_;  ///< of this cycle
  bool was_ready_ = false;
  struct Published {
    Instant at;
    control::MachineState state;
    DriverState driver;
  };
  std::optional<Published> published_;  ///< of view_, for the control thread
  static constexpr Instant kNever = Instant::max();
  mutable std::atomic<Instant> look_at_ = kNever;  ///< set under the mutex

  mutable std::mutex mutex_;
  mutable std::condition_variable cycled_;
  // All below under the mutex.
  StationView view_;
  std::string trouble_;
  std::string suspicion_;
  std::optional<io::IoError> log_failure_;
  std::uint64_t cycles_ = 0;
  CycleTimes cycles_timed_;
  std::uint32_t last_id_ = 0;
  std::uint32_t stops_ = 0;
  FixedVector<control::Command, kMailboxMax> mailbox_;
  bool moved_ = false;  ///< something was posted that moves it
  std::array<std::unique_ptr<EventQueue>, kSlots> slots_;
  bool stop_ = false;
  std::deque<RecordTold> unrecorded_;  ///< files that could not be begun
  bool facts_wanted_ = false;
  DeviceStatements statements_;

  std::thread thread_;
};

}  // namespace sinew::runtime

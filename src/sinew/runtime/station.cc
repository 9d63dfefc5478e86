#include "sinew/runtime/station.h"

#include <algorithm>

#include "sinew/control/machine_identity.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/kinds.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/runtime/commissioning_file.h"

namespace sinew::runtime {
namespace {

using control::Command;
using control::ControlEvent;

/// Of real time: how often the loop goes round where nothing comes from the device.
constexpr Duration kRestSlice = std::chrono::milliseconds(5);
/// The same where nothing moves, nobody does anything, and who gives a command wakes the loop.
constexpr Duration kIdleSlice = std::chrono::milliseconds(20);
/// While a motion is streamed the driver is asked this often whether it takes the next segment.
constexpr Duration kMovingSlice = std::chrono::milliseconds(2);
/// Of real time: what clients see of a machine that goes on as before is made anew this often.
constexpr Duration kPublishInterval = std::chrono::milliseconds(2);
/// The loop's own client, which only stops it at the end; no session has this number.
constexpr control::ClientId kNobody = ~control::ClientId{0};
/// Behind it there is something to look at.
constexpr Duration kFirstCycle = std::chrono::seconds(1);
constexpr Duration kRetry = std::chrono::seconds(1);
constexpr Duration kTruthInterval = std::chrono::milliseconds(20);
/// A machine that does not come to rest is left to itself after so long.
constexpr Duration kPatience = std::chrono::seconds(6);

constexpr std::uint32_t kSlotBits = 6;
static_assert(Station::kSlots == 1U << kSlotBits);

/// Where time is scaled, so are the limits that stand for real time of this computer.
control::ControllerSettings settings_for(const RobotModel& robot, const io::Clock& clock,
                                         bool recorded) {
  const double scale = std::max(1.0, clock.scale());
  const auto stretched = [&](Duration real) { return from_seconds(to_seconds(real) * scale); };
  control::ControllerSettings settings;
  // A scheduler that lets others go first; nothing else is done in this thread.
  settings.cycle = from_seconds(0.05 * scale);
  settings.gap = from_seconds(0.5 * scale);
  settings.lease_life = stretched(settings.lease_life);
  settings.opening_limit = stretched(robot.device.settings->opening().limit);
  settings.stop_limit = stretched(settings.stop_limit);
  settings.start_limit = stretched(settings.start_limit);
  if (recorded) settings.journal = control::journal_settings(robot);
  return settings;
}

/// Whether a command sets something in motion.
bool moves(const control::CommandWhat& what) {
  return std::holds_alternative<control::Begin>(what) ||
         std::holds_alternative<control::Home>(what) ||
         std::holds_alternative<control::Nudge>(what) ||
         std::holds_alternative<control::JogAt>(what) ||
         std::holds_alternative<control::Resume>(what) ||
         std::holds_alternative<control::UseTool>(what) ||
         std::holds_alternative<control::Service>(what);
}

control::ControllerStart start_of(const PositionRecord* record,
                                  const std::optional<JointVector>& assumed) {
  if (record != nullptr) return record->start();
  control::ControllerStart start;
  if (!assumed) return start;
  for (const double q : *assumed) {
    start.positions.push_back({PositionQuality::kCommanded, q, q, q});
  }
  return start;
}

}  // namespace

Station::Station(RobotModel robot, StationOptions options, const io::Clock& clock)
    : robot_(std::move(robot)),
      kind_(kind_of(robot_.device)),
      options_(std::move(options)),
      clock_(clock) {
  log_.keep_in(wire_);
}

io::IoResult<std::unique_ptr<Station>> Station::start(RobotModel robot, StationOptions options,
                                                      const io::Clock& clock) {
  std::unique_ptr<Station> station(new Station(std::move(robot), std::move(options), clock));
  if (const auto prepared = station->prepare(); !prepared) {
    return std::unexpected(prepared.error());
  }
  station->thread_ = std::thread([self = station.get()] { self->run(); });
  station->wait_for_cycle(kFirstCycle);
  return station;
}

io::IoResult<void> Station::prepare() {
  auto link = options_.port ? RobotLink::prepare(robot_, *options_.port, clock_, log_)
                            : RobotLink::simulate(robot_, options_.simulated, clock_, log_);
  if (!link) return std::unexpected(link.error());
  link_.emplace(std::move(*link));
  const auto connected = options_.port ? link_->connect() : io::IoResult<void>{};
  connected_ = connected.has_value();
  if (!connected) trouble_ = connected.error().sentence;
  if (options_.journal) {
    auto opened = PositionRecord::open(options_.journal_folder, *options_.journal, robot_,
                                       connected_ ? options_.port.value_or("") : "");
    // Another process that has the port has the journal that follows it.
    if (!opened) return std::unexpected(connected_ ? opened.error() : connected.error());
    record_ = std::move(*opened);
  }
  // Only now: a station that is refused the port must not empty the log of the one that has it.
  if (connected_ && !options_.byte_log.empty()) {
    auto created = ByteLog::create(options_.byte_log);
    if (!created) return std::unexpected(created.error());
    log_ = std::move(*created);
    log_.keep_in(wire_);
  }
  if (!options_.flight_folder.empty() || options_.records_jobs) {
    recorder_ = std::make_unique<RunRecorder>(
        robot_, RecorderOptions{options_.name, "sinew", options_.flight_folder}, clock_.now(),
        io::wall_time_ns());
  }
  return {};
}

Station::~Station() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  clock_.wake();
  if (thread_.joinable()) thread_.join();
}

void Station::run() {
  ControlLoop loop(robot_, link_->driver(), settings_for(robot_, clock_, record_ != nullptr),
                   start_of(record_.get(), assumed_place()), record_ ? &record_->pump() : nullptr,
                   kNobody);
  loop.look = [this](const control::Outputs& outputs, Instant now) { deliver(outputs, now); };
  loop.set_port_open(connected_);
  Instant retry_at = clock_.now() + retry_interval();
  while (true) {
    const bool mail = take_mail(loop);
    const Instant now = clock_.now();
    loop.set_wall(io::wall_time_ns());
    watch_jog(loop, now);
    loop.step(now);
    note_cycle(loop.controller(), now);
    if (mail || due(loop.controller(), now)) publish(loop, now);
    if (at_end(loop, now)) return;
    turn(loop, retry_at);
  }
}

Duration Station::retry_interval() const {
  return from_seconds(to_seconds(kRetry) * clock_.scale());
}

/// What is plugged in now has names of its own, and may be another machine than before.
io::IoResult<void> Station::connect() {
  auto connected = link_->connect();
  if (!connected || !options_.port) return connected;
  if (record_) {
    auto followed = record_->follow_port(robot_, *options_.port);
    if (!followed) link_->disconnect();
    return followed;
  }
  const std::scoped_lock lock(forgetting_);
  forgotten_ = false;
  return {};
}

/// Bytes out and in, or another try to get a port.
void Station::turn(ControlLoop& loop, Instant& retry_at) {
  const bool moves = control::may_move(loop.controller().state());
  io::IoResult<void> went{};
  if (connected_) {
    const bool idle = at_rest(loop.controller());
    link_->line().set_at_rest(idle);
    went = link_->line().turn(moves ? kMovingSlice : idle ? kIdleSlice : kRestSlice);
    if (went) return;
  } else {
    clock_.pause(kRestSlice);
    if (clock_.now() < retry_at) return;
    went = connect();
  }
  retry_at = clock_.now() + retry_interval();
  connected_ = went.has_value() && !connected_;
  loop.set_port_open(connected_);
  const std::scoped_lock lock(mutex_);
  trouble_ = went ? std::string() : went.error().sentence;
}

/// Nothing will happen before somebody gives a command. A real device is looked at more often.
bool Station::at_rest(const control::Controller& controller) const {
  if (!link_->simulated() || works_ || closing_since_) return false;
  using control::MachineState;
  const MachineState state = controller.state();
  const DriverState driver = controller.driver().state();
  const bool rests = state == MachineState::kOff || state == MachineState::kReady ||
                     state == MachineState::kHeld || state == MachineState::kFault;
  if (!rests || driver == DriverState::kMoving || driver == DriverState::kStopping) return false;
  const std::scoped_lock lock(mutex_);
  return !facts_wanted_ && mailbox_.empty();
}

/// Somebody may want a record of what leaves none by itself.
bool Station::records() const {
  return recorder_ && (recorded_ || recorder_->under_way());
}

/// Nothing moves any more and all is recorded, and somebody wants the end.
bool Station::at_end(const ControlLoop& loop, Instant now) const {
  if (!closing_since_) return false;
  const auto patience = from_seconds(to_seconds(kPatience) * std::max(1.0, clock_.scale()));
  if (now - *closing_since_ > patience) return true;
  const Driver& driver = loop.controller().driver();
  const bool busy =
      driver.state() == DriverState::kMoving || driver.state() == DriverState::kStopping;
  return !busy && !control::may_move(loop.controller().state()) && loop.recorded();
}

/// True where there was some.
bool Station::take_mail(ControlLoop& loop) {
  bool stop = false;
  bool mail = false;
  {
    const std::scoped_lock lock(mutex_);
    std::size_t taken = 0;
    while (taken < mailbox_.size()) {
      // A jog begins when it is known what is around it, and not before.
      const bool jog = std::holds_alternative<control::JogAt>(mailbox_[taken].what);
      if (jog && !loop.controller().jogs() && !look_around(loop, clock_.now())) break;
      if (!loop.post(mailbox_[taken])) break;
      ++taken;
    }
    mailbox_.drop_front(taken);
    mail = taken > 0;
    stop = stop_;
  }
  if (!stop || closing_since_) return mail;
  closing_since_ = clock_.now();
  // At rest there is nothing to stop, and some devices latch a stop.
  if (control::may_move(loop.controller().state())) loop.machine().give(control::Stop{});
  loop.begin_closing();
  return mail;
}

void Station::note_cycle(const control::Controller& controller, Instant now) {
  cycles_timed_.cycle(now);
  if (!recorder_ || !recorder_->due(now) || !records()) return;
  const ByteCount bytes = connected_ ? link_->line().count() : ByteCount{};
  recorder_->offer(sample_of(controller, bytes, connected_, now));
}

/// Whether there is something to see: an event, another state, a while later, or the time at which
/// a client wants to look.
bool Station::due(const control::Controller& controller, Instant now) const {
  const bool changed = !published_ || published_->state != controller.state() ||
                       published_->driver != controller.driver().state();
  return changed || !undelivered_.empty() || now >= look_at_.load() ||
         now - published_->at >= clock_.stretched(kPublishInterval);
}

void Station::publish(const ControlLoop& loop, Instant now) {
  const control::Controller& controller = loop.controller();
  const Driver& driver = controller.driver();
  // Where a motion has ended it stands, however lately that was looked at.
  const bool other = !published_ || published_->state != controller.state();
  published_ = {now, controller.state(), driver.state()};
  const bool look = other || now - truth_at_ >= kTruthInterval;
  std::optional<sim::Truth> truth;
  if (look) {
    truth = link_->truth();
    truth_at_ = now;
  }
  look_for_facts(controller, now);
  const DeviceFacts facts = driver.facts();
  // Boards that were stopped for a failure report less.
  std::string suspicion = kind_.suspicion != nullptr ? kind_.suspicion(driver) : std::string();
  const auto positions = controller.positions();
  const auto later = controller.later_causes();
  {
    const std::scoped_lock lock(mutex_);
    view_.at = now;
    view_.stops = stops_;
    view_.state = controller.state();
    view_.positions = FixedVector<JointPosition, kMaxJoints>(positions);
    view_.reference = controller.reference();
    view_.tool = controller.tool();
    view_.holder = controller.lease_holder(now);
    view_.latched = controller.latched();
    view_.later.clear();
    for (const control::Latched& one : later) view_.later.push_back(one);
    view_.last_stop = controller.last_stop();
    view_.feed = controller.feed();
    view_.free_drive = controller.free_drive();
    view_.task = controller.task();
    view_.progress = controller.progress();
    view_.jog = controller.jog_status();
    view_.goes_on_until = driver.goes_on_until();
    view_.brakes = driver.state() == DriverState::kStopping && !view_.goes_on_until;
    view_.homing_joint = driver.homing_joint();
    view_.health = driver.health();
    if (connected_) view_.bytes = link_->line().count();
    view_.port_open = connected_;
    if (look) view_.truth = truth;
    const double real = 1 / std::max(1.0, clock_.scale());
    view_.cycle_mean = real * to_seconds(cycles_timed_.mean);
    view_.cycle_longest = real * to_seconds(cycles_timed_.longest);
    // Whoever hears in the next cycle that the device is ready finds what made it so.
    view_.facts = facts;
    if (suspicion.size() > suspicion_.size()) suspicion_ = std::move(suspicion);
    if (const auto failure = log_.failure()) log_failure_ = failure;
    // Whoever takes an event finds what it left in the view.
    for (const ControlEvent& event : undelivered_) deliver(event);
    undelivered_.clear();
    look_at_ = kNever;
    ++cycles_;
  }
  if (options_.space != nullptr) options_.space->stands(options_.place, stand(controller, now));
  cycled_.notify_all();
}

/// Where it stands, for the others of its cell.
CellStand Station::stand(const control::Controller& controller, Instant now) const {
  CellStand stand{.joints = {}, .known = true, .sure = true};
  const auto positions = controller.positions();
  for (std::size_t j = 0; j < positions.size(); ++j) {
    const JointPosition& joint = positions[j];
    if (is_left_out(robot_, j)) continue;  // its bodies know
    stand.known = stand.known && joint.quality != PositionQuality::kLost;
    stand.sure = stand.sure && joint.quality >= PositionQuality::kCommanded;
    stand.joints.q[j] = (joint.lower + joint.upper) / 2;
    stand.joints.half[j] = (joint.upper - joint.lower) / 2;
  }
  const control::MachineState state = controller.state();
  const Driver& driver = controller.driver();
  const auto until = driver.goes_on_until();
  // A tool that closes moves no link.
  const bool tool =
      state == control::MachineState::kReady && driver.state() == DriverState::kMoving;
  const bool driven =
      (driver.state() == DriverState::kMoving && !tool) || driver.state() == DriverState::kStopping;
  stand.rests = !control::may_move(state) && !driven && !(until && *until > now);
  stand.ahead = kJogAhead * std::max(1.0, clock_.scale());
  if (!controller.jogs()) return stand;
  // Somewhere between where it is and where it was sent.
  stand.jogs = true;
  const motion::AxisStates& sent = controller.jog_setpoint();
  for (std::size_t j = 0; j < positions.size(); ++j) {
    if (is_left_out(robot_, j)) continue;
    const double lower = std::min(positions[j].lower, sent.q[j]);
    const double upper = std::max(positions[j].upper, sent.q[j]);
    stand.joints.q[j] = (lower + upper) / 2;
    stand.joints.half[j] = (upper - lower) / 2;
    stand.speeds[j] = sent.qd[j];
  }
  return stand;
}

/// What a jog has to keep out of now. False where nobody can say so at once.
bool Station::look_around(ControlLoop& loop, Instant now) {
  if (options_.space == nullptr) return true;
  CellStand here = stand(loop.controller(), now);
  here.jogs = true;
  here.rests = false;
  const auto around = options_.space->jogs(options_.place, here);
  if (!around) return false;
  loop.controller().surround_jog({around->data(), around->size()});
  looked_at_ = now;
  return true;
}

/// Others began to move meanwhile, or ended. A jog that nobody can look after comes to rest.
void Station::watch_jog(ControlLoop& loop, Instant now) {
  if (options_.space == nullptr || !loop.controller().jogs() || look_around(loop, now)) return;
  const double old = to_seconds(now - looked_at_);
  if (old > kJogAhead * std::max(1.0, clock_.scale()) / 2) loop.machine().give(control::Stop{});
}

Expected<void> Station::claim(const Command& command) {
  if (options_.space == nullptr) return {};
  std::unique_ptr<planning::CellWay> way;
  bool recovers = true;  // somebody stands beside it
  if (const auto* begin = std::get_if<control::Begin>(&command.what)) {
    if (begin->motion == nullptr) return {};
    way = begin->motion->way();
    recovers = begin->recovers;
  } else if (const auto* nudge = std::get_if<control::Nudge>(&command.what)) {
    way = way_of(*nudge);
  } else if (!std::holds_alternative<control::Home>(command.what)) {
    return {};
  }
  return options_.space->ask(options_.place, command.id, way.get(), recovers);
}

/// Null: nobody knows from where.
std::unique_ptr<planning::CellWay> Station::way_of(const control::Nudge& nudge) const {
  planning::JointArray from{};
  {
    const std::scoped_lock lock(mutex_);
    for (std::size_t j = 0; j < view_.positions.size(); ++j) {
      if (view_.positions[j].quality < PositionQuality::kCommanded) return nullptr;
      from[j] = view_.positions[j].q;
    }
  }
  if (nudge.joint >= robot_.joints.size()) return nullptr;
  planning::JointArray to = from;
  to[nudge.joint] += nudge.way;
  auto way = std::make_unique<planning::CellWay>();
  way->apart_to(from, to);
  return way;
}

/// At rest, and from the first cycle on in which the machine is ready: nobody who sees that reads
/// what was before.
void Station::look_for_facts(const control::Controller& controller, Instant now) {
  const bool ready = controller.state() == control::MachineState::kReady;
  const bool due = ready && (!was_ready_ || now - facts_at_ >= kTruthInterval);
  was_ready_ = ready;
  {
    const std::scoped_lock lock(mutex_);
    if (!facts_wanted_) {
      was_ready_ = false;
      return;
    }
  }
  if (!due) return;
  facts_at_ = now;
  DeviceStatements statements = statements_of(controller.driver(), robot_);
  const std::scoped_lock lock(mutex_);
  statements_ = std::move(statements);
}

void Station::want_facts(bool wanted) {
  {
    const std::scoped_lock lock(mutex_);
    facts_wanted_ = wanted;
    if (!wanted) statements_ = {};
  }
  clock_.wake();
}

std::optional<std::string> Station::fact(std::string_view what, std::size_t joint) const {
  const std::scoped_lock lock(mutex_);
  return statements_.of(what, joint);
}

std::optional<CellRefusal> Station::refusal_of(const Error& error) const {
  const bool met = error.code == ErrorCode::kCellContact || error.code == ErrorCode::kCellTaken;
  return met ? refusal() : std::nullopt;
}

std::optional<CellRefusal> Station::refusal() const {
  if (options_.space == nullptr) return std::nullopt;
  return options_.space->refusal(options_.place);
}

void Station::works(bool busy) {
  works_ = busy;
  clock_.wake();
  if (options_.space != nullptr) options_.space->works(options_.place, busy);
}

Expected<void> Station::look(const planning::CellWay& way) const {
  if (options_.space == nullptr) return {};
  return options_.space->look(options_.place, way);
}

void Station::deliver(const control::Outputs& outputs, Instant now) {
  if (outputs.events.empty()) return;
  if (records()) {
    for (const ControlEvent& event : outputs.events) recorder_->offer(event, now);
  }
  undelivered_.insert(undelivered_.end(), outputs.events.begin(), outputs.events.end());
}

void Station::deliver(const ControlEvent& event) {
  if (options_.space != nullptr && control::is_end(event.kind)) {
    options_.space->ended(options_.place, event.command);
  }
  const std::size_t slot = event.command & (kSlots - 1);
  for (std::size_t k = 0; k < kSlots; ++k) {
    const bool meant = event.command == 0 || k == slot;
    if (slots_[k] && meant) slots_[k]->push(event);
  }
}

void Station::overtaken(const Command& command) {
  deliver({.kind = ControlEvent::Kind::kStopped,
           .command = command.id,
           .state = view_.state,
           .cause = control::StopCause::kClient,
           .error = {},
           .lease = {}});
}

std::optional<JointVector> Station::assumed_place() const {
  const std::scoped_lock lock(mutex_);
  const bool assumed = options_.assumes_start && link_->simulated() && !record_ &&
                       robot_.device.settings->counts_from_power_up() && !moved_;
  return assumed ? std::optional(home_joints(robot_)) : std::nullopt;
}

StationView Station::view() const {
  const std::scoped_lock lock(mutex_);
  return view_;
}

std::string Station::trouble() const {
  const std::scoped_lock lock(mutex_);
  return trouble_;
}

std::optional<io::IoError> Station::log_failure() const {
  const std::scoped_lock lock(mutex_);
  return log_failure_;
}

std::string Station::suspicion() const {
  const std::scoped_lock lock(mutex_);
  return suspicion_;
}

std::optional<std::uint8_t> Station::take_slot() {
  auto queue = std::make_unique<EventQueue>();
  const std::scoped_lock lock(mutex_);
  const auto free = std::ranges::find_if(slots_, [](const auto& slot) { return !slot; });
  if (free == slots_.end()) return std::nullopt;
  *free = std::move(queue);
  return static_cast<std::uint8_t>(free - slots_.begin());
}

void Station::leave_slot(std::uint8_t slot) {
  std::unique_ptr<EventQueue> queue;  // freed outside of the lock
  const std::scoped_lock lock(mutex_);
  queue = std::move(slots_[slot]);
}

std::uint32_t Station::next_id(std::uint8_t slot) {
  const std::scoped_lock lock(mutex_);
  // Behind some 67 million commands the numbers begin again; by then the first ones have ended.
  last_id_ = (last_id_ + 1) & ((1U << (32 - kSlotBits)) - 1);
  if (last_id_ == 0) last_id_ = 1;
  return (last_id_ << kSlotBits) | slot;
}

/// Before this station moves a machine that some journal follows, and none of its own.
Expected<void> Station::forget_port() {
  if (record_ || !options_.port || options_.journal_folder.empty()) return {};
  const std::scoped_lock lock(forgetting_);
  if (!forgotten_) {
    forgotten_ = runtime::forget_port(options_.journal_folder, *options_.port, robot_).has_value();
  }
  if (forgotten_) return {};
  return std::unexpected(Error{ErrorCode::kNotRecorded});
}

Expected<void> Station::post(const Command& command, std::uint32_t stops_seen) {
  if (moves(command.what)) {
    if (const auto forgotten = forget_port(); !forgotten) {
      if (options_.space != nullptr) options_.space->ended(options_.place, command.id);
      return forgotten;
    }
  }
  const std::scoped_lock lock(mutex_);
  const bool stops = std::holds_alternative<control::Stop>(command.what);
  moved_ = moved_ || moves(command.what);
  if (stops) {
    ++stops_;
    std::size_t kept = 0;
    for (const Command& one : mailbox_) {
      if (moves(one.what)) {
        overtaken(one);
      } else {
        mailbox_[kept++] = one;
      }
    }
    mailbox_.resize(kept);
  } else if (moves(command.what) && stops_seen != stops_) {
    overtaken(command);
    return {};
  }
  const std::size_t room = stops ? kMailboxMax : kMailboxMax - kKeptForStops;
  if (mailbox_.size() >= room) {
    if (options_.space != nullptr) options_.space->ended(options_.place, command.id);
    return std::unexpected(Error{ErrorCode::kBusy});
  }
  mailbox_.push_back(command);
  if (stops) std::rotate(mailbox_.begin(), mailbox_.end() - 1, mailbox_.end());
  clock_.wake();
  return {};
}

bool Station::stops_seen() const {
  const std::scoped_lock lock(mutex_);
  return view_.stops == stops_;
}

std::optional<ControlEvent> Station::take_event(std::uint8_t slot) {
  const std::scoped_lock lock(mutex_);
  return slots_[slot] ? slots_[slot]->take() : std::nullopt;
}

std::uint64_t Station::dropped_events(std::uint8_t slot) const {
  const std::scoped_lock lock(mutex_);
  return slots_[slot] ? slots_[slot]->dropped() : 0;
}

void Station::wait_for_cycle(Duration patience, std::optional<Instant> at) const {
  std::unique_lock lock(mutex_);
  if (at && *at < look_at_.load()) look_at_ = *at;
  const std::uint64_t before = cycles_;
  cycled_.wait_for(lock, patience, [&] { return cycles_ != before; });
}

RecordPlace Station::job_place(const std::string& program) const {
  const std::int64_t now = io::wall_time_ns();
  if (options_.record_folder.empty()) {
    return run_place(options_.flight_folder, options_.name, program, now);
  }
  return {options_.record_folder, record_name(options_.name, program, now), program};
}

void Station::begin_record(const std::string& program, const std::optional<RecordPlace>& wanted) {
  if (!recorder_ || !options_.records_jobs) return;
  const RecordPlace place = wanted ? *wanted : job_place(program);
  const auto begun = recorder_->begin(place);
  if (begun) return;
  const std::scoped_lock lock(mutex_);
  unrecorded_.push_back({place.folder + "/" + place.name, {}, begun.error().sentence, 0, false});
}

void Station::end_record() {
  if (recorder_) recorder_->end();
}

void Station::record(const RunLook& look) {
  if (records()) recorder_->add(look);
}

void Station::end_flight() {
  if (recorder_) recorder_->end_flight();
}

io::IoResult<void> Station::begin_wanted(const RecordPlace& place) {
  if (!recorder_) return std::unexpected(io::IoError{"this cell keeps no records"});
  return recorder_->begin(place, RecordSlot::kWanted);
}

std::optional<RecordTold> Station::end_wanted() {
  return recorder_ ? recorder_->end(RecordSlot::kWanted) : std::nullopt;
}

std::optional<RecordUnderWay> Station::wanted() const {
  return recorder_ ? recorder_->under_way() : std::nullopt;
}

std::optional<RecordTold> Station::take_record() {
  if (!recorder_) return std::nullopt;
  if (auto told = recorder_->take_told()) return told;
  const std::scoped_lock lock(mutex_);
  if (unrecorded_.empty()) return std::nullopt;
  RecordTold told = std::move(unrecorded_.front());
  unrecorded_.pop_front();
  return told;
}

}  // namespace sinew::runtime

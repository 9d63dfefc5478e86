#include "sinew/runtime/procedure_runner.h"

#include <algorithm>
#include <utility>

#include "sinew/io/file.h"
#include "sinew/runtime/homing_time.h"

namespace sinew::runtime {

using program::Procedure;

namespace {

constexpr Duration kPatience = std::chrono::milliseconds(20);
constexpr const char* kCommission = "commission";

}  // namespace

ProcedureRunner::ProcedureRunner(Station& station, const io::Clock& clock, ResultsPlace place)
    : station_(station), clock_(clock), place_(std::move(place)) {}

ProcedureRunner::~ProcedureRunner() {
  cancel();
  while (!over()) {
    station_.wait_for_cycle(kPatience);
    poll();
  }
}

std::expected<program::ProcedurePlan, std::string> ProcedureRunner::plan_for(
    const std::string& kind) const {
  const RobotModel& robot = station_.robot();
  const program::Homing homing = homing_of(robot);
  const program::DeviceFact fact = [&station = station_](std::string_view what, std::size_t joint) {
    return station.fact(what, joint);
  };
  if (kind == "home") return program::homing_procedure(robot, homing, fact);
  if (kind == "recover") return program::recovery_procedure(robot, homing);
  if (!place_.settings.empty()) {
    return std::unexpected("it runs with what commissioning found (" + place_.settings +
                           "), and is commissioned as its own file says: leave `settings` out of "
                           "the cell's file first");
  }
  return program::commissioning_procedure(robot, homing, fact);
}

std::expected<CommissioningFile, std::string> ProcedureRunner::read_before() const {
  if (place_.file.empty()) return CommissioningFile{};
  CommissioningFile before;
  if (io::exists(place_.file)) {
    auto read = read_commissioning(place_.file, station_.robot());
    if (!read) return std::unexpected(read.error() + "; move it away, it is not replaced");
    before = std::move(*read);
  }
  if (const auto place = check_commissioning_place(place_.file); !place) {
    return std::unexpected(place.error().sentence);
  }
  return before;
}

std::expected<void, std::string> ProcedureRunner::start(const ProcedureOrder& order,
                                                        control::ClientId client) {
  if (!over()) return std::unexpected("'" + status_.view.title + "' is under way on this robot");
  auto plan = plan_for(order.kind);
  if (!plan) return std::unexpected(plan.error());
  before_ = {};
  if (order.kind == kCommission) {
    auto before = read_before();
    if (!before) return std::unexpected(before.error());
    before_ = std::move(*before);
    if (order.anew) before_.under_way.clear();
  }
  auto made = StationClient::make(station_, client);
  if (!made) return std::unexpected("too many clients steer this robot");
  station_.want_facts(true);
  client_ = std::move(*made);
  procedure_ = std::make_unique<Procedure>(std::move(*plan), *client_);
  for (const auto& [id, result] : before_.under_way) procedure_->keep(id, result);
  if (order.take_over) procedure_->take_over();
  if (const auto assumed = station_.assumed_place()) procedure_->assume(*assumed);
  procedure_->explain_by([&station = station_](const Error& error) -> std::optional<std::string> {
    const auto in_the_way = station.refusal_of(error);
    return in_the_way ? std::optional(in_the_way->sentence()) : std::nullopt;
  });
  const std::uint32_t number = status_.number + 1;
  status_ = {};
  status_.number = number;
  status_.client = client;
  status_.over = false;
  kept_ = false;
  procedure_->start(clock_.now());
  publish();
  return {};
}

void ProcedureRunner::go_on(control::ClientId client, bool take_over) {
  if (!procedure_) return;
  client_->refresh();
  client_->act_for(client);
  status_.client = client;
  ++status_.answers;
  kept_ = false;
  procedure_->rejoin(take_over);
  publish();
}

std::expected<void, std::string> ProcedureRunner::taken(std::expected<void, std::string> what) {
  if (what) ++status_.answers;
  publish();
  return what;
}

std::expected<void, std::string> ProcedureRunner::answer(std::string_view text) {
  if (!procedure_) return std::unexpected("no procedure is under way on this robot");
  return taken(procedure_->answer(text, clock_.now()));
}

std::expected<void, std::string> ProcedureRunner::back() {
  if (!procedure_) return std::unexpected("no procedure is under way on this robot");
  return taken(procedure_->back(clock_.now()));
}

void ProcedureRunner::cancel() {
  if (procedure_) procedure_->cancel(clock_.now());
}

void ProcedureRunner::poll() {
  if (!procedure_) return;
  client_->refresh();
  procedure_->poll(clock_.now());
  publish();
  if (procedure_->left() && !kept_) keep_results();
  // The controller looks at the motion until its command has ended.
  if (!procedure_->finished() || client_->motion_in_use()) return;
  // Whoever hears that it is over may begin something, and its own stop must not end that.
  if (!station_.stops_seen()) return;
  // What it moved comes to rest; what somebody else moves by now is not its own.
  const StationView& seen = client_->view();
  const bool others = seen.holder && seen.holder->client != status_.client;
  if (control::may_move(seen.state) && !others) return;
  keep_results();
  station_.want_facts(false);
  procedure_.reset();
  client_.reset();
  status_.over = true;
}

void ProcedureRunner::publish() {
  status_.view = program::view_of(*procedure_, clock_.now());
  const StationView& seen = client_->view();
  const bool moves = seen.state == control::MachineState::kMoving ||
                     seen.state == control::MachineState::kRecovering;
  if (moves && status_.view.joint) status_.view.share = std::clamp(seen.progress, 0.0, 1.0);
}

/// Settings count when the list has come to its end; answers are kept however it ended, and while
/// it waits for another client.
void ProcedureRunner::keep_results() {
  kept_ = true;
  if (procedure_->plan().id != kCommission || place_.file.empty()) return;
  const auto [file, misfit] = results_of(*procedure_, before_);
  status_.note = misfit;
  const bool counts = procedure_->phase() == Procedure::Phase::kDone && misfit.empty();
  if (counts) status_.settings = file.settings;
  const auto kept = write_commissioning(place_.file, station_.robot(), file);
  if (kept) {
    status_.file = place_.file;
  } else {
    status_.note = kept.error().sentence;
  }
}

}  // namespace sinew::runtime

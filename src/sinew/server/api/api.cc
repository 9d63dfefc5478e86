#include "sinew/server/api/api.h"

#include <algorithm>
#include <utility>

#include "sinew/io/clock.h"
#include "sinew/model/error_sentence.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

using control::ControlEvent;
using runtime::JobView;
using runtime::StationClient;

constexpr Duration kRenewal = std::chrono::milliseconds(100);
constexpr Duration kJobInterval = std::chrono::milliseconds(100);
/// Who is told something more often than this wants poll() more often, too.
constexpr Duration kSeldom = std::chrono::milliseconds(60);
/// A message with a stop or a hold is no longer than this.
constexpr std::size_t kStopMax = 1024;  // bytes

/// What stops goes past everything that waits.
bool may_stop(std::string_view text) {
  return text.size() <= kStopMax && (text.find("robot.stop") != std::string_view::npos ||
                                     text.find("robot.hold") != std::string_view::npos);
}

bool stops(MethodId id) {
  return id == MethodId::kRobotStop || id == MethodId::kRobotHold;
}

/// What may set a robot in motion.
bool begins(MethodId id) {
  switch (id) {
    case MethodId::kRobotResume:
    case MethodId::kRobotJog:
    case MethodId::kRobotNudge:
    case MethodId::kProgramRun:
    case MethodId::kRobotRide:
    case MethodId::kProgramStep:
    case MethodId::kProcedureStart:
    case MethodId::kProcedureAnswer:
      return true;
    default:
      return false;
  }
}

std::int64_t wall_ms() {
  return io::wall_time_ns() / 1'000'000;
}

/// What of an event concerns everybody; nothing where it does not.
std::optional<Json> event_json(const std::string& robot, const ControlEvent& event,
                               const RobotModel& model) {
  Json json{{"at_ms", wall_ms()}, {"robot", robot}};
  using Kind = ControlEvent::Kind;
  switch (event.kind) {
    case Kind::kState:
      json["kind"] = "state";
      json["state"] = control::name(event.state);
      return json;
    case Kind::kLease:
      json["kind"] = "lease";
      json["client"] = event.lease.epoch != 0 ? Json(event.lease.client) : Json(nullptr);
      return json;
    case Kind::kStop:
      json["kind"] = "stop";
      json["cause"] = cause_name(event.cause);
      if (const auto category = category_number(event.cause)) json["category"] = *category;
      return json;
    case Kind::kLatched:
      json["kind"] = "fault";
      json.update(latched_json({event.cause, event.error}, model));
      return json;
    case Kind::kNotice:
      json["kind"] = "notice";
      json["error"] = error_json(event.error, model);
      return json;
    default:
      return std::nullopt;
  }
}

Json record_json(const std::string& robot, const runtime::RecordTold& told) {
  Json json{{"at_ms", wall_ms()},
            {"robot", robot},
            {"kind", "record"},
            {"path", told.path},
            {"lost", told.lost}};
  if (told.fault) json["cause"] = cause_name(*told.fault);
  if (!told.trouble.empty()) json["trouble"] = told.trouble;
  if (told.full) json["full"] = true;
  return json;
}

}  // namespace

Api::Api(runtime::RunningCell& cell, std::string version, runtime::CellSettings* settings,
         const std::string& event_file)
    : cell_(cell), keeper_(cell, settings), calibrations_(cell), version_(std::move(version)) {
  previews_ = std::make_unique<PreviewDesk>(cell_);
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    ears_.push_back(cell_.station(i).take_slot());
    tools_.push_back(std::make_unique<planning::ToolSpace>(cell_.station(i).robot()));
    X_near_.push_back(tools_.back()->home());
    jaws_.emplace_back();
  }
  jobs_.resize(cell_.size());
  models_.resize(cell_.size());
  procedures_.resize(cell_.size());
  monitors_.resize(cell_.size());
  stopped_.resize(cell_.size());
  status_texts_.resize(cell_.size() + 1);
  if (!event_file.empty()) begin_events(event_file);
}

/// Of the lives before this one, and that this one has begun.
void Api::begin_events(const std::string& file) {
  auto kept = EventFile::open(file);
  if (kept) {
    log_.begin(kept->events);
    event_kept_ = log_.last();
    event_file_ = std::make_shared<EventFile>(std::move(kept->file));
  }
  log_.add({{"at_ms", wall_ms()}, {"robot", ""}, {"kind", "begun"}, {"version", version_}});
  if (!kept) {
    log_.add({{"at_ms", wall_ms()},
              {"robot", ""},
              {"kind", "begun"},
              {"trouble", kept.error().sentence}});
  }
}

/// In the thread that waits for disks; where its desk is full, with the next ones.
void Api::keep_events() {
  if (!event_file_ || log_.last() == event_kept_) return;
  std::vector<std::string> lines;
  for (const auto& event : log_.after(event_kept_)) lines.push_back(event.text);
  const bool taken = files_.ask({0, nullptr, false}, [file = event_file_, lines] {
    file->add(lines);
    return std::string();
  });
  if (!taken) return;
  ++asked_;
  event_kept_ = log_.last();
}

Api::~Api() {
  while (!sessions_.empty()) close(sessions_.begin()->first);
  for (std::size_t i = 0; i < ears_.size(); ++i) {
    if (ears_[i]) cell_.station(i).leave_slot(*ears_[i]);
  }
}

std::optional<SessionId> Api::open(Role role, Delivery delivery) {
  if (sessions_.size() >= kSessionsMax) return std::nullopt;
  Session& session = sessions_[++last_session_];
  session.id = last_session_;
  session.role = role;
  session.delivery = delivery;
  session.watch.jobs.resize(cell_.size());
  session.watch.procedures.resize(cell_.size());
  return last_session_;
}

void Api::close(SessionId id) {
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return;
  finish_inbox(found->second);
  take_events(found->second);
  for (auto& [robot, machine] : found->second.machines) {
    const JobView job = cell_.jobs(robot).view();
    const bool runs = job.client == id && !job.over;
    // A program belongs to the controller; a demonstration gives way.
    if (runs && yielding_ == id) cell_.jobs(robot).stop(job.id);
    const bool continues =
        runs && yielding_ != id && on_client_loss(robot) == ClientLoss::kContinue;
    if (machine->lease().epoch != 0 && !continues) machine->give(control::ReturnLease{});
  }
  asked_ -= previews_->forget(id);
  out_bytes_ -= found->second.out_bytes;
  sessions_.erase(found);
  if (yielding_ != id) return;
  yielding_.reset();
  log_demonstration();
}

ClientLoss Api::on_client_loss(std::size_t robot) const {
  return cell_.cell().robots[robot].on_client_loss;
}

bool Api::holds(SessionId id) const {
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return false;
  return std::ranges::any_of(found->second.machines, [&](const auto& one) {
    const JobView job = cell_.jobs(one.first).view();
    return one.second->lease().epoch != 0 || (job.client == id && !job.over);
  });
}

void Api::yield(SessionId session) {
  yielding_ = session;
  log_demonstration();
}

void Api::log_demonstration() {
  log_.add({{"at_ms", wall_ms()},
            {"robot", ""},
            {"kind", "demonstration"},
            {"runs", yielding_.has_value()}});
}

void Api::give_way(const Method& method, SessionId session) {
  const bool interferes = (method.moves && !is_about_kept(method.id)) || stops(method.id);
  if (yielding_ && *yielding_ != session && interferes) close(*yielding_);
}

void Api::receive(SessionId id, std::string_view text, Instant now) {
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return;
  Session& session = found->second;
  renew(session, now);
  const std::uint64_t number = ++messages_;
  if (may_stop(text) && session.pending.size() < kPendingMax) {
    const auto request = read_request(text);
    if (request && (request->method == "robot.stop" || request->method == "robot.hold")) {
      return handle(session, request, number, now);
    }
  }
  session.inbox.push_back({std::string(text), number});
  session.inbox_bytes += text.size();
  ++inbox_;
}

bool Api::has_room(SessionId id) const {
  const auto found = sessions_.find(id);
  return found != sessions_.end() && found->second.inbox.size() < kInboxMax &&
         found->second.inbox_bytes < kInboxBytesMax;
}

bool Api::settled(SessionId id) const {
  const auto found = sessions_.find(id);
  return found == sessions_.end() || found->second.inbox.empty();
}

/// What a client wanted to have changed is done, also where it did not wait for the answer.
void Api::finish_inbox(Session& session) {
  for (const Message& message : std::exchange(session.inbox, {})) {
    --inbox_;
    const auto request = read_request(message.text);
    if (!request) continue;
    const auto method = check(*request);
    if (method && (*method)->moves) handle(session, request, message.number, Instant{});
  }
}

/// A jog does not wait for those who only look; they do not wait for ever.
Api::Session* Api::next_session() {
  holder_first_ = !holder_first_;
  Session* first = nullptr;
  Session* next = nullptr;
  for (auto& [id, session] : sessions_) {
    if (session.inbox.empty()) continue;
    const bool holder = std::ranges::any_of(
        session.machines, [](const auto& one) { return one.second->lease().epoch != 0; });
    if (holder && !holder_first_) return &session;
    if (first == nullptr) first = &session;
    if (next == nullptr && id > served_) next = &session;
  }
  if (next == nullptr) next = first;
  if (next != nullptr) served_ = next->id;
  return next;
}

bool Api::work(Instant now) {
  if (inbox_ == 0) return false;
  Session* session = next_session();
  const Message message = std::move(session->inbox.front());
  session->inbox.pop_front();
  session->inbox_bytes -= message.text.size();
  --inbox_;
  handle(*session, read_request(message.text), message.number, now);
  return inbox_ > 0;
}

bool Api::hurries() const {
  if (inbox_ > 0 || asked_ > 0) return true;
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    const runtime::ProcedureRunner& procedures = cell_.procedures(i);
    if (!procedures.over() && !procedures.status().view.left) return true;
  }
  return std::ranges::any_of(sessions_, [](const auto& one) {
    const Session& session = one.second;
    const Duration told = session.watch.interval, updated = session.subscription.interval;
    return !session.pending.empty() || (told != Duration{} && told < kSeldom) ||
           (updated != Duration{} && updated < kSeldom);
  });
}

/// What was asked for before a stop, and would begin to move its robot behind it.
bool Api::overtaken(const Method& method, const Call& call, std::uint64_t number) const {
  return call.robot && begins(method.id) && number < stopped_[*call.robot];
}

void Api::handle(Session& session, const std::expected<RpcRequest, BadRequest>& request,
                 std::uint64_t number, Instant now) {
  if (!request) return put(session, error_text(request.error().id, request.error().error));
  const auto method = check(*request);
  if (!method) return answer(session, request->id, request->answered, method.error());
  if ((*method)->moves && session.role == Role::kViewer) {
    return answer(
        session, request->id, request->answered,
        RpcError{RpcCode::kRefused, "viewers watch and may stop; this is for operators", nullptr});
  }
  Call one{session, *request, now, std::nullopt};
  if (const auto name = request->params.find("robot"); name != request->params.end()) {
    one.robot = cell_.find(name->get_ref<const std::string&>());
    if (!one.robot) {
      std::string names;
      for (const CellRobot& robot : cell_.cell().robots) {
        names += (names.empty() ? "" : ", ") + robot.name;
      }
      return answer(session, request->id, request->answered,
                    RpcError{RpcCode::kInvalidParams,
                             "no robot of this cell has that name; there are " + names, nullptr});
    }
  }
  if (stops((*method)->id)) {
    for (std::size_t i = 0; i < stopped_.size(); ++i) {
      if (!one.robot || *one.robot == i) stopped_[i] = number;
    }
  }
  give_way(**method, session.id);
  if (overtaken(**method, one, number)) {
    return answer(session, request->id, request->answered,
                  RpcError{RpcCode::kStopped,
                           "stopped: a stop or a hold of this robot came behind it",
                           {{"cause", cause_name(control::StopCause::kClient)}}});
  }
  answer(session, request->id, request->answered, call(**method, one));
}

void Api::answer(Session& session, const Json& id, bool answered, const Answer& what) {
  if (const auto* later = std::get_if<Later>(&what)) {
    for (Pending pending : later->commands) {
      pending.id = id;
      pending.answered = answered;
      session.pending.push_back(std::move(pending));
    }
    return;
  }
  if (const auto* elsewhere = std::get_if<Elsewhere>(&what)) {
    if (previews_->ask({session.id, id, answered}, elsewhere->wish)) {
      ++asked_;
      return;
    }
    if (!answered) return;
    return put(session, error_text(id, {RpcCode::kBusy, "too many previews wait", nullptr}));
  }
  if (const auto* errand = std::get_if<Errand>(&what)) {
    if (errand->desk.ask({session.id, id, answered}, errand->task)) {
      ++asked_;
      return;
    }
    if (!answered) return;
    return put(session, error_text(id, {RpcCode::kBusy, "too many requests wait", nullptr}));
  }
  if (!answered) return;
  if (const auto* result = std::get_if<Json>(&what)) return put(session, result_text(id, *result));
  if (const auto* text = std::get_if<Text>(&what)) {
    return put(session, result_of_text(id, text->json));
  }
  put(session, error_text(id, std::get<RpcError>(what)));
}

void Api::put(Session& session, std::string text) {
  if (session.out.size() >= kOutputMax || session.out_bytes > kOutputBytesMax) {
    session.too_slow = true;
    return;
  }
  session.out_bytes += text.size();
  out_bytes_ += text.size();
  session.out.push_back(std::move(text));
  if (out_bytes_ > kOutputAllMax) cut_off_largest();
}

void Api::cut_off_largest() {
  Session& largest = std::ranges::max_element(sessions_, {}, [](const auto& one) {
                       return one.second.out_bytes;
                     })->second;
  largest.too_slow = true;
  out_bytes_ -= std::exchange(largest.out_bytes, 0);
  largest.out.clear();
}

std::optional<std::string> Api::take_output(SessionId id) {
  const auto found = sessions_.find(id);
  if (found == sessions_.end() || found->second.out.empty()) return std::nullopt;
  std::string text = std::move(found->second.out.front());
  found->second.out.pop_front();
  found->second.out_bytes -= text.size();
  out_bytes_ -= text.size();
  return text;
}

bool Api::too_slow(SessionId id) const {
  const auto found = sessions_.find(id);
  return found != sessions_.end() && found->second.too_slow;
}

std::expected<StationClient*, RpcError> Api::machine(Session& session, std::size_t robot) {
  auto& machine = session.machines[robot];
  if (machine) return machine.get();
  auto made = StationClient::make(cell_.station(robot), session.id);
  if (!made) {
    session.machines.erase(robot);
    return std::unexpected(RpcError{RpcCode::kBusy, "too many clients steer this robot", nullptr});
  }
  machine = std::move(*made);
  return machine.get();
}

/// Whoever speaks is alive, and so are its leases.
void Api::renew(Session& session, Instant now) {
  if (session.renewed && now - *session.renewed < kRenewal) return;
  session.renewed = now;
  for (auto& [robot, machine] : session.machines) {
    if (machine->lease().epoch != 0) machine->give(control::RenewLease{});
  }
}

void Api::take_answered() {
  while (const auto done = previews_->take()) take_answered(*done);
  while (const auto done = files_.take()) take_answered(*done);
  while (const auto done = checks_.take()) take_answered(*done);
  while (const auto done = pictures_.take()) take_answered(*done);
  while (const auto done = verdicts_.take()) take_answered(*done);
  while (const auto done = moves_.take()) take_answered(*done);
  while (const auto done = calibrating_.take()) take_answered(*done);
  while (const auto done = wires_.take()) take_answered(*done);
}

void Api::take_answered(const Answered& done) {
  --asked_;
  const auto found = sessions_.find(done.ticket.client);
  if (found == sessions_.end() || !done.ticket.answered) return;
  put(found->second, done.result ? result_of_text(done.ticket.id, *done.result)
                                 : error_text(done.ticket.id, done.result.error()));
}

void Api::poll(Instant now) {
  poll_procedures();
  take_answered();
  log_events();
  log_jobs();
  keep_events();
  forget_wires(now);
  for (std::string& text : status_texts_) text.clear();
  for (auto& [id, session] : sessions_) {
    take_events(session);
    if (session.out.size() < kOutputSlow) tell_objects(session, now);
    tell(session, now);
  }
}

void Api::take_events(Session& session) {
  for (auto& [robot, machine] : session.machines) {
    machine->refresh();
    while (const auto event = machine->take_event()) {
      const auto found =
          std::ranges::find_if(session.pending, [&, at = robot](const Pending& pending) {
            return pending.robot == at && pending.command == event->command;
          });
      if (event->command == 0 || found == session.pending.end()) continue;
      const bool answers =
          is_end(event->kind) || (found->at_start && event->kind == ControlEvent::Kind::kStarted);
      if (!answers) continue;
      const Pending pending = *found;
      session.pending.erase(found);
      settle(session, pending, *event);
    }
  }
}

/// What was said, what was known before, and what became of it.
void Api::log_statement(const Pending& pending, const ControlEvent& event) {
  if (pending.statement.is_null()) return;
  Json told = pending.statement;
  told["at_ms"] = io::wall_time_ns() / 1'000'000;
  if (event.kind == ControlEvent::Kind::kRefused || event.kind == ControlEvent::Kind::kFailed) {
    told["kind"] = "declaration_refused";
    told["trouble"] = refusal(RpcCode::kRefused, event.error, pending.robot).message;
  }
  log_.add(told);
}

void Api::settle(Session& session, const Pending& pending, const ControlEvent& event) {
  log_statement(pending, event);
  // One answer for all robots of a request.
  const bool more = std::ranges::any_of(
      session.pending, [&](const Pending& other) { return other.group == pending.group; });
  if (more || !pending.answered) return;
  using Kind = ControlEvent::Kind;
  if (event.kind == Kind::kRefused) {
    return put(session,
               error_text(pending.id, refusal(RpcCode::kRefused, event.error, pending.robot)));
  }
  if (event.kind == Kind::kFailed) {
    return put(session,
               error_text(pending.id, refusal(RpcCode::kFailed, event.error, pending.robot)));
  }
  if (event.kind == Kind::kStopped) {
    return put(session, error_text(pending.id, {RpcCode::kStopped,
                                                "stopped: " + std::string(cause_name(event.cause)),
                                                {{"cause", cause_name(event.cause)}}}));
  }
  Json result = Json::object();
  if (pending.epoch) {
    result["epoch"] = session.machines.at(pending.robot)->lease().epoch;
    result["client"] = session.machines.at(pending.robot)->lease().client;
  }
  put(session, result_text(pending.id, result));
}

RpcError Api::refusal(RpcCode code, const Error& error, std::size_t robot) const {
  const RobotModel& model = cell_.station(robot).robot();
  RpcError refused{code, sentence_of(error, model), error_json(error, model)};
  if (const auto in_the_way = cell_.station(robot).refusal_of(error)) {
    put_in_the_way(refused.data, *in_the_way);
    refused.message = in_the_way->sentence();
  }
  return refused;
}

void Api::log_events() {
  for (std::size_t i = 0; i < ears_.size(); ++i) {
    if (!ears_[i]) continue;
    runtime::Station& station = cell_.station(i);
    // A demonstration goes on for days: that it moves its robots is no news.
    const bool shows = yielding_ && cell_.jobs(i).view().client == *yielding_;
    while (const auto event = station.take_event(*ears_[i])) {
      const bool usual =
          event->kind == ControlEvent::Kind::kState || event->kind == ControlEvent::Kind::kLease;
      if (shows && usual) continue;
      if (auto json = event_json(station.name(), *event, station.robot())) {
        log_.add(std::move(*json));
      }
    }
    while (const auto told = station.take_record()) log_.add(record_json(station.name(), *told));
  }
}

bool Api::same(const JobView& a, const JobView& b) {
  return a.id == b.id && a.over == b.over && phase_name(a) == phase_name(b) && a.line == b.line &&
         a.planned == b.planned && a.orders_done == b.orders_done && a.notices == b.notices &&
         a.waits_for_room == b.waits_for_room && a.client == b.client &&
         a.client_lost == b.client_lost && a.guard == b.guard;
}

/// The life of each job, a row where its phase changes.
void Api::log_jobs() {
  for (std::size_t i = 0; i < jobs_.size(); ++i) {
    const JobView now = cell_.jobs(i).view();
    const JobView& before = jobs_[i];
    const bool shows = yielding_ && now.client == *yielding_ && !now.failure;
    // A plan that was begun, or refused, between two looks was made all the same.
    JobView planned = now;
    planned.begun = false;
    planned.phase = program::Run::Phase::kRunning;
    planned.paused = planned.over = false;
    planned.failure.reset();
    const bool new_plan = now.planned && (now.id != before.id || !before.planned);
    if (new_plan && !shows && phase_name(now) != phase_name(planned)) log_job(i, planned);
    const bool changed =
        now.id != before.id || now.over != before.over || phase_name(now) != phase_name(before);
    if (changed && now.id != 0 && !shows) log_job(i, now);
    jobs_[i] = now;
  }
}

void Api::log_job(std::size_t robot, const JobView& job) {
  const runtime::Station& station = cell_.station(robot);
  const Json told = job_json(station.name(), job, station.robot());
  Json json{{"at_ms", wall_ms()}, {"robot", station.name()}, {"kind", "job"}};
  for (const char* key : {"job", "title", "phase", "over", "predicted_s", "limited", "error"}) {
    if (told.contains(key)) json[key] = told[key];
  }
  log_.add(std::move(json));
}

Json Api::status(std::size_t robot) {
  const runtime::Station& station = cell_.station(robot);
  const runtime::StationView view = station.view();
  if (jaws_[robot] != view.tool.jaws) {
    jaws_[robot] = view.tool.jaws;
    *tools_[robot] = planning::ToolSpace(station.robot(), jaws_[robot]);
  }
  Json json = status_json(station, view, *tools_[robot], X_near_[robot]);
  json["kept"] = keeper_.changes();
  if (const auto record = station.wanted()) {
    json["recording"] = {
        {"record", record->name}, {"length_s", record->length}, {"size_bytes", record->size}};
  }
  const JobView job = cell_.jobs(robot).view();
  if (job.id != 0) json["job"] = job_json(station.name(), job, station.robot());
  if (const auto& procedures = cell_.procedures(robot); !procedures.over()) {
    const program::ProcedureView& steps = procedures.status().view;
    json["procedure"] = {{"number", procedures.status().number},
                         {"kind", steps.id},
                         {"phase", program::name(steps.phase)},
                         {"step", std::min(steps.place + 1, steps.steps.size())},
                         {"of", steps.steps.size()}};
    if (steps.left) json["procedure"]["client_lost"] = true;
  }
  return json;
}

/// What a session watches. Status is made only for whoever reads it; events are not lost before the
/// log forgets them.
void Api::tell(Session& session, Instant now) {
  Watch& watch = session.watch;
  if (!watch.on || session.out.size() >= kOutputSlow) return;
  if (log_.last() != watch.event) {
    for (const auto& event : log_.after(watch.event)) {
      const bool meant = !watch.robot || event.robot == cell_.station(*watch.robot).name();
      if (meant && session.out.size() < kOutputMax / 2) {
        put(session, notification_of_text("event", event.text));
      }
      watch.event = event.number;
      if (session.out.size() >= kOutputMax / 2) break;
    }
  }
  tell_jobs(session, now);
  tell_procedures(session, now);
  if (watch.interval == Duration{} || now < watch.next) return;
  watch.next = next_due(watch.next, watch.interval, now);
  put(session, status_text(watch.robot));
}

const std::string& Api::status_text(std::optional<std::size_t> robot) {
  std::string& text = status_texts_[robot.value_or(cell_.size())];
  if (!text.empty()) return text;
  return text = notification_text("status", cell_status(robot));
}

void Api::tell_jobs(Session& session, Instant now) {
  Watch& watch = session.watch;
  const bool due = now >= watch.job_next;
  if (due) watch.job_next = now + kJobInterval;
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    if (watch.robot && *watch.robot != i) continue;
    const JobView& job = jobs_[i];
    const bool progress = due && !job.over;
    if (job.id == 0 || (same(job, watch.jobs[i]) && !progress)) continue;
    watch.jobs[i] = job;
    put(session,
        notification_text("job", job_json(cell_.station(i).name(), job, cell_.station(i).robot())));
  }
}

}  // namespace sinew::server

// Homing, recovery and commissioning, step by step, by whoever holds the robot's lease.
#include <string>

#include "sinew/io/clock.h"
#include "sinew/server/api/api.h"
#include "sinew/server/json/procedure_json.h"

namespace sinew::server {

using runtime::ProcedureRunner;
using runtime::ProcedureStatus;

namespace {

constexpr std::size_t kAnswerMax = 1000;
constexpr Duration kProgressInterval = std::chrono::milliseconds(100);

bool same_step(const ProcedureStatus& a, const ProcedureStatus& b) {
  return a.number == b.number && a.over == b.over && a.answers == b.answers &&
         a.client == b.client && a.view.left == b.view.left && a.view.phase == b.view.phase &&
         a.view.place == b.view.place && a.view.trouble == b.view.trouble &&
         a.view.question == b.view.question && a.view.ready == b.view.ready;
}

}  // namespace

Json Api::procedure(std::size_t robot) const {
  return procedure_json(cell_.station(robot).name(), cell_.procedures(robot).status());
}

Api::Answer Api::start_procedure(const Call& call) {
  const std::string kind = call.request.params["kind"].get<std::string>();
  if (kind != "home" && kind != "recover" && kind != "commission") {
    return invalid("kind is home, recover or commission");
  }
  if (const auto trouble = no_port(*call.robot)) return *trouble;
  // The session hears of the lease that the procedure takes for it, and keeps it alive.
  if (const auto client = machine(call.session, *call.robot); !client) return client.error();
  if (const auto job = job_under_way(*call.robot)) return *job;
  ProcedureRunner& procedures = cell_.procedures(*call.robot);
  const bool busy = !procedures.over();
  const bool take_over = call.request.flag("take_over");
  if (busy && procedures.status().view.id == kind && (procedures.status().view.left || take_over)) {
    if (const auto held = held_by_another(call, take_over)) return *held;
    procedures.go_on(call.session.id, take_over);
    return procedure(*call.robot);
  }
  if (!busy) {
    if (const auto held = held_by_another(call, take_over)) return *held;
  }
  const auto begun = procedures.start(
      {.kind = kind, .take_over = take_over, .anew = call.request.flag("anew")}, call.session.id);
  if (begun) return procedure(*call.robot);
  return RpcError{busy ? RpcCode::kBusy : RpcCode::kRefused, begun.error(), nullptr};
}

/// Answers and steps back are for the client that goes through it; whoever comes upon one that is
/// left may end it.
Api::Answer Api::steer_procedure(const Method& method, const Call& call) {
  if (method.id == MethodId::kProcedureStart) return start_procedure(call);
  ProcedureRunner& procedures = cell_.procedures(*call.robot);
  if (procedures.over()) {
    return RpcError{RpcCode::kRefused, "no procedure is under way on this robot", nullptr};
  }
  const ProcedureStatus& status = procedures.status();
  const bool ends_left = method.id == MethodId::kProcedureCancel && status.view.left;
  if (status.client != call.session.id && !ends_left) {
    return RpcError{RpcCode::kRefused,
                    "client " + std::to_string(status.client) +
                        " goes through this procedure; procedure.start with take_over goes on with "
                        "it here",
                    nullptr};
  }
  std::expected<void, std::string> done;
  if (method.id == MethodId::kProcedureCancel) {
    procedures.cancel();
    procedures.poll();
  } else if (method.id == MethodId::kProcedureBack) {
    done = procedures.back();
  } else {
    const std::string& text = call.request.params["answer"].get_ref<const std::string&>();
    if (text.size() > kAnswerMax) {
      return invalid("answer is longer than 1000 bytes");
    }
    done = procedures.answer(text);
  }
  if (!done) return RpcError{RpcCode::kRefused, done.error(), nullptr};
  return procedure(*call.robot);
}

/// Each goes on, and what began or ended of them is an event.
void Api::poll_procedures() {
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    ProcedureRunner& procedures = cell_.procedures(i);
    procedures.poll();
    const ProcedureStatus& now = procedures.status();
    ProcedureStatus& before = procedures_[i];
    const bool changed = now.number != before.number || now.over != before.over;
    if (changed && now.number != 0) {
      Json event{{"at_ms", io::wall_time_ns() / 1'000'000},
                 {"robot", cell_.station(i).name()},
                 {"kind", "procedure"},
                 {"procedure_number", now.number},
                 {"procedure", now.view.id},
                 {"phase", program::name(now.view.phase)},
                 {"over", now.over}};
      if (now.over && !now.view.trouble.empty()) event["trouble"] = now.view.trouble;
      log_.add(std::move(event));
    }
    if (changed || !now.over) before = now;
  }
}

void Api::tell_procedures(Session& session, Instant now) {
  Watch& watch = session.watch;
  const bool due = now >= watch.procedure_next;
  if (due) watch.procedure_next = now + kProgressInterval;
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    if (watch.robot && *watch.robot != i) continue;
    const ProcedureStatus& status = procedures_[i];
    const bool progress = due && !status.over && !status.view.progress.empty();
    if (status.number == 0 || (same_step(status, watch.procedures[i]) && !progress)) continue;
    watch.procedures[i] = status;
    put(session, notification_text("procedure", procedure(i)));
  }
}

}  // namespace sinew::server

#include <algorithm>

#include "sinew/config/points_file.h"
#include "sinew/control/position_evidence.h"
#include "sinew/core/error_code.h"
#include "sinew/core/spelling.h"
#include "sinew/io/clock.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/program_part.h"
#include "sinew/server/api/api.h"
#include "sinew/server/json/camera_json.h"
#include "sinew/server/json/model_json.h"
#include "sinew/server/json/open_rpc.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

constexpr double kJogExpiryMax = 1;  // s, real time

constexpr double kRateMax = 100;  // Hz
constexpr double kRateUsual = 10;
constexpr std::size_t kNameMax = 100;
constexpr std::size_t kReasonMax = 200;

/// `from_line` and `speed`: which part of the program, and how fast.
std::optional<RpcError> take_part(const RpcRequest& request, const RobotModel& robot,
                                  runtime::JobOrder& order) {
  const DeviceCapability& device = robot.device.capability;
  if (const auto given = request.params.find("from_line"); given != request.params.end()) {
    const auto line = std::min<std::uint64_t>(given->get<std::uint64_t>(), 1'000'000'000);
    auto part = program::from_line(order.program, static_cast<int>(line));
    if (!part) return invalid("from_line: " + part.error());
    order.program = std::move(*part);
  }
  const double share = request.number("speed", 1);
  if (!(share >= 0.01 && share <= 1)) return invalid("speed has to be 0.01 to 1");
  if (share == 1) return std::nullopt;
  if (!device.takes_speed) return invalid("speed: this device has one speed of its own");
  if (device.motion == MotionKind::kStream) {
    order.feed = share;
  } else {
    order.program = program::slowed(order.program, share);
  }
  return std::nullopt;
}

std::optional<planning::JogFrame> frame_of(std::string_view word) {
  if (word == "joint") return planning::JogFrame::kJoint;
  if (word == "base") return planning::JogFrame::kBase;
  if (word == "tool") return planning::JogFrame::kTool;
  if (word == "platform") return planning::JogFrame::kPlatform;
  return std::nullopt;
}

RpcError guarded(const runtime::JobView& job, const char* way_out) {
  return {RpcCode::kRefused,
          "client " + std::to_string(job.guard) + " holds '" + job.title +
              "' and only that client resumes it" + way_out,
          {{"code", "hold_guarded"}, {"held_by", job.guard}}};
}

}  // namespace

/// Those of files are Api::keep()'s.
Api::Answer Api::call(const Method& method, const Call& call) {
  switch (method.id) {
    case MethodId::kRpcDiscover:
      if (open_rpc_.empty()) open_rpc_ = text_of(open_rpc(version_));
      return Text{open_rpc_};
    case MethodId::kCellDescribe:
      return describe();
    case MethodId::kCellStatus:
      return cell_status();
    case MethodId::kRobotStatus:
      return status(*call.robot);
    case MethodId::kWatch:
      return watch(call);
    case MethodId::kEventsList:
      return events(call.request.whole("after", 0));
    case MethodId::kObjectsList:
      return Json{{"objects", object_names()}};
    case MethodId::kObjectsQuery:
      return query(call);
    case MethodId::kObjectsSubscribe:
      return subscribe(call);
    case MethodId::kLeaseTake:
      return give(call, control::TakeLease{.take_over = call.request.flag("take_over")});
    case MethodId::kLeaseRenew:
      return Json::object();
    case MethodId::kLeaseRelease:
      return give(call, control::ReturnLease{});
    case MethodId::kRobotEnable:
      return enable(call);
    case MethodId::kRobotDisable:
      return give(call, control::Disable{});
    case MethodId::kRobotAcknowledge:
      return give(call, control::Acknowledge{});
    case MethodId::kRobotSelfTest:
      return give(call, control::Service{DeviceService::kSelfTest});
    case MethodId::kRobotFreeDrive:
      return free_drive(call);
    case MethodId::kRobotStop:
      return stop(call);
    case MethodId::kRobotFeed:
      return give(call, control::SetFeed{.share = call.request.number("share", 1)});
    case MethodId::kRobotJog:
      return jog(call);
    case MethodId::kRobotNudge:
      return nudge(call);
    case MethodId::kRobotDeclare:
      return declare(call);
    case MethodId::kProgramRun:
      return run_program(call);
    case MethodId::kRobotRide:
      return ride(call);
    case MethodId::kRobotHold:
    case MethodId::kRobotResume:
    case MethodId::kProgramStep:
      return steer_job(method, call);
    case MethodId::kProcedureStart:
    case MethodId::kProcedureAnswer:
    case MethodId::kProcedureBack:
    case MethodId::kProcedureCancel:
      return steer_procedure(method, call);
    default:
      return look(method, call);
  }
}

/// What only tells something of one robot.
Api::Answer Api::look(const Method& method, const Call& call) {
  switch (method.id) {
    case MethodId::kJobStatus:
      return job_status(*call.robot);
    case MethodId::kProcedureStatus:
      return procedure(*call.robot);
    case MethodId::kSimulationTruth:
      return truth(call);
    case MethodId::kSimulationCamera:
      return trouble_camera(call);
    case MethodId::kRobotModel:
      if (models_[*call.robot].empty()) {
        models_[*call.robot] = text_of(model_json(cell_.station(*call.robot).robot()));
      }
      return Text{models_[*call.robot]};
    case MethodId::kRobotPreview:
      return preview(call);
    case MethodId::kDeviceStatus:
      return device_status(*call.robot);
    case MethodId::kWireRead:
      return read_wire(call);
    case MethodId::kCameraLook:
      return look_through(call);
    case MethodId::kRobotCubes:
      return judge_cubes(call);
    case MethodId::kRobotCubeReach:
      return cube_reach(call);
    case MethodId::kBasketMove:
      return move_basket(call);
    case MethodId::kCameraPrint:
      return print_sheet(call);
    default:
      return is_calibration(method.id) ? calibrate(method, call) : keep(method, call);
  }
}

Api::Text Api::events(std::uint64_t after) const {
  std::string list;
  for (const auto& event : log_.after(after)) list += (list.empty() ? "" : ",") + event.text;
  return {R"({"events":[)" + list + "]}"};
}

Json Api::cell_status(std::optional<std::size_t> robot) {
  Json robots = Json::array();
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    if (!robot || *robot == i) robots.push_back(status(i));
  }
  Json all{{"robots", robots}};
  if (yielding_) all["demonstration"] = true;
  return all;
}

Json Api::job_status(std::size_t robot) const {
  const runtime::Station& station = cell_.station(robot);
  return job_json(station.name(), cell_.jobs(robot).view(), station.robot());
}

Api::Answer Api::enable(const Call& call) {
  if (const auto trouble = no_port(*call.robot)) return *trouble;
  return give(call, control::Enable{});
}

Api::Answer Api::truth(const Call& call) const {
  const runtime::Station& station = cell_.station(*call.robot);
  const auto truth = station.view().truth;
  if (truth) return truth_json(*truth, station.robot());
  return RpcError{RpcCode::kRefused, "this robot is real: nobody knows more than its status",
                  nullptr};
}

Api::Answer Api::describe() const {
  const Cell& cell = cell_.cell();
  Json robots = Json::array();
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    robots.push_back(description_json(cell.robots[i], cell_.station(i)));
  }
  Json objects = Json::array();
  for (const CellObject& object : cell.objects) {
    objects.push_back(box_json(object.name, object.X_WX.p, object.X_WX.R, 2 * object.half));
  }
  Json cameras = Json::array();
  for (std::size_t i = 0; i < cell.cameras.size(); ++i) {
    cameras.push_back(camera_description(cell_, i));
  }
  Json json{{"title", cell.title}, {"version", version_}, {"time_scale", cell.time_scale},
            {"robots", robots},    {"objects", objects},  {"cameras", cameras}};
  if (!cell.baskets.empty()) json["baskets"] = baskets_json(cell_.baskets().all());
  return json;
}

/// Between messages that a client asks for; zero for none.
std::expected<Duration, RpcError> Api::message_interval(const Call& call) const {
  if (call.session.delivery == Delivery::kAnswersOnly) {
    return std::unexpected(RpcError{
        RpcCode::kRefused,
        "messages need a connection that stays: the WebSocket, or the Unix socket", nullptr});
  }
  const double rate = call.request.number("rate_hz", kRateUsual);
  if (!(rate >= 0 && rate <= kRateMax)) {
    return std::unexpected(invalid("rate_hz has to be 0 to 100"));
  }
  return rate > 0 ? from_seconds(1 / rate) : Duration{};
}

Api::Answer Api::watch(const Call& call) {
  const auto interval = message_interval(call);
  if (!interval) return interval.error();
  Watch& watch = call.session.watch;
  watch.on = true;
  watch.interval = *interval;
  watch.robot = call.robot;
  watch.next = call.now;
  watch.job_next = call.now;
  watch.procedure_next = call.now;
  watch.event = call.request.whole("after", log_.last());
  return Json::object();
}

Api::Answer Api::give(const Call& call, const control::CommandWhat& what, bool at_start) {
  if (call.session.pending.size() >= kPendingMax) {
    return RpcError{RpcCode::kBusy, "32 requests of this client wait for an answer already",
                    nullptr};
  }
  const auto client = machine(call.session, *call.robot);
  if (!client) return client.error();
  (*client)->refresh();
  Pending pending;
  pending.robot = *call.robot;
  pending.command = (*client)->give(what);
  pending.group = ++last_group_;
  pending.at_start = at_start;
  pending.epoch = std::holds_alternative<control::TakeLease>(what);
  return Later{{pending}};
}

/// Programs end first, so that none of them goes on behind the stop.
Api::Answer Api::stop(const Call& call) {
  Later later;
  const std::uint64_t group = ++last_group_;
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    if (call.robot && *call.robot != i) continue;
    cell_.jobs(i).stop(cell_.jobs(i).view().id);
    const auto client = machine(call.session, i);
    if (!client) return client.error();
    Pending pending;
    pending.robot = i;
    pending.command = (*client)->give(control::Stop{});
    pending.group = group;
    later.commands.push_back(pending);
  }
  return later;
}

Api::Answer Api::jog(const Call& call) {
  const auto frame = frame_of(call.request.params["frame"].get_ref<const std::string&>());
  if (!frame) return invalid("frame is joint, base, tool or platform");
  const RobotModel& model = cell_.station(*call.robot).robot();
  if (model.device.capability.motion != MotionKind::kStream) {
    return RpcError{RpcCode::kRefused,
                    "this robot's device takes whole moves only, and cannot be jogged; "
                    "move it in small steps",
                    nullptr};
  }
  const double expiry = call.request.number("expiry_s", to_seconds(planning::kJogExpiry));
  if (!(expiry > 0 && expiry <= kJogExpiryMax)) {
    return invalid("expiry_s has to be above 0 and at most 1");
  }
  // The hand on the stick lives in real time, however fast the robot's own time runs.
  const Duration life = from_seconds(expiry * cell_.station(*call.robot).clock().scale());
  planning::JogCommand command{.frame = *frame, .velocity = {}, .expiry = life};
  const Json& velocity = call.request.params["velocity"];
  if (velocity.size() > command.velocity.capacity()) {
    return invalid("velocity has more numbers than any robot has joints");
  }
  for (const Json& one : velocity) command.velocity.push_back(one.get<double>());
  if (const auto job = job_under_way(*call.robot)) return *job;
  return give(call, control::JogAt{command}, true);
}

std::expected<JointVector, RpcError> Api::joints(const Json& numbers, std::size_t robot) const {
  const RobotModel& model = cell_.station(robot).robot();
  if (numbers.size() != model.joints.size()) {
    return std::unexpected(invalid("this robot has " + std::to_string(model.joints.size()) +
                                   " joints, not " + std::to_string(numbers.size())));
  }
  JointVector q;
  for (const Json& one : numbers) q.push_back(one.get<double>());
  return q;
}

/// Whether somebody moved the robot, and says who and how.
std::expected<bool, RpcError> Api::moved(const Call& call) const {
  const auto moved = call.request.params.find("moved");
  if (moved == call.request.params.end()) return false;
  const auto& why = moved->get_ref<const std::string&>();
  if (why.find_first_not_of(' ') != std::string::npos) return true;
  return std::unexpected(invalid("moved needs a reason in words: who moved it, and how"));
}

Api::Answer Api::declare(const Call& call) {
  const runtime::Station& station = cell_.station(*call.robot);
  const auto hand = moved(call);
  if (!hand) return hand.error();
  control::Declare declare{
      .positions = {}, .moved = *hand, .zeroes_counters = call.request.flag("zero_counters")};
  const runtime::StationView view = station.view();
  const auto given = call.request.params.find("positions");
  if (call.request.flag("shown")) {
    const auto shown =
        control::as_shown(station.robot(), {view.positions.data(), view.positions.size()});
    if (!shown) return refusal(RpcCode::kRefused, shown.error(), *call.robot);
    declare.positions = *shown;
  } else {
    JointVector q = home_joints(station.robot());
    if (given != call.request.params.end()) {
      const auto read = joints(*given, *call.robot);
      if (!read) return read.error();
      q = *read;
    }
    for (const double one : q) {
      declare.positions.push_back({PositionQuality::kCommanded, one, one, one});
    }
  }
  Json places = Json::array();
  for (const JointPosition& joint : declare.positions) places.push_back(joint.q);
  Answer answer = give(call, declare);
  if (auto* later = std::get_if<Later>(&answer)) {
    Json& event = later->commands.front().statement;
    event = {{"robot", station.name()},
             {"kind", "declared"},
             {"client", call.session.id},
             {"positions", places},
             {"known", joints_json(view, station.robot())}};
    if (*hand) {
      event["reason"] =
          printable(call.request.params["moved"].get<std::string>().substr(0, kReasonMax));
    }
    if (declare.zeroes_counters) event["zero_counters"] = true;
  }
  return answer;
}

Api::Answer Api::free_drive(const Call& call) {
  if (!cell_.station(*call.robot).robot().device.capability.free_drive) {
    return RpcError{RpcCode::kRefused,
                    "this robot has no free drive: its motors cannot be switched off alone, or "
                    "its positions are not measured",
                    nullptr};
  }
  if (const auto job = job_under_way(*call.robot)) return *job;
  const bool on = call.request.params["on"].get<bool>();
  return give(call, control::Service{on ? DeviceService::kFree : DeviceService::kHold});
}

Api::Answer Api::nudge(const Call& call) {
  const RobotModel& model = cell_.station(*call.robot).robot();
  const std::string& name = call.request.params["joint"].get_ref<const std::string&>();
  const auto joint = std::ranges::find(model.joints, name, &Joint::name);
  if (joint == model.joints.end()) {
    std::string names;
    for (const Joint& one : model.joints) names += (names.empty() ? "" : ", ") + one.name;
    return invalid("this robot has no joint of that name; there are " + names);
  }
  if (!(model.device.capability.nudge_max > 0)) {
    return RpcError{RpcCode::kRefused,
                    "this robot's device moves to places only, so nothing can be moved by a little "
                    "from nobody knows where",
                    nullptr};
  }
  if (const auto job = job_under_way(*call.robot)) return *job;
  const double way = call.request.params["way"].get<double>();
  const bool probes = call.request.params.value("until_probe", false);
  return give(call,
              control::Nudge{static_cast<std::uint8_t>(joint - model.joints.begin()), way, probes},
              true);
}

Api::Answer Api::run_program(const Call& call) {
  const auto& params = call.request.params;
  const std::string& text = params["text"].get_ref<const std::string&>();
  const auto named = params.find("name");
  const std::string name =
      named != params.end() ? printable(named->get<std::string>().substr(0, kNameMax)) : "program";
  const RobotModel& model = cell_.station(*call.robot).robot();
  std::optional<TaughtPoints> points;
  if (const auto given = params.find("points"); given != params.end()) {
    points = usable_points(given->get_ref<const std::string&>(), "points.toml");
  }
  program::Surroundings around;
  around.points = points ? &*points : nullptr;
  around.table = cell_.table_top(*call.robot);
  around.load = [&](std::string_view called) -> std::expected<program::CalledFile, std::string> {
    const auto texts = params.find("called");
    const std::string key(called);
    if (texts != params.end() && texts->contains(key)) {
      return program::CalledFile{key, (*texts)[key].get<std::string>()};
    }
    return std::unexpected("the request does not bring the program '" + key + "'");
  };
  const auto form = asked_form(call.request, model);
  if (!form) return form.error();
  auto program = program::read_text(*form, text, name, model, around);
  if (!program) return no_form(program.error(), model);
  if (program->steps.empty()) return invalid("the program has no row");
  runtime::JobOrder order{.title = name,
                          .program = std::move(*program),
                          .ride = std::nullopt,
                          .standing_at = std::nullopt,
                          .take_over = call.request.flag("take_over"),
                          .single_step = call.request.flag("single_step"),
                          .recorded = true,
                          .feed = 1};
  if (const auto trouble = take_part(call.request, model, order)) return *trouble;
  if (const auto given = params.find("standing_at"); given != params.end()) {
    const auto read = joints(*given, *call.robot);
    if (!read) return read.error();
    order.standing_at = program::Statement{.q = *read};
  }
  if (call.request.flag("shown")) order.standing_at = program::Statement{};
  const auto hand = moved(call);
  if (!hand) return hand.error();
  if (*hand && !order.standing_at) return invalid("moved goes with standing_at or shown");
  if (*hand) order.standing_at->moved = true;
  return start(call, std::move(order));
}

Api::Answer Api::ride(const Call& call) {
  const double duration = call.request.params["duration_s"].get<double>();
  const bool fits = duration >= program::kRideMin && duration <= program::kRideMax;
  if (!fits) return invalid("duration_s has to be 1 to 3600");
  const double amplitude = call.request.number("amplitude", 0);
  if (!(amplitude >= 0 && amplitude <= 1)) return invalid("amplitude has to be 0 to 1");
  const auto seed = call.request.params.find("seed");
  program::RideOrder ride{.duration = duration, .amplitude = amplitude};
  if (seed != call.request.params.end()) ride.seed = seed->get<std::uint64_t>();
  return start(call, {.title = "bullride",
                      .program = {},
                      .ride = ride,
                      .standing_at = std::nullopt,
                      .take_over = call.request.flag("take_over"),
                      .single_step = false,
                      .recorded = true,
                      .feed = 1});
}

/// Why a robot cannot be reached at all.
std::optional<RpcError> Api::no_port(std::size_t robot) const {
  const std::string trouble = cell_.station(robot).trouble();
  if (trouble.empty()) return std::nullopt;
  return RpcError{RpcCode::kRefused, cell_.station(robot).name() + ": " + trouble, nullptr};
}

Api::Answer Api::start(const Call& call, runtime::JobOrder order) {
  if (const auto trouble = no_port(*call.robot)) return *trouble;
  // The session hears of the lease that the job takes for it, and keeps it alive.
  if (const auto client = machine(call.session, *call.robot); !client) return client.error();
  if (const auto& procedures = cell_.procedures(*call.robot); !procedures.over()) {
    return RpcError{RpcCode::kBusy,
                    "'" + procedures.status().view.title +
                        "' is under way on this robot: go on with it or cancel it first",
                    nullptr};
  }
  if (const auto held = held_by_another(call, order.take_over)) return *held;
  order.recorded = yielding_ != call.session.id;
  order.on_client_loss = on_client_loss(*call.robot);
  const auto job = cell_.jobs(*call.robot).start(std::move(order), call.session.id);
  if (!job) {
    const auto other = job_under_way(*call.robot);
    return other ? *other : refusal(RpcCode::kBusy, job.error(), *call.robot);
  }
  return Json{{"job", *job}};
}

/// What would fail as soon as it asked for the lease is refused before it occupies the robot.
std::optional<RpcError> Api::held_by_another(const Call& call, bool take_over) const {
  const auto holder = cell_.station(*call.robot).view().holder;
  if (take_over || !holder || holder->client == call.session.id) return std::nullopt;
  // Who has gone has given it back, if only a moment ago.
  if (!sessions_.contains(holder->client)) return std::nullopt;
  const Error held{ErrorCode::kLeaseHeld, -1, static_cast<double>(holder->client)};
  return refusal(RpcCode::kRefused, held, *call.robot);
}

std::optional<RpcError> Api::job_under_way(std::size_t robot) const {
  const runtime::JobView job = cell_.jobs(robot).view();
  if (job.over) return std::nullopt;
  return RpcError{RpcCode::kBusy,
                  "'" + job.title + "' is " + (job.paused ? "paused" : "under way") +
                      " on this robot: resume or stop it first",
                  {{"job", job.id}}};
}

/// A hold that is guarded, and a program whose client is gone, are not for everyone.
std::optional<RpcError> Api::may_not_resume(const Call& call, const runtime::JobView& job) {
  const bool by_another = job.guard != 0 && job.guard != call.session.id;
  if (by_another && !call.request.flag("take_over")) {
    return guarded(job, "; take the hold over (take_over), or stop it");
  }
  if (!job.client_lost) return std::nullopt;
  const auto holder = cell_.station(*call.robot).view().holder;
  if (holder && holder->client == call.session.id) return std::nullopt;
  return RpcError{RpcCode::kRefused,
                  "the client that ran '" + job.title +
                      "' is gone: take control (lease.take) and resume it, or stop it",
                  {{"code", "client_lost"}}};
}

/// Where no program is under way.
Api::Answer Api::steer_motion(const Method& method, const Call& call) {
  if (method.id == MethodId::kRobotHold) {
    auto held = give(call, control::Hold{});
    if (!call.request.flag("guarded")) return held;
    return RpcError{RpcCode::kRefused,
                    "only the hold of a program can be guarded, and no program is under way on "
                    "this robot: what moves is held, but anyone resumes it",
                    nullptr};
  }
  if (method.id != MethodId::kRobotResume) {
    return RpcError{RpcCode::kRefused, "no program is under way on this robot", nullptr};
  }
  if (cell_.station(*call.robot).view().state != control::MachineState::kHeld) {
    return RpcError{RpcCode::kRefused, "nothing is paused on this robot", nullptr};
  }
  return give(call, control::Resume{});
}

Api::Answer Api::steer_job(const Method& method, const Call& call) {
  runtime::JobRunner& jobs = cell_.jobs(*call.robot);
  const runtime::JobView job = jobs.view();
  if (job.over) return steer_motion(method, call);
  if (method.id == MethodId::kRobotHold) {
    const bool guards = call.request.flag("guarded");
    jobs.pause(job.id, guards ? call.session.id : 0);
    if (!guards || job.guard == 0 || job.guard == call.session.id) return Json{{"job", job.id}};
    return guarded(job, "; it stays held, without a guard of yours");
  }
  if (const auto refused = may_not_resume(call, job)) return *refused;
  if (method.id == MethodId::kRobotResume) {
    jobs.resume(job.id, call.session.id);
  } else if (call.request.flag("back")) {
    jobs.step_back(job.id, call.session.id);
  } else {
    jobs.step(job.id, call.session.id);
  }
  return Json{{"job", job.id}, {"wishes", job.wishes}};
}

}  // namespace sinew::server

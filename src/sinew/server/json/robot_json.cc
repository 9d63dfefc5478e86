#include "sinew/server/json/robot_json.h"

#include <array>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/driver/quality_name.h"
#include "sinew/model/error_sentence.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/planning/jog/jog_reason.h"
#include "sinew/runtime/records/unit_name.h"
#include "sinew/server/json/preview.h"

namespace sinew::server {
namespace {

using planning::LimitKind;
using runtime::with_unit;

/// The worst of all joints: nobody knows a machine better than that.
std::string_view worst_quality(const runtime::StationView& view) {
  PositionQuality worst = PositionQuality::kMeasured;
  for (const JointPosition& position : view.positions) worst = std::min(worst, position.quality);
  return quality_name(view.positions.empty() ? PositionQuality::kLost : worst);
}

std::optional<JointVector> known_place(const runtime::StationView& view, const RobotModel& model) {
  JointVector q;
  for (const JointPosition& position : view.positions) {
    if (position.quality < PositionQuality::kCommanded) return std::nullopt;
    q.push_back(position.q);
  }
  if (q.size() != model.joints.size()) return std::nullopt;
  return q;
}

Json health_json(const runtime::StationView& view) {
  Json json{{"requests", view.health.requests},     {"retries", view.health.retries},
            {"repeats", view.health.repeats},       {"timeouts", view.health.timeouts},
            {"unexpected", view.health.unexpected}, {"bytes_to_device", view.bytes.to_device},
            {"bytes_to_host", view.bytes.to_host}};
  if (view.health.supply_volts) json["supply_v"] = *view.health.supply_volts;
  if (view.health.temperature_c) json["temperature_c"] = *view.health.temperature_c;
  if (view.health.jaws_width) json["jaws_width_m"] = *view.health.jaws_width;
  return json;
}

/// Unit of an error's numbers, as part of a name; a prismatic joint has metres.
std::string_view unit_of(const Error& error, const RobotModel& model) {
  switch (quantity_of(error, model)) {
    case Quantity::kLength:
      return "_m";
    case Quantity::kAngle:
      return "_rad";
    case Quantity::kVelocity:
      return "_m_s";
    case Quantity::kAcceleration:
      return "_m_s2";
    case Quantity::kTime:
      return "_s";
    case Quantity::kVoltage:
      return "_v";
    case Quantity::kAngularVelocity:
      return "_rad_s";
    case Quantity::kAngularAcceleration:
      return "_rad_s2";
    case Quantity::kNone:
    case Quantity::kRatio:
    case Quantity::kCount:
      break;
  }
  return "";
}

std::string_view limit_name(LimitKind kind) {
  switch (kind) {
    case LimitKind::kJointVelocity:
      return "joint_velocity";
    case LimitKind::kJointAcceleration:
      return "joint_acceleration";
    case LimitKind::kJointJerk:
      return "joint_jerk";
    case LimitKind::kToolSpeed:
      return "tool_speed";
    case LimitKind::kToolAcceleration:
      return "tool_acceleration";
    case LimitKind::kWire:
      return "wire";
    case LimitKind::kFeed:
      break;
  }
  return "feed";
}

}  // namespace

Json latched_json(const control::Latched& latched, const RobotModel& model) {
  Json json{{"cause", cause_name(latched.cause)}, {"error", error_json(latched.error, model)}};
  if (const auto category = category_number(latched.cause, latched.error)) {
    json["category"] = *category;
  }
  return json;
}

std::string_view cause_name(control::StopCause cause) {
  return control::stop_rule(cause).name;
}

std::optional<int> category_number(control::StopCause cause, const std::optional<Error>& reason) {
  switch (control::stop_category(cause, reason)) {
    case StopCategory::kPowerOff:
      return 0;
    case StopCategory::kStopThenPowerOff:
      return 1;
    case StopCategory::kStopAndHold:
      return 2;
    case StopCategory::kNone:
      break;
  }
  return std::nullopt;
}

Json pose_json(const Vec3& p, const Rotation& R) {
  return {{"x_m", p.x}, {"y_m", p.y}, {"z_m", p.z}, {"quaternion_wxyz", quaternion_wxyz(R)}};
}

Json box_json(const std::string& name, const Vec3& p, const Rotation& R, const Vec3& size) {
  Json json = pose_json(p, R);
  json["name"] = name;
  json["length_m"] = size.x;
  json["width_m"] = size.y;
  json["height_m"] = size.z;
  return json;
}

RpcError complained(const std::vector<Complaint>& complaints) {
  Json list = Json::array();
  for (const Complaint& complaint : complaints) {
    list.push_back({{"file", complaint.file},
                    {"line", complaint.line},
                    {"column", complaint.column},
                    {"sentence", complaint.message}});
  }
  return {RpcCode::kInvalidParams, to_text(complaints.front()), {{"complaints", list}}};
}

void put_in_the_way(Json& json, const runtime::CellRefusal& refusal) {
  json["sentence"] = refusal.sentence();
  json["link"] = refusal.link;
  json["other"] = refusal.other;
  if (!refusal.other_link.empty()) json["other_link"] = refusal.other_link;
  json["share"] = refusal.share;
  json["way_m"] = refusal.way;
  if (std::isfinite(refusal.distance)) json["distance_m"] = refusal.distance;
  json["margin_m"] = refusal.margin;
  json["moving"] = refusal.moving;
}

Json error_json(const Error& error, const RobotModel& model) {
  Json json{{"code", info(error.code).name}, {"sentence", sentence_of(error, model)}};
  const std::string subject = subject_of(error, model);
  const bool in_cell = error.code == ErrorCode::kCellContact || error.code == ErrorCode::kCellTaken;
  const char* kind = error.other >= 0 ? "links" : in_cell ? "link" : "joint";
  if (!subject.empty()) json[kind] = subject;
  const bool left_out = error.code == ErrorCode::kPositionUnknown && error.index >= 0 &&
                        is_left_out(model, static_cast<std::size_t>(error.index));
  if (left_out) json["left_out"] = true;
  if (info(error.code).quantity != Quantity::kNone) {
    const std::string unit(unit_of(error, model));
    json["measured" + unit] = error.measured;
    json["limit" + unit] = error.limit;
  }
  return json;
}

Json joints_json(const runtime::StationView& view, const RobotModel& model) {
  Json joints = Json::array();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const JointPosition position = j < view.positions.size() ? view.positions[j] : JointPosition{};
    Json one{{"name", joint.name}, {"quality", quality_name(position.quality)}};
    if (position.quality != PositionQuality::kLost) {
      one[with_unit("position", joint)] = position.q;
      one[with_unit("lower", joint)] = position.lower;
      one[with_unit("upper", joint)] = position.upper;
    }
    if (view.reference) one[with_unit("commanded", joint)] = (*view.reference)[j];
    joints.push_back(std::move(one));
  }
  return joints;
}

Json description_json(const CellRobot& place, const runtime::Station& station) {
  const RobotModel& model = station.robot();
  Json joints = Json::array();
  for (const Joint& joint : model.joints) {
    joints.push_back({{"name", joint.name},
                      {with_unit("lower", joint), joint.lower},
                      {with_unit("upper", joint), joint.upper},
                      {with_unit("home", joint), joint.home},
                      {with_unit("velocity_max", joint) + "_s", joint.velocity_max},
                      {with_unit("acceleration_max", joint) + "_s2", joint.acceleration_max}});
  }
  const DeviceCapability& capability = model.device.capability;
  const StopFacts stop = model.device.settings->stop_facts();
  Json json{{"name", place.name},
            {"robot", model.id},
            {"title", model.title},
            {"port", station.port_name()},
            {"simulated", station.simulated()},
            {"time_scale", station.clock().scale()},
            {"pose", pose_json(place.X_WB.p, place.X_WB.R)},
            {"streams", capability.motion == MotionKind::kStream},
            {"free_drive", capability.free_drive},
            {"probes", capability.probes},
            {"joints", joints},
            {"stop",
             {{"ends_motion", stop.ends_motion},
              {"standstill", stop.standstill},
              {"gravity", stop.falls}}}};
  for (std::size_t j = 0; j < model.joints.size() && capability.nudge_max > 0; ++j) {
    json[with_unit("nudge_max", model.joints[j])] = nudge_max(model, j);
  }
  if (const auto* recovery = station.recovery()) {
    json["position_journal"] = {{"found", station.journal_found()},
                                {"way_out", sentence(recovery->way_out)}};
  }
  return json;
}

Json status_json(const runtime::Station& station, const runtime::StationView& view,
                 const planning::ToolSpace& tool, planning::PoseBT& X_near) {
  const RobotModel& model = station.robot();
  Json json{{"robot", station.name()},
            {"at_s", to_seconds(view.at.time_since_epoch())},
            {"state", control::name(view.state)},
            {"position", worst_quality(view)},
            {"connected", view.port_open},
            {"joints", joints_json(view, model)},
            {"feed", view.feed},
            {"free_drive", view.free_drive},
            {"progress", view.progress}};
  if (const std::string trouble = station.trouble(); !trouble.empty()) json["trouble"] = trouble;
  if (view.tool.jaws) json["jaws_m"] = *view.tool.jaws;
  if (view.tool.held) json["held_m"] = *view.tool.held;
  if (const auto q = known_place(view, model)) {
    if (const auto X_BT = tool.forward({q->data(), q->size()}, X_near)) {
      X_near = *X_BT;
      json["tool"] = pose_json(X_BT->p, X_BT->R);
    }
  }
  if (view.holder) json["lease"] = {{"client", view.holder->client}, {"epoch", view.holder->epoch}};
  if (view.homing_joint && *view.homing_joint < model.joints.size()) {
    json["homing"] = model.joints[*view.homing_joint].name;
  }
  if (view.latched) {
    json["fault"] = latched_json(*view.latched, model);
    for (const control::Latched& one : view.later) {
      json["fault"]["later"].push_back(latched_json(one, model));
    }
  }
  if (view.jog.moving) {
    json["jog"] = {{"reason", planning::name(view.jog.reason)}, {"share", view.jog.share}};
    if (view.jog.joint >= 0) {
      json["jog"]["joint"] = model.joints[static_cast<std::size_t>(view.jog.joint)].name;
    }
  }
  if (view.last_stop) json["last_stop"] = cause_name(*view.last_stop);
  if (view.goes_on_until && *view.goes_on_until > view.at) {
    json["goes_on_s"] = to_seconds(*view.goes_on_until - view.at);
  }
  json["health"] = health_json(view);
  if (view.cycle_longest > 0) {
    json["cycle"] = {{"mean_s", view.cycle_mean}, {"longest_s", view.cycle_longest}};
  }
  return json;
}

std::string_view phase_name(const runtime::JobView& job) {
  constexpr std::array<std::string_view, 6> kNames{"opening", "running", "stopping",
                                                   "done",    "stopped", "failed"};
  if (job.paused && !job.over) return "paused";
  if (job.planned && !job.begun && job.phase <= program::Run::Phase::kRunning) return "planned";
  return kNames[static_cast<std::size_t>(job.phase)];
}

Json job_json(const std::string& robot, const runtime::JobView& job, const RobotModel& model) {
  Json json{{"robot", robot},
            {"job", job.id},
            {"client", job.client},
            {"title", job.title},
            {"phase", phase_name(job)},
            {"over", job.over},
            {"line", job.line},
            {"orders_done", job.orders_done},
            {"orders", job.orders},
            {"predicted_s", job.duration},
            {"homing_at_most_s", job.homing_max},
            {"elapsed_s", job.elapsed},
            {"progress", job.progress},
            {"notices", job.notices},
            {"wishes", job.wishes}};
  const auto tell = [&](const char* key, const program::Refusal& refusal) {
    json[key] = refusal_json(refusal, model);
  };
  if (job.planned) put_limited(json, job.limits, model);
  if (job.failure) tell("error", *job.failure);
  if (job.failure && !job.remedies.empty()) json["error"]["remedies"] = job.remedies;
  for (const program::ProgramNote& note : job.notes) {
    json["notes"].push_back({{"line", note.line}, {"sentence", note.sentence}});
  }
  if (job.wish_refused) tell("wish_refused", *job.wish_refused);
  if (job.failure && job.in_the_way) put_in_the_way(json["error"], *job.in_the_way);
  if (job.waits_for_room && job.in_the_way) json["waits_for"] = job.in_the_way->other;
  if (job.client_lost) json["client_lost"] = true;
  if (job.guard != 0) json["held_by"] = job.guard;
  if (job.stopped_by) json["stopped_by"] = cause_name(*job.stopped_by);
  if (job.paused && job.paused_by) json["paused_by"] = error_json(*job.paused_by, model);
  if (job.last_notice) json["last_notice"] = error_json(job.last_notice->error, model);
  return json;
}

void put_limited(Json& json, const planning::LimitTimes& limits, const RobotModel& model) {
  if (limits.total() <= 0) return;
  constexpr double kStep = 1e-4;
  const planning::PathLimit most = limits.largest();
  const double share = limits.of(most) / limits.total();
  json["limited"] = {{"by", limit_name(most.kind)},
                     {"share_of_time", std::round(share / kStep) * kStep}};
  if (most.joint >= 0) {
    json["limited"]["joint"] = model.joints[static_cast<std::size_t>(most.joint)].name;
  }
}

Json truth_json(const sim::Truth& truth, const RobotModel& model) {
  Json joints = Json::array();
  for (std::size_t j = 0; j < truth.joints.size() && j < model.joints.size(); ++j) {
    const sim::JointTruth& one = truth.joints[j];
    const Joint& joint = model.joints[j];
    joints.push_back({{"name", joint.name},
                      {with_unit("position", joint), one.q},
                      {with_unit("believed", joint), one.believed},
                      {"stalled", one.stalled},
                      {"at_end_stop", one.at_end_stop},
                      {"lost_steps", one.lost_steps}});
  }
  return {{"joints", joints},
          {"supply_v", truth.supply_volts},
          {"moving", truth.moving},
          {"tool", truth.tool},
          {"suction", truth.suction}};
}

}  // namespace sinew::server

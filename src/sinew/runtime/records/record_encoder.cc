#include "sinew/runtime/records/record_encoder.h"

#include <algorithm>
#include <utility>

#include "sinew/driver/quality_name.h"
#include "sinew/model/error_sentence.h"
#include "sinew/runtime/records/record_json.h"
#include "sinew/runtime/records/unit_name.h"

namespace sinew::runtime {
namespace {

using control::ControlEvent;
using namespace record;

/// How often what changes slowly is told again, and over how long bytes a second are counted.
constexpr Duration kSlowPeriod = std::chrono::milliseconds(100);

Json joints_schema(const RobotModel& robot) {
  Json joints = Json::object();
  for (const Joint& joint : robot.joints) {
    joints[joint.name] = object({{with_unit("position", joint), number()},
                                 {with_unit("lower", joint), number()},
                                 {with_unit("upper", joint), number()},
                                 {with_unit("commanded", joint), number()},
                                 {"quality", text()}});
  }
  return object({{"joints", object(std::move(joints))}});
}

Json state_schema() {
  return object({{"state", text()},
                 {"connected", {{"type", "boolean"}}},
                 {"fault", text()},
                 {"task", whole()},
                 {"progress", number()},
                 {"feed", number()}});
}

Json events_schema() {
  return object({{"kind", text()},
                 {"state", text()},
                 {"command", whole()},
                 {"cause", text()},
                 {"client", whole()},
                 {"lost", whole()},
                 {"error", object({{"code", text()}, {"sentence", text()}, {"joint", text()}})}});
}

Json wire_schema() {
  return object({{"to_device_bytes_s", number()},
                 {"to_host_bytes_s", number()},
                 {"to_device_bytes", whole()},
                 {"to_host_bytes", whole()},
                 {"requests", whole()},
                 {"retries", whole()},
                 {"repeats", whole()},
                 {"timeouts", whole()},
                 {"unexpected", whole()},
                 {"supply_v", number()},
                 {"temperature_c", number()}});
}

/// As Foxglove's own schema of that name has it, so that its 3D view shows the tool.
/// Source: https://docs.foxglove.dev/docs/visualization/message-schemas/pose-in-frame
Json pose_schema() {
  const Json point = object({{"x", number()}, {"y", number()}, {"z", number()}});
  const Json turn = object({{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
  return object({{"timestamp", time_schema()},
                 {"frame_id", text()},
                 {"pose", object({{"position", point}, {"orientation", turn}})}});
}

const char* kind_name(ControlEvent::Kind kind) {
  constexpr std::array<const char*, 10> kNames{"refused", "started", "done", "failed", "stopped",
                                               "lease",   "state",   "stop", "fault",  "notice"};
  return kNames[static_cast<std::size_t>(kind)];
}

Json event_json(const ControlEvent& event, const RobotModel& robot) {
  using Kind = ControlEvent::Kind;
  const Kind kind = event.kind;
  Json json{{"kind", kind_name(kind)}};
  if (event.command != 0) json["command"] = event.command;
  if (kind == Kind::kState) json["state"] = control::name(event.state);
  if (kind == Kind::kLease) json["client"] = event.lease.epoch != 0 ? event.lease.client : 0;
  if (kind == Kind::kStop || kind == Kind::kStopped || kind == Kind::kLatched) {
    json["cause"] = control::stop_rule(event.cause).name;
  }
  const bool failed = kind == Kind::kRefused || kind == Kind::kFailed || kind == Kind::kLatched ||
                      kind == Kind::kNotice || (kind == Kind::kStop && event.error != Error{});
  if (failed) {
    json["error"] = {{"code", info(event.error.code).name},
                     {"sentence", sentence_of(event.error, robot)}};
    const std::string subject = subject_of(event.error, robot);
    if (!subject.empty()) json["error"]["joint"] = subject;
  }
  return json;
}

std::optional<JointVector> known_place(const RunSample& sample, const RobotModel& robot) {
  JointVector q;
  for (const JointPosition& position : sample.positions) {
    if (position.quality < PositionQuality::kCommanded) return std::nullopt;
    q.push_back(position.q);
  }
  if (q.size() != robot.joints.size()) return std::nullopt;
  return q;
}

}  // namespace

RecordEncoder::RecordEncoder(const RobotModel& robot, const RecordTitle& title,
                             McapWriter::Sink sink)
    : robot_(robot),
      title_(title),
      tool_(robot),
      X_near_(tool_.home()),
      writer_(std::move(sink), title.library),
      looks_(robot, title.robot),
      last_(title.start) {
  const auto channel = [&](const char* topic, const char* schema, const Json& json) {
    const auto id = writer_.add_schema(schema, "jsonschema", text_of(json));
    return writer_.add_channel(id, "/" + title_.robot + "/" + topic, "json");
  };
  joints_channel_ = channel("joint_states", "sinew.JointStates", joints_schema(robot_));
  state_channel_ = channel("state", "sinew.State", state_schema());
  events_channel_ = channel("events", "sinew.Event", events_schema());
  wire_channel_ = channel("wire", "sinew.Wire", wire_schema());
  tool_channel_ = channel("tool", "foxglove.PoseInFrame", pose_schema());
  writer_.add_metadata("sinew.run", {{"robot", title_.robot},
                                     {"model", robot_.id},
                                     {"program", title_.program},
                                     {"started_ns", std::to_string(title_.wall_ns)}});
}

std::uint64_t RecordEncoder::time(Instant at) const {
  const std::int64_t ns = title_.wall_ns + (at - title_.start).count();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0));
}

void RecordEncoder::put(std::uint16_t channel, Instant at, std::string_view json) {
  last_ = std::max(last_, at);
  if (!writer_.add_message(channel, time(last_), json)) ++lost_;
}

void RecordEncoder::add(const RunSample& sample) {
  put_joints(sample);
  put_tool(sample);
  const bool changed = !state_before_ || state_before_->state != sample.state ||
                       state_before_->connected != sample.connected ||
                       state_before_->fault != sample.fault || state_before_->task != sample.task ||
                       state_before_->feed != sample.feed;
  if (changed || sample.at - state_before_->at >= kSlowPeriod) put_state(sample);
  if (!wire_before_ || sample.at - wire_before_->at >= kSlowPeriod) put_wire(sample);
}

void RecordEncoder::put_joints(const RunSample& sample) {
  Json joints = Json::object();
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    const Joint& joint = robot_.joints[j];
    const JointPosition position =
        j < sample.positions.size() ? sample.positions[j] : JointPosition{};
    Json one = Json::object();
    if (position.quality != PositionQuality::kLost) {
      one[with_unit("position", joint)] = position.q;
      one[with_unit("lower", joint)] = position.lower;
      one[with_unit("upper", joint)] = position.upper;
    }
    if (sample.commanded && j < sample.commanded->size()) {
      one[with_unit("commanded", joint)] = (*sample.commanded)[j];
    }
    one["quality"] = quality_name(position.quality);
    joints[joint.name] = std::move(one);
  }
  put(joints_channel_, sample.at, text_of({{"joints", std::move(joints)}}));
}

void RecordEncoder::put_state(const RunSample& sample) {
  Json json{{"state", control::name(sample.state)}, {"connected", sample.connected}};
  if (sample.fault) json["fault"] = control::stop_rule(*sample.fault).name;
  json["task"] = sample.task;
  json["progress"] = sample.progress;
  json["feed"] = sample.feed;
  put(state_channel_, sample.at, text_of(json));
  state_before_ = sample;
}

void RecordEncoder::put_wire(const RunSample& sample) {
  Json json = Json::object();
  if (wire_before_ && sample.at > wire_before_->at) {
    const double s = to_seconds(sample.at - wire_before_->at);
    const auto rate = [&](std::size_t now, std::size_t before) {
      return now >= before ? static_cast<double>(now - before) / s : 0.0;
    };
    json["to_device_bytes_s"] = rate(sample.bytes.to_device, wire_before_->bytes.to_device);
    json["to_host_bytes_s"] = rate(sample.bytes.to_host, wire_before_->bytes.to_host);
  }
  const DriverHealth& health = sample.health;
  json["to_device_bytes"] = sample.bytes.to_device;
  json["to_host_bytes"] = sample.bytes.to_host;
  json["requests"] = health.requests;
  json["retries"] = health.retries;
  json["repeats"] = health.repeats;
  json["timeouts"] = health.timeouts;
  json["unexpected"] = health.unexpected;
  if (health.supply_volts) json["supply_v"] = *health.supply_volts;
  if (health.temperature_c) json["temperature_c"] = *health.temperature_c;
  put(wire_channel_, sample.at, text_of(json));
  wire_before_ = sample;
}

/// Only where every joint's place is known; the tool of a guess is nowhere.
void RecordEncoder::put_tool(const RunSample& sample) {
  const auto q = known_place(sample, robot_);
  if (!q) return;
  if (jaws_ != sample.tool.jaws) {
    jaws_ = sample.tool.jaws;
    tool_ = planning::ToolSpace(robot_, jaws_);
  }
  const auto X_BT = tool_.forward({q->data(), q->size()}, X_near_);
  if (!X_BT) return;
  X_near_ = *X_BT;
  const auto turn = quaternion_wxyz(X_BT->R);
  const Vec3& p = X_BT->p;
  const Json pose{
      {"position", {{"x", p.x}, {"y", p.y}, {"z", p.z}}},
      {"orientation", {{"x", turn[1]}, {"y", turn[2]}, {"z", turn[3]}, {"w", turn[0]}}}};
  put(tool_channel_, sample.at,
      text_of({{"timestamp", time_json(time(std::max(last_, sample.at)))},
               {"frame_id", title_.robot + "/base"},
               {"pose", pose}}));
}

void RecordEncoder::add(const RunEvent& event) {
  put(events_channel_, event.at, text_of(event_json(event.event, robot_)));
}

void RecordEncoder::add(const RunPicture& picture) {
  last_ = std::max(last_, picture.at);
  lost_ += looks_.put(writer_, time(last_), picture);
}

void RecordEncoder::add(const RunDecision& decision) {
  last_ = std::max(last_, decision.at);
  lost_ += looks_.put(writer_, time(last_), decision);
}

void RecordEncoder::add_lost(std::uint64_t count, Instant at) {
  lost_ += count;
  put(events_channel_, at, text_of({{"kind", "lost"}, {"lost", count}}));
}

void RecordEncoder::finish() {
  writer_.add_metadata("sinew.end", {{"lost", std::to_string(lost_)}});
  writer_.finish();
}

}  // namespace sinew::runtime

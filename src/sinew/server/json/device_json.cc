#include "sinew/server/json/device_json.h"

#include <array>
#include <span>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/axis/axis_wire_words.h"
#include "sinew/devices/axis_link/axis_link_driver_facts.h"
#include "sinew/devices/axis_registers/axis_registers_driver_facts.h"
#include "sinew/devices/axis_registers/axis_registers_driver_units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_facts.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/feetech/feetech_driver_facts.h"
#include "sinew/devices/icp/icp_driver_facts.h"
#include "sinew/devices/icp/tmc222_wire_words.h"
#include "sinew/devices/lsc/lsc_driver.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_driver_facts.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/hand.h"
#include "sinew/runtime/records/unit_name.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

constexpr std::int16_t kDeadServo = -1;  ///< what a MaxArm answers for a servo that does not

/// What somebody should look at; `name` is one of docs/api.md.
void warn(Json& json, std::string_view name, const std::string& joint = {},
          std::optional<double> age = {}) {
  Json one{{"name", name}};
  if (!joint.empty()) one["joint"] = joint;
  if (age) one["age_s"] = *age;
  json["warnings"].push_back(std::move(one));
}

template <class Bytes>
std::string hex(const Bytes& bytes) {
  return hex_of({bytes.begin(), bytes.end()});
}

/// Ages as of one instant.
class Teller {
 public:
  Teller(const RobotModel& model, Instant now) : model_(model), now_(now) {}

  Json of(const DeviceFacts& facts) const;
  Json operator()(const IcpFacts& facts) const;
  Json operator()(const LscFacts& facts) const;
  Json operator()(const MaxArmFacts& facts) const;
  Json operator()(const BigRobotArmFacts& facts) const;
  Json operator()(const AxisRegistersFacts& facts) const;
  Json operator()(const AxisLinkFacts& facts) const;
  Json operator()(const FeetechFacts& facts) const;

 private:
  Json base() const {
    return {{"wire", model_.device.protocol},
            {"at_s", to_seconds(now_.time_since_epoch())},
            {"warnings", Json::array()}};
  }
  double age(Instant at) const { return std::max(0.0, to_seconds(now_ - at)); }
  /// With its age and, where there are such, its bytes.
  template <class Bytes>
  Json heard(Instant at, const Bytes& bytes) const {
    return {{"age_s", age(at)}, {"bytes", hex(bytes)}};
  }
  const std::string& joint(std::size_t j) const { return model_.joints[j].name; }
  Json servos(std::span<const lsc::ServoValue> values) const;
  Json group(const lsc::Bytes& bytes, std::uint8_t group, std::uint16_t times, Instant at) const;
  void judge_axis(Json& json, const Json& axis, bool answers, std::size_t i) const;

  const RobotModel& model_;
  Instant now_;
};

Json flags_json(const tmc222::Flags& flags) {
  Json names = Json::array();
  for (const tmc222::FlagWord& word : tmc222::kFlagWords) {
    if (flags.*word.flag) names.push_back(word.name);
  }
  return names;
}

/// The 12 bytes in values.
void put_status(Json& json, const icp::Status& status) {
  const tmc222::Parameters& parameters = status.one.parameters;
  json["address"] = status.one.address;
  json["motion"] = tmc222::words(status.one.motion).name;
  json["temperature"] = tmc222::temperature_name(status.one.flags);
  json["flags"] = flags_json(status.one.flags);
  json["switch_closed"] = status.one.external_switch;
  json["actual_units"] = status.two.actual;
  json["target_units"] = status.two.target;
  json["secure_position"] = status.two.secure_position;
  json["run_current_ma"] = tmc222::kPeakCurrent[parameters.run_current];
  json["hold_current_ma"] = tmc222::kPeakCurrent[parameters.hold_current];
  json["velocity_max_steps_s"] = tmc222::kVelocityMax[parameters.velocity_max];
  json["velocity_min_steps_s"] = tmc222::velocity_min(parameters);
  json["acceleration_steps_s2"] = tmc222::kAcceleration[parameters.acceleration];
  json["microsteps"] = tmc222::microsteps(parameters.step_mode);
}

Json Teller::operator()(const IcpFacts& facts) const {
  Json json = base();
  json["legs"] = Json::array();
  for (std::size_t i = 0; i < facts.legs.size() && i < model_.joints.size(); ++i) {
    const IcpFacts::Leg& leg = facts.legs[i];
    Json one{{"joint", joint(i)}};
    if (leg.status) {
      one.update(heard(leg.status->at, icp::encode_status(leg.status->what)));
      put_status(one, leg.status->what);
    }
    if (leg.troubled) {
      Json trouble = heard(leg.troubled->at, icp::encode_status(leg.troubled->what));
      trouble["flags"] = flags_json(leg.troubled->what.one.flags);
      for (const Json& flag : trouble["flags"]) {
        warn(json, flag.get_ref<const std::string&>(), joint(i), age(leg.troubled->at));
      }
      one["last_trouble"] = std::move(trouble);
    }
    json["legs"].push_back(std::move(one));
  }
  return json;
}

Json Teller::servos(std::span<const lsc::ServoValue> values) const {
  const auto& device = model_.device.settings.get<LscDevice>();
  Json list = Json::array();
  for (const lsc::ServoValue& value : values) {
    Json one{{"servo", value.id}};
    for (std::size_t j = 0; j < device.servos.size(); ++j) {
      const LscServo& servo = device.servos[j];
      if (servo.id != value.id) continue;
      one["joint"] = joint(j);
      one["position_rad"] = (value.value - servo.centre - servo.trim) / servo.units_per_rad;
    }
    one["units"] = value.value;
    list.push_back(std::move(one));
  }
  return list;
}

Json Teller::group(const lsc::Bytes& bytes, std::uint8_t group, std::uint16_t times,
                   Instant at) const {
  Json json = heard(at, bytes);
  json["group"] = group;
  json["times"] = times;
  return json;
}

std::string_view name_of(LscProfile profile) {
  constexpr std::array<std::string_view, 3> kNames{"lsc6", "bus", "esp32"};
  return kNames[static_cast<std::size_t>(profile) % kNames.size()];
}

Json Teller::operator()(const LscFacts& facts) const {
  const auto& device = model_.device.settings.get<LscDevice>();
  const LscTiming limits;
  Json json = base();
  json["board"] = name_of(device.profile);
  json["unit"] = device.profile == LscProfile::kBus ? "bus" : "us";
  if (facts.battery) {
    const double volts = facts.battery->what.millivolts / 1000.0;
    json["battery"] = heard(facts.battery->at, lsc::encode(lsc::Reply{facts.battery->what}));
    json["battery"]["volts"] = volts;
    json["battery"]["notice_below_volts"] = limits.supply_notice_volts;
    json["battery"]["fault_below_volts"] = limits.supply_fault_volts;
    if (volts < limits.supply_notice_volts) warn(json, "battery_low");
  }
  if (facts.version) {
    json["version"] = heard(facts.version->at, lsc::encode(lsc::Reply{facts.version->what}));
    json["version"]["type"] = facts.version->what.type;
    json["version"]["version"] = facts.version->what.version;
  }
  if (facts.told) {
    json["told"] = heard(facts.told->at, lsc::encode(lsc::Request{facts.told->what}));
    json["told"]["time_ms"] = facts.told->what.time_ms;
    const lsc::ServoValues& values = facts.told->what.servos;
    json["told"]["servos"] = servos({values.data(), values.size()});
  }
  if (facts.positions) {
    const lsc::ServoValues& values = facts.positions->what;
    json["positions"] = {{"age_s", age(facts.positions->at)},
                         {"measured", device.profile == LscProfile::kBus},
                         {"servos", servos({values.data(), values.size()})}};
  }
  if (const auto& started = facts.group_started) {
    json["group_started"] = group(lsc::encode(lsc::Reply{started->what}), started->what.group,
                                  started->what.times, started->at);
    warn(json, "foreign_group", {}, age(started->at));
  }
  if (const auto& finished = facts.group_finished) {
    json["group_finished"] = group(lsc::encode(lsc::Reply{finished->what}), finished->what.group,
                                   finished->what.times, finished->at);
  }
  if (const auto& stopped = facts.group_stopped) {
    json["group_stopped"] = heard(stopped->at, lsc::encode(lsc::Reply{stopped->what}));
  }
  return json;
}

Json Teller::operator()(const MaxArmFacts& facts) const {
  const auto& device = model_.device.settings.get<MaxArmDevice>();
  Json json = base();
  json["board"] = device.variant == MaxArmVariant::kArduino ? "arduino" : "micropython";
  const auto sum = facts.checksum.value_or(maxarm::Checksum::kSpec);
  if (facts.checksum) json["checksum"] = sum == maxarm::Checksum::kSpec ? "spec" : "with_header";
  const auto pulses = [&](const auto& values) {
    Json list = Json::array();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const MaxArmServo& servo = device.servos[i];
      Json one{{"joint", joint(i)}, {"pulse", values[i]}};
      const bool dead = static_cast<int>(values[i]) == kDeadServo;
      if (!dead) one["position_rad"] = (values[i] - servo.offset) / servo.pulses_per_rad;
      list.push_back(std::move(one));
    }
    return list;
  };
  if (facts.angles) {
    json["angles"] = heard(facts.angles->at, maxarm::encode_reply(facts.angles->what, sum));
    json["angles"]["servos"] = pulses(facts.angles->what.pulses);
    for (std::size_t i = 0; i < maxarm::kServos; ++i) {
      if (facts.angles->what.pulses[i] == kDeadServo) warn(json, "servo_silent", joint(i));
    }
  }
  if (facts.position) {
    json["position"] = heard(facts.position->at, maxarm::encode_reply(facts.position->what, sum));
    json["position"]["xyz_mm"] = facts.position->what.xyz_mm;
  }
  if (facts.set) {
    json["told"] = heard(facts.set->at, maxarm::encode_request(facts.set->what));
    json["told"]["servos"] = pulses(facts.set->what.pulses);
    json["told"]["time_ms"] = facts.set->what.time_ms;
  }
  return json;
}

Json Teller::operator()(const BigRobotArmFacts& facts) const {
  Json json = base();
  const bool bytes = facts.wire == BigRobotArmWire::kByte;
  json["spoken"] = bytes                                        ? "byte"
                   : facts.dialect == BigRobotArmDialect::k2026 ? "text_2026"
                                                                : "text_2021";
  json["wants_declaration"] = facts.wants_declaration;
  if (facts.wants_declaration) warn(json, "wants_declaration");
  if (!facts.status) return json;
  const bigrobotarm::Status& status = facts.status->what;
  json["status"] = {{"age_s", age(facts.status->at)}};
  if (bytes && status.gripper) {
    json["status"]["bytes"] = hex(bigrobotarm::byte::encode_reply(status));
  }
  Json joints = Json::array();
  for (std::size_t i = 0; i < bigrobotarm::kJoints && i < model_.joints.size(); ++i) {
    joints.push_back({{"joint", joint(i)},
                      {"steps", status.positions[i]},
                      {"speed_rev_s", status.speeds[i] / 100.0},
                      {"acceleration_rev_s2", status.accelerations[i] / 100.0}});
  }
  json["status"]["joints"] = std::move(joints);
  if (status.gripper) {
    json["status"]["gripper"] = {{"enabled", status.gripper->enabled},
                                 {"servo_deg", status.gripper->position}};
  }
  json["status"]["sync"] = status.sync;
  json["looks_like_boot"] = facts.looks_like_boot;
  if (status.sync) warn(json, "sync_mode");
  if (facts.looks_like_boot) warn(json, "looks_like_boot");
  return json;
}

/// What both kinds of axis boards say in flags.
void Teller::judge_axis(Json& json, const Json& axis, bool answers, std::size_t i) const {
  if (!answers) return warn(json, "no_answer", joint(i));
  if (axis.contains("fault")) warn(json, "axis_fault", joint(i));
  if (!axis.contains("flags")) return;
  const Json& flags = axis["flags"];
  if (flags["emergency_stop"]) warn(json, "emergency_stop", joint(i));
  if (!flags["motor_ok"]) warn(json, "motor", joint(i));
  if (!flags["sensor_ok"]) warn(json, "encoder", joint(i));
  if (flags["end_stop"]) warn(json, "end_stop", joint(i));
  if (!flags["homed"]) warn(json, "not_homed", joint(i));
}

Json Teller::operator()(const AxisRegistersFacts& facts) const {
  using namespace axis_registers;
  const auto& device = model_.device.settings.get<AxisRegistersDevice>();
  Json json = base();
  json["reports_status"] = device.reports_status;
  json["axes"] = Json::array();
  for (std::size_t i = 0; i < facts.axes.size(); ++i) {
    const AxisRegistersFacts::Axis& axis = facts.axes[i];
    Json one{{"joint", joint(i)}, {"answers", axis.answers}};
    if (axis.fault) one["fault"] = error_json(*axis.fault, model_);
    one["registers"] = Json::array();
    for (std::size_t k = 0; k < axis.registers.size(); ++k) {
      if (!axis.registers[k]) continue;
      const auto& [value, at] = *axis.registers[k];
      const Register which = kDocumentRegisters[k].name;
      Json row{{"register", name(which)}, {"written", value.written}};
      row.update(heard(at, value.data));
      if (which == Register::kMoveAngle) {
        const auto told = read_angle(device.encoding, device.boards[i].zero, value.data);
        if (told) row["position_rad"] = told->q;
      } else if (which == Register::kDiagStatus) {
        if (const auto status = decode_status(value.data)) {
          for (const auto& word : kStatusWords)
            one["flags"][std::string(word.name)] = (*status).*word.flag;
          row["fault_number"] = status->fault;
        }
      } else if (value.data.size() == 1) {
        row["value"] = value.data[0];
      }
      one["registers"].push_back(std::move(row));
    }
    if (!device.reports_status) one.erase("flags");
    judge_axis(json, one, axis.answers, i);
    json["axes"].push_back(std::move(one));
  }
  return json;
}

Json Teller::operator()(const AxisLinkFacts& facts) const {
  using namespace axis_link;
  Json json = base();
  json["round_s"] = to_seconds(facts.round);
  json["axes"] = Json::array();
  for (std::size_t i = 0; i < facts.axes.size(); ++i) {
    const AxisLinkFacts::Axis& axis = facts.axes[i];
    Json one{{"joint", joint(i)}, {"answers", axis.up}, {"failed_frames", axis.failed_frames}};
    if (axis.fault) one["fault"] = error_json(*axis.fault, model_);
    if (axis.state) {
      const State& state = axis.state->what;
      one["age_s"] = age(axis.state->at);
      one["position_rad"] = from_units(state.position);
      one["velocity_rad_s"] = state.velocity / kStateVelocityUnits;
      one["position_units"] = state.position;
      one["velocity_units"] = state.velocity;
      if (axis.setpoint) {
        one["setpoint_rad"] = *axis.setpoint;
        one["following_error_rad"] = *axis.setpoint - from_units(state.position);
      }
      for (const auto& word : kStateWords) one["flags"][std::string(word.name)] = state.*word.flag;
      one["fault_number"] = state.fault;
      one["verdict"] = name(state.verdict);
    }
    if (axis.identity) {
      const Identity& identity = axis.identity->what;
      one["identity"] = {{"age_s", age(axis.identity->at)},
                         {"model_hash", identity.model_hash},
                         {"boot", identity.boot},
                         {"uncertainty_rad", identity.uncertainty / kUncertaintyUnits}};
    }
    if (axis.health) {
      Json health{{"age_s", age(axis.health->at)}};
      const Health& what = axis.health->what;
      if (what.supply_mv) health["supply_v"] = *what.supply_mv / 1000.0;
      if (what.temperature_c01) health["temperature_c"] = *what.temperature_c01 / 100.0;
      one["health"] = std::move(health);
    }
    if (axis.zero_shift) one["zero_shift_rad"] = *axis.zero_shift;
    judge_axis(json, one, axis.up, i);
    json["axes"].push_back(std::move(one));
  }
  return json;
}

Json Teller::operator()(const FeetechFacts& facts) const {
  using feetech::Trouble;
  constexpr std::pair<std::uint8_t, std::string_view> kTroubles[] = {
      {Trouble::kVoltage, "servo_voltage"}, {Trouble::kSensor, "servo_sensor"},
      {Trouble::kAngle, "servo_sensor"},    {Trouble::kHeat, "servo_heat"},
      {Trouble::kCurrent, "servo_current"}, {Trouble::kOverload, "servo_overload"}};
  const auto& device = model_.device.settings.get<FeetechDevice>();
  Json json = base();
  json["bus_servos"] = Json::array();
  for (std::size_t i = 0; i < facts.count; ++i) {
    const FeetechServoState& servo = facts.servos[i];
    const bool is_joint = i < model_.joints.size();
    const std::string name = is_joint ? joint(i) : "jaws";
    Json one{{"joint", name},
             {"servo", is_joint ? device.servos[i].id : device.gripper.id},
             {"answers", servo.known && servo.missed == 0}};
    if (!servo.known) {
      warn(json, "no_answer", name);
      json["bus_servos"].push_back(std::move(one));
      continue;
    }
    one.update({{"age_s", age(servo.at)},
                {"model", servo.model},
                {"firmware",
                 std::to_string(servo.firmware >> 8) + "." + std::to_string(servo.firmware & 0xFF)},
                {"motor_on", servo.torque},
                {"units", servo.units},
                {"goal_units", servo.goal},
                {"lowest_units", servo.lowest},
                {"highest_units", servo.highest},
                {"load", servo.load / 1000.0},
                {"torque_limit", servo.torque_limit / 1000.0},
                {"volts", servo.volts / 10.0},
                {"temperature_c", servo.heat},
                {"temperature_max_c", servo.hottest}});
    if (is_joint) {
      one["position_rad"] = device.q_of(i, servo.units);
    } else if (const JawGripper* jaws = jaws_of(model_)) {
      one["width_m"] = jaws->width_max * device.opening(servo.units);
    }
    for (const auto& [bits, what] : kTroubles) {
      if ((servo.trouble & bits) != 0) warn(json, what, name);
    }
    json["bus_servos"].push_back(std::move(one));
  }
  return json;
}

/// As `Facts`, where they are.
template <class Facts>
bool put(Json& json, const Teller& teller, const DeviceFacts& facts) {
  const auto* known = facts.as<Facts>();
  if (known != nullptr) json = teller(*known);
  return known != nullptr;
}

Json Teller::of(const DeviceFacts& facts) const {
  Json json = base();
  const bool known =
      put<IcpFacts>(json, *this, facts) || put<LscFacts>(json, *this, facts) ||
      put<MaxArmFacts>(json, *this, facts) || put<BigRobotArmFacts>(json, *this, facts) ||
      put<AxisRegistersFacts>(json, *this, facts) || put<AxisLinkFacts>(json, *this, facts) ||
      put<FeetechFacts>(json, *this, facts);
  SINEW_ASSERT(known || facts.empty());
  return json;
}

}  // namespace

Json device_json(const DeviceFacts& facts, const RobotModel& model, Instant now) {
  return Teller(model, now).of(facts);
}

Json frame_json(const runtime::WireMonitor::Frame& frame) {
  const WireMessage& message = frame.message;
  Json json{{"sequence", frame.sequence},
            {"at_s", to_seconds(message.at.time_since_epoch())},
            {"to", message.way == WireWay::kToDevice ? "device" : "host"}};
  if (message.select != 0) {
    json["axes"] = Json::array();
    for (int i = 0; i < 8; ++i) {
      if ((message.select >> i & 1) != 0) json["axes"].push_back(i + 1);
    }
  }
  json["hex"] = hex_of(message.bytes);
  json["name"] = message.name;
  Json fields = Json::array();
  for (const WireField& field : message.fields) {
    Json pair = Json::array({field.name});
    std::visit([&](const auto& value) { pair.push_back(value); }, field.value);
    fields.push_back(std::move(pair));
  }
  json["fields"] = std::move(fields);
  json["text"] = text_of(message);
  using Kind = WireMessage::Kind;
  json["kind"] = message.kind == Kind::kGood   ? "good"
                 : message.kind == Kind::kFill ? "fill"
                                               : "bad";
  return json;
}

}  // namespace sinew::server

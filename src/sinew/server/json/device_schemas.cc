#include "sinew/server/json/device_schemas.h"

#include <string>
#include <utility>

#include "sinew/devices/kinds.h"
#include "sinew/server/json/schema_words.h"

namespace sinew::server {

using namespace schema;

namespace {

/// The names of all kinds of devices.
Json wires() {
  Json names = Json::array();
  for (const DeviceKind* kind : device_kinds()) names.push_back(kind->table.protocol);
  return {{"type", "string"}, {"enum", std::move(names)}};
}
/// With its age and its bytes, as hex.
Json heard(Fields always = {}) {
  Json json = object(always);
  for (const auto& [name, schema] : {std::pair{"age_s", number()}, {"bytes", text()}}) {
    json["properties"][name] = schema;
    json["required"].push_back(name);
  }
  return json;
}

void put_axes(Json& all) {
  all["AxisRegister"] = heard({{"register", text()}, {"written", flag()}});
  all["AxisRegister"]["properties"].update(
      {{"position_rad", number()}, {"fault_number", whole()}, {"value", integer()}});
  all["AxisStatus"] =
      told("Of one axis board, as its registers or its link tell it.",
           object({{"joint", text()}, {"answers", flag()}},
                  {{"failed_frames", whole()},
                   {"late_frames", whole()},
                   {"fault", ref("Error")},
                   {"age_s", number()},
                   {"position_rad", number()},
                   {"velocity_rad_s", number()},
                   {"position_units", integer()},
                   {"velocity_units", integer()},
                   {"setpoint_rad", number()},
                   {"following_error_rad", number()},
                   {"flags", table(flag())},
                   {"fault_number", whole()},
                   {"verdict", text()},
                   {"identity", object({{"age_s", number()},
                                        {"model_hash", whole()},
                                        {"boot", whole()},
                                        {"uncertainty_rad", number()}})},
                   {"health", object({{"age_s", number()}}, {{"supply_v", number()},
                                                             {"temperature_c", number()},
                                                             {"motor_magnet", text()},
                                                             {"joint_magnet", text()}})},
                   {"zero_shift_rad", number()},
                   {"registers", list(ref("AxisRegister"))}}));
}

void put_legs(Json& all) {
  all["LegStatus"] =
      told("The last 12 bytes of a motor's controller, and what they say.",
           object({{"joint", text()}}, {{"age_s", number()},
                                        {"bytes", text()},
                                        {"address", whole()},
                                        {"motion", text()},
                                        {"temperature", text()},
                                        {"flags", list(text())},
                                        {"switch_closed", flag()},
                                        {"actual_units", integer()},
                                        {"target_units", integer()},
                                        {"secure_position", integer()},
                                        {"run_current_ma", number()},
                                        {"hold_current_ma", number()},
                                        {"velocity_max_steps_s", number()},
                                        {"velocity_min_steps_s", number()},
                                        {"acceleration_steps_s2", number()},
                                        {"microsteps", whole()},
                                        {"last_trouble", heard({{"flags", list(text())}})}}));
}

void put_bus_servos(Json& all) {
  all["BusServo"] = object({{"joint", text()}, {"servo", whole()}, {"answers", flag()}},
                           {{"age_s", number()},
                            {"model", whole()},
                            {"firmware", text()},
                            {"motor_on", flag()},
                            {"position_rad", number()},
                            {"width_m", number()},
                            {"units", integer()},
                            {"goal_units", integer()},
                            {"lowest_units", integer()},
                            {"highest_units", integer()},
                            {"load", number()},
                            {"torque_limit", number()},
                            {"volts", number()},
                            {"temperature_c", number()},
                            {"temperature_max_c", number()}});
}

void put_inputs(Json& all) {
  all["DeviceInputs"] = object({{"age_s", number()},
                                {"state", text()},
                                {"probe", flag()},
                                {"door", flag()},
                                {"hold", flag()},
                                {"reset", flag()},
                                {"start", flag()},
                                {"emergency_stop", flag()},
                                {"end_stops", list(text())}});
  all["DeviceTouch"] =
      object({{"age_s", number()}, {"joint", text()}}, {}, {{of_joint("position"), number()}});
}

void put_big_robot_arm(Json& all) {
  all["SequenceStatus"] = object(
      {{"age_s", number()},
       {"sync", flag()},
       {"joints", list(object({{"joint", text()},
                               {"steps", integer()},
                               {"speed_rev_s", number()},
                               {"acceleration_rev_s2", number()}}))}},
      {{"bytes", text()}, {"gripper", object({{"enabled", flag()}, {"servo_deg", number()}})}});
  all["ArmState"] = object({{"age_s", number()},
                            {"session", whole()},
                            {"moving", flag()},
                            {"stop_line", flag()},
                            {"fault", text()},
                            {"reference", text()},
                            {"queued_ms", whole()},
                            {"gripper", object({{"enabled", flag()}, {"servo_deg", number()}})},
                            {"joints", list(object({{"joint", text()}, {"steps", number()}}))}});
  all["BoardImage"] =
      object({{"age_s", number()}, {"board", text()}, {"version", text()}, {"checksum", whole()}});
  all["BoardStatistics"] = object({{"age_s", number()},
                                   {"starts", whole()},
                                   {"stack_free_bytes", whole()},
                                   {"late_slices", whole()},
                                   {"loop_us_max", whole()},
                                   {"bytes_lost", whole()},
                                   {"frames_bad", whole()}});
}

void put_wire(Json& all) {
  all["WireFrame"] = object({{"sequence", whole()},
                             {"at_s", number()},
                             {"to", one_of({"device", "host"})},
                             {"hex", text()},
                             {"name", text()},
                             {"fields", told("Pairs of a name and a value.", list(list(true)))},
                             {"text", text()},
                             {"kind", one_of({"good", "fill", "bad"})}},
                            {{"axes", list(whole())}});
  all["WireFrames"] = object({{"frames", list(ref("WireFrame"))},
                              {"last", whole()},
                              {"lost", whole()},
                              {"at_s", number()}});
}

}  // namespace

void put_device(Json& all) {
  put_inputs(all);
  put_axes(all);
  put_legs(all);
  all["ServoValue"] = object({}, {{"servo", whole()},
                                  {"joint", text()},
                                  {"units", integer()},
                                  {"pulse", integer()},
                                  {"position_rad", number()}});
  const Json group = heard({{"group", whole()}, {"times", whole()}});
  const Json servos = list(ref("ServoValue"));
  put_big_robot_arm(all);
  put_bus_servos(all);
  all["Device"] = told(
      "What there is beside the first five depends on its wire.",
      object(
          {{"robot", text()},
           {"port", text()},
           {"wire", wires()},
           {"at_s", number()},
           {"warnings",
            list(object({{"name", text()}}, {{"joint", text()}, {"age_s", number()}}))}},
          {{"legs", list(ref("LegStatus"))},
           {"board", text()},
           {"unit", one_of({"bus", "us"})},
           {"battery", heard({{"volts", number()},
                              {"notice_below_volts", number()},
                              {"fault_below_volts", number()}})},
           {"version", heard({{"type", whole()}, {"version", whole()}})},
           {"told", heard({{"servos", servos}, {"time_ms", whole()}})},
           {"positions", object({{"age_s", number()}, {"measured", flag()}, {"servos", servos}})},
           {"group_started", group},
           {"group_finished", group},
           {"group_stopped", heard()},
           {"checksum", one_of({"spec", "with_header"})},
           {"angles", heard({{"servos", servos}})},
           {"position", heard({{"xyz_mm", numbers(3)}})},
           {"spoken", one_of({"byte", "text_2021", "text_2026"})},
           {"wants_declaration", flag()},
           {"looks_like_boot", flag()},
           {"status", ref("SequenceStatus")},
           {"arm", ref("ArmState")},
           {"image", ref("BoardImage")},
           {"statistics", ref("BoardStatistics")},
           {"reports_status", flag()},
           {"round_s", number()},
           {"axes", list(ref("AxisStatus"))},
           {"bus_servos", list(ref("BusServo"))},
           {"firmware", one_of({"grbl", "grblhal", "fluidnc"})},
           {"inputs", ref("DeviceInputs")},
           {"touched", ref("DeviceTouch")}}));
  put_wire(all);
}

}  // namespace sinew::server

#include "sinew/devices/feetech/feetech_view.h"

#include "sinew/devices/feetech/feetech_driver_facts.h"
#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/model/hand.h"

namespace sinew {

FactsJson feetech_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<FeetechFacts>();
  using feetech::Trouble;
  constexpr std::pair<std::uint8_t, std::string_view> kTroubles[] = {
      {Trouble::kVoltage, "servo_voltage"}, {Trouble::kSensor, "servo_sensor"},
      {Trouble::kAngle, "servo_sensor"},    {Trouble::kHeat, "servo_heat"},
      {Trouble::kCurrent, "servo_current"}, {Trouble::kOverload, "servo_overload"}};
  const auto& device = view.model().device.settings.get<FeetechDevice>();
  FactsJson json = view.base();
  json["bus_servos"] = FactsJson::array();
  for (std::size_t i = 0; i < facts.count; ++i) {
    const FeetechServoState& servo = facts.servos[i];
    const bool is_joint = i < view.model().joints.size();
    const std::string name = is_joint ? view.joint(i) : "jaws";
    FactsJson one{{"joint", name},
                  {"servo", is_joint ? device.servos[i].id : device.gripper.id},
                  {"answers", servo.known && servo.missed == 0}};
    if (!servo.known) {
      FactsView::warn(json, "no_answer", name);
      json["bus_servos"].push_back(std::move(one));
      continue;
    }
    one.update({{"age_s", view.age(servo.at)},
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
    } else if (const JawGripper* jaws = jaws_of(view.model())) {
      one["width_m"] = jaws->width_max * device.opening(servo.units);
    }
    for (const auto& [bits, what] : kTroubles) {
      if ((servo.trouble & bits) != 0) FactsView::warn(json, what, name);
    }
    json["bus_servos"].push_back(std::move(one));
  }
  return json;
}

}  // namespace sinew

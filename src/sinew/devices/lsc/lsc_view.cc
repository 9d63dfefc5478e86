#include "sinew/devices/lsc/lsc_view.h"

#include <span>

#include "sinew/devices/lsc/lsc_driver.h"
#include "sinew/devices/lsc/lsc_settings.h"

namespace sinew {
namespace {

FactsJson servos_of(const FactsView& view, std::span<const lsc::ServoValue> values) {
  const auto& device = view.model().device.settings.get<LscDevice>();
  FactsJson list = FactsJson::array();
  for (const lsc::ServoValue& value : values) {
    FactsJson one{{"servo", value.id}};
    for (std::size_t j = 0; j < device.servos.size(); ++j) {
      const LscServo& servo = device.servos[j];
      if (servo.id != value.id) continue;
      one["joint"] = view.joint(j);
      one["position_rad"] = (value.value - servo.centre - servo.trim) / servo.units_per_rad;
    }
    one["units"] = value.value;
    list.push_back(std::move(one));
  }
  return list;
}

FactsJson group_of(const FactsView& view, const lsc::Bytes& bytes, std::uint8_t group,
                   std::uint16_t times, Instant at) {
  FactsJson json = view.heard(at, bytes);
  json["group"] = group;
  json["times"] = times;
  return json;
}

}  // namespace

FactsJson lsc_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<LscFacts>();
  const auto& device = view.model().device.settings.get<LscDevice>();
  const LscTiming limits;
  FactsJson json = view.base();
  json["board"] = device.profiles().front();
  json["unit"] = device.profile == LscProfile::kBus ? "bus" : "us";
  if (facts.battery) {
    const double volts = facts.battery->what.millivolts / 1000.0;
    json["battery"] = view.heard(facts.battery->at, lsc::encode(lsc::Reply{facts.battery->what}));
    json["battery"]["volts"] = volts;
    json["battery"]["notice_below_volts"] = limits.supply_notice_volts;
    json["battery"]["fault_below_volts"] = limits.supply_fault_volts;
    if (volts < limits.supply_notice_volts) FactsView::warn(json, "battery_low");
  }
  if (facts.version) {
    json["version"] = view.heard(facts.version->at, lsc::encode(lsc::Reply{facts.version->what}));
    json["version"]["type"] = facts.version->what.type;
    json["version"]["version"] = facts.version->what.version;
  }
  if (facts.told) {
    json["told"] = view.heard(facts.told->at, lsc::encode(lsc::Request{facts.told->what}));
    json["told"]["time_ms"] = facts.told->what.time_ms;
    const lsc::ServoValues& values = facts.told->what.servos;
    json["told"]["servos"] = servos_of(view, {values.data(), values.size()});
  }
  if (facts.positions) {
    const lsc::ServoValues& values = facts.positions->what;
    json["positions"] = {{"age_s", view.age(facts.positions->at)},
                         {"measured", device.profile == LscProfile::kBus},
                         {"servos", servos_of(view, {values.data(), values.size()})}};
  }
  if (const auto& started = facts.group_started) {
    json["group_started"] = group_of(view, lsc::encode(lsc::Reply{started->what}),
                                     started->what.group, started->what.times, started->at);
    FactsView::warn(json, "foreign_group", {}, view.age(started->at));
  }
  if (const auto& finished = facts.group_finished) {
    json["group_finished"] = group_of(view, lsc::encode(lsc::Reply{finished->what}),
                                      finished->what.group, finished->what.times, finished->at);
  }
  if (const auto& stopped = facts.group_stopped) {
    json["group_stopped"] = view.heard(stopped->at, lsc::encode(lsc::Reply{stopped->what}));
  }
  return json;
}

}  // namespace sinew

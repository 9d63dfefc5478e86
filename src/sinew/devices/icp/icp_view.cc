#include "sinew/devices/icp/icp_view.h"

#include "sinew/devices/icp/icp_driver_facts.h"
#include "sinew/devices/icp/tmc222_wire_words.h"

namespace sinew {
namespace {

FactsJson flags_json(const tmc222::Flags& flags) {
  FactsJson names = FactsJson::array();
  for (const tmc222::FlagWord& word : tmc222::kFlagWords) {
    if (flags.*word.flag) names.push_back(word.name);
  }
  return names;
}

/// The 12 bytes in values.
void put_status(FactsJson& json, const icp::Status& status) {
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

}  // namespace

FactsJson icp_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<IcpFacts>();
  FactsJson json = view.base();
  json["legs"] = FactsJson::array();
  for (std::size_t i = 0; i < facts.legs.size() && i < view.model().joints.size(); ++i) {
    const IcpFacts::Leg& leg = facts.legs[i];
    FactsJson one{{"joint", view.joint(i)}};
    if (leg.status) {
      one.update(view.heard(leg.status->at, icp::encode_status(leg.status->what)));
      put_status(one, leg.status->what);
    }
    if (leg.troubled) {
      FactsJson trouble = view.heard(leg.troubled->at, icp::encode_status(leg.troubled->what));
      trouble["flags"] = flags_json(leg.troubled->what.one.flags);
      for (const FactsJson& flag : trouble["flags"]) {
        FactsView::warn(json, flag.get_ref<const std::string&>(), view.joint(i),
                        view.age(leg.troubled->at));
      }
      one["last_trouble"] = std::move(trouble);
    }
    json["legs"].push_back(std::move(one));
  }
  return json;
}

}  // namespace sinew

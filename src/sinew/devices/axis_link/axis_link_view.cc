#include "sinew/devices/axis_link/axis_link_view.h"

#include "sinew/devices/axis/axis_view.h"
#include "sinew/devices/axis/axis_wire_words.h"
#include "sinew/devices/axis_link/axis_link_driver_facts.h"

namespace sinew {

FactsJson axis_link_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<AxisLinkFacts>();
  using namespace axis_link;
  FactsJson json = view.base();
  json["round_s"] = to_seconds(facts.round);
  json["axes"] = FactsJson::array();
  for (std::size_t i = 0; i < facts.axes.size(); ++i) {
    const AxisLinkFacts::Axis& axis = facts.axes[i];
    FactsJson one{{"joint", view.joint(i)},
                  {"answers", axis.up},
                  {"failed_frames", axis.failed_frames},
                  {"late_frames", axis.late_frames}};
    if (axis.fault) one["fault"] = view.error(*axis.fault);
    if (axis.state) {
      const State& state = axis.state->what;
      one["age_s"] = view.age(axis.state->at);
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
      one["identity"] = {{"age_s", view.age(axis.identity->at)},
                         {"model_hash", identity.model_hash},
                         {"boot", identity.boot},
                         {"uncertainty_rad", identity.uncertainty / kUncertaintyUnits}};
    }
    if (axis.health) {
      FactsJson health{{"age_s", view.age(axis.health->at)}};
      const Health& what = axis.health->what;
      if (what.supply_mv) health["supply_v"] = *what.supply_mv / 1000.0;
      if (what.temperature_c01) health["temperature_c"] = *what.temperature_c01 / 100.0;
      if (what.motor_magnet != Magnet::kUnknown) {
        health["motor_magnet"] = magnet_word(what.motor_magnet);
      }
      if (what.joint_magnet != Magnet::kUnknown) {
        health["joint_magnet"] = magnet_word(what.joint_magnet);
      }
      one["health"] = std::move(health);
      if (needs_attention(what.motor_magnet) || needs_attention(what.joint_magnet)) {
        FactsView::warn(json, "magnet", view.joint(i));
      }
    }
    if (axis.zero_shift) one["zero_shift_rad"] = *axis.zero_shift;
    judge_axis(view, json, one, axis.up, i);
    json["axes"].push_back(std::move(one));
  }
  return json;
}

}  // namespace sinew

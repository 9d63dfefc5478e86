#include "sinew/devices/grbl/grbl_view.h"

#include "sinew/devices/grbl/grbl_driver_facts.h"
#include "sinew/devices/grbl/grbl_settings.h"

namespace sinew {

FactsJson grbl_view(const FactsView& view, const DeviceFacts& all) {
  constexpr std::pair<std::string_view, bool grbl::Pins::*> kPins[] = {
      {"probe", &grbl::Pins::probe}, {"door", &grbl::Pins::door},
      {"hold", &grbl::Pins::hold},   {"reset", &grbl::Pins::reset},
      {"start", &grbl::Pins::start}, {"emergency_stop", &grbl::Pins::emergency_stop}};
  const auto& facts = all.get<GrblFacts>();
  FactsJson json = view.base();
  if (!facts.board) return json;
  json["firmware"] = kGrblFirmwares[static_cast<std::size_t>(facts.firmware)];
  const grbl::Pins& pins = facts.board->what.pins;
  FactsJson inputs{{"age_s", view.age(facts.board->at)},
                   {"state", grbl::word_of(facts.board->what.state)}};
  for (const auto& [name, pin] : kPins) inputs[name] = pins.*pin;
  inputs["end_stops"] = FactsJson::array();
  for (std::size_t i = 0; i < view.model().joints.size(); ++i) {
    if ((pins.limits >> i & 1) == 0) continue;
    inputs["end_stops"].push_back(view.joint(i));
    FactsView::warn(json, "end_stop", view.joint(i));
  }
  if (pins.emergency_stop) FactsView::warn(json, "emergency_stop");
  json["inputs"] = std::move(inputs);
  if (facts.touched) {
    const auto& [joint, q] = facts.touched->what;
    const bool slides = view.model().joints[joint].slides();
    json["touched"] = {{"age_s", view.age(facts.touched->at)}, {"joint", view.joint(joint)}};
    if (q) json["touched"][slides ? "position_m" : "position_rad"] = *q;
  }
  return json;
}

}  // namespace sinew

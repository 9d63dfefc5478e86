#include "sinew/devices/arm_link/arm_link_view.h"

#include "sinew/devices/arm_link/arm_link_driver_facts.h"
#include "sinew/devices/arm_link/arm_link_wire_words.h"

namespace sinew {

FactsJson arm_link_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<ArmLinkFacts>();
  FactsJson json = view.base();
  json["wants_declaration"] = facts.wants_declaration;
  if (facts.wants_declaration) FactsView::warn(json, "wants_declaration");
  if (facts.image) {
    const BoardImage& image = facts.image->what;
    json["image"] = {{"age_s", view.age(facts.image->at)},
                     {"board", image.board_name()},
                     {"version", image.version_text()},
                     {"checksum", image.checksum}};
  }
  if (facts.statistics) {
    const mcu::arm_link::Reply& told = facts.statistics->what;
    json["statistics"] = {{"age_s", view.age(facts.statistics->at)},
                          {"starts", told.starts},
                          {"stack_free_bytes", told.stack_free},
                          {"late_slices", told.late_slices},
                          {"loop_us_max", told.loop_us_max},
                          {"bytes_lost", told.bytes_lost},
                          {"frames_bad", told.frames_bad}};
  }
  if (!facts.state) return json;
  const mcu::arm_link::Reply& state = facts.state->what;
  FactsJson joints = FactsJson::array();
  for (std::size_t i = 0; i < mcu::kArmAxes && i < view.model().joints.size(); ++i) {
    joints.push_back(
        {{"joint", view.joint(i)}, {"steps", state.positions[i] / double{mcu::kUnitsPerStep}}});
  }
  json["arm"] = {{"age_s", view.age(facts.state->at)},
                 {"session", state.session},
                 {"moving", state.moving},
                 {"stop_line", state.stop_line},
                 {"fault", arm_link::name(state.fault)},
                 {"reference", arm_link::name(state.reference)},
                 {"queued_ms", state.queued_ms},
                 {"gripper",
                  {{"enabled", state.gripper_on},
                   {"servo_deg", state.gripper / double{mcu::kServoUnitsPerDegree}}}},
                 {"joints", std::move(joints)}};
  if (state.stop_line) FactsView::warn(json, "stop_line");
  return json;
}

}  // namespace sinew

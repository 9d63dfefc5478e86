#include "sinew/devices/bigrobotarm/bigrobotarm_view.h"

#include "sinew/devices/bigrobotarm/bigrobotarm_driver_facts.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"

namespace sinew {

FactsJson bigrobotarm_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<BigRobotArmFacts>();
  FactsJson json = view.base();
  const bool bytes = facts.wire == BigRobotArmWire::kByte;
  json["spoken"] = bytes                                        ? "byte"
                   : facts.dialect == BigRobotArmDialect::k2026 ? "text_2026"
                                                                : "text_2021";
  json["wants_declaration"] = facts.wants_declaration;
  if (facts.wants_declaration) FactsView::warn(json, "wants_declaration");
  if (!facts.status) return json;
  const bigrobotarm::Status& status = facts.status->what;
  json["status"] = {{"age_s", view.age(facts.status->at)}};
  if (bytes && status.gripper) {
    json["status"]["bytes"] = FactsView::hex(bigrobotarm::byte::encode_reply(status));
  }
  FactsJson joints = FactsJson::array();
  for (std::size_t i = 0; i < bigrobotarm::kJoints && i < view.model().joints.size(); ++i) {
    joints.push_back({{"joint", view.joint(i)},
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
  if (status.sync) FactsView::warn(json, "sync_mode");
  if (facts.looks_like_boot) FactsView::warn(json, "looks_like_boot");
  return json;
}

}  // namespace sinew

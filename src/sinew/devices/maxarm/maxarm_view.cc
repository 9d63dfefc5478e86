#include "sinew/devices/maxarm/maxarm_view.h"

#include "sinew/devices/maxarm/maxarm_driver_facts.h"
#include "sinew/devices/maxarm/maxarm_settings.h"

namespace sinew {
namespace {

constexpr std::int16_t kDeadServo = -1;  ///< what a MaxArm replies for a servo that does not

}  // namespace

FactsJson maxarm_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<MaxArmFacts>();
  const auto& device = view.model().device.settings.get<MaxArmDevice>();
  FactsJson json = view.base();
  json["board"] = device.variant == MaxArmVariant::kArduino ? "arduino" : "micropython";
  const auto sum = facts.checksum.value_or(maxarm::Checksum::kSpec);
  if (facts.checksum) json["checksum"] = sum == maxarm::Checksum::kSpec ? "spec" : "with_header";
  const auto pulses = [&](const auto& values) {
    FactsJson list = FactsJson::array();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const MaxArmServo& servo = device.servos[i];
      FactsJson one{{"joint", view.joint(i)}, {"pulse", values[i]}};
      const bool dead = static_cast<int>(values[i]) == kDeadServo;
      if (!dead) one["position_rad"] = (values[i] - servo.offset) / servo.pulses_per_rad;
      list.push_back(std::move(one));
    }
    return list;
  };
  if (facts.angles) {
    json["angles"] = view.heard(facts.angles->at, maxarm::encode_reply(facts.angles->what, sum));
    json["angles"]["servos"] = pulses(facts.angles->what.pulses);
    for (std::size_t i = 0; i < maxarm::kServos; ++i) {
      if (facts.angles->what.pulses[i] == kDeadServo)
        FactsView::warn(json, "servo_silent", view.joint(i));
    }
  }
  if (facts.position) {
    json["position"] =
        view.heard(facts.position->at, maxarm::encode_reply(facts.position->what, sum));
    json["position"]["xyz_mm"] = facts.position->what.xyz_mm;
  }
  if (facts.set) {
    json["told"] = view.heard(facts.set->at, maxarm::encode_request(facts.set->what));
    json["told"]["servos"] = pulses(facts.set->what.pulses);
    json["told"]["time_ms"] = facts.set->what.time_ms;
  }
  return json;
}

}  // namespace sinew

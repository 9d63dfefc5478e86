#include "sinew/server/json/device_json.h"

#include "sinew/devices/facts_view.h"
#include "sinew/devices/kinds.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {

Json device_json(const DeviceFacts& facts, const RobotModel& model, Instant now) {
  const FactsView view(model, now, error_json);
  const auto own = kind_of(model.device).view;
  return own != nullptr && !facts.empty() ? own(view, facts) : view.base();
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

#include "sinew/devices/maxarm/maxarm_listener.h"

#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace maxarm;

Told read(const Request& request) {
  Told told = std::visit(
      Cases{[](const SetAngle& m) {
              return Told{"set_angle", {list("pulses", m.pulses), whole("time_ms", m.time_ms)}};
            },
            [](const SetXyz& m) {
              return Told{"set_xyz", {list("xyz_mm", m.xyz_mm), whole("time_ms", m.time_ms)}};
            },
            [](const SetPwmServo& m) {
              return Told{"set_nozzle",
                          {whole("pulse_us", m.pulse_us), whole("time_ms", m.time_ms)}};
            },
            [](const SetSuction& m) {
              constexpr std::array<std::string_view, 4> kActions{"none", "on", "release", "off"};
              return Told{"set_suction", {word("action", kActions[m.action % kActions.size()])}};
            },
            [](const ReadAngle&) { return Told{"read_angle"}; },
            [](const ReadXyz&) { return Told{"read_xyz"}; }},
      request);
  told.size = encode_request(request).size();
  return told;
}

Told read(const ReplyFrame& frame) {
  Told told =
      std::visit(Cases{[](const Angles& m) { return Told{"angles", {list("pulses", m.pulses)}}; },
                       [](const Position& m) { return Told{"xyz", {list("xyz_mm", m.xyz_mm)}}; }},
                 frame.reply);
  told.fields.push_back(
      word("checksum", frame.checksum == Checksum::kSpec ? "spec" : "with_header"));
  told.size = kReplyFrame;
  return told;
}

class MaxArmReader : public StreamReader {
 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    if (way == WireWay::kToDevice) {
      const auto request = requests_.push(byte);
      return request ? std::optional(wires::read(*request)) : std::nullopt;
    }
    const auto reply = replies_.push(byte);
    return reply ? std::optional(wires::read(*reply)) : std::nullopt;
  }
  bool between(WireWay way) const override {
    return way == WireWay::kToDevice ? requests_.at_boundary() : replies_.at_boundary();
  }
  void reset(WireWay way) override {
    way == WireWay::kToDevice ? requests_.reset() : replies_.reset();
  }

 private:
  RequestDecoder requests_;
  ReplyDecoder replies_;
};

}  // namespace

std::unique_ptr<WireReader> maxarm_reader() {
  return std::make_unique<MaxArmReader>();
}

}  // namespace sinew::wires

#include "sinew/devices/icp/icp_listener.h"

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/icp/tmc222_wire_words.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace icp;
using Due = ReplyDecoder::Due;

std::string_view name_of(Refusal why) {
  constexpr std::array<std::string_view, 3> kNames{"ones", "parity", "no_motor"};
  return kNames[static_cast<std::size_t>(why) % kNames.size()];
}

/// What a byte means means something to the next ones in both ways.
class IcpReader : public StreamReader {
 public:
  explicit IcpReader(Dialect dialect) : dialect_(dialect), requests_(dialect) {}

 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    return way == WireWay::kToDevice ? request(byte) : reply(byte);
  }
  bool between(WireWay way) const override {
    return way == WireWay::kToDevice || replies_.due() == Due::kNothing;
  }
  void reset(WireWay way) override {
    if (way == WireWay::kToHost) return replies_.expect(Due::kNothing);
    requests_ = RequestDecoder(dialect_);
  }

 private:
  Told request(std::uint8_t byte) {
    const auto read = requests_.push(byte);
    replies_.expect(Due::kNothing);
    if (!read) return bad("ignored");
    replies_.expect(Due::kByte);
    if (!*read) return bad("refused", {word("why", name_of(read->error()))});
    return std::visit(Cases{[](const Init&) { return Told{"open"}; },
                            [this](const Sync&) {
                              replies_.expect(Due::kNothing);
                              return Told{"sync"};
                            },
                            [](const Wake&) { return Told{"wake"}; },
                            [this](const Kill&) {
                              replies_.expect(Due::kNothing);
                              // It hears nothing until its power was cut; what is said to it then
                              // is read anew.
                              requests_ = RequestDecoder(dialect_);
                              return Told{"shut_down"};
                            },
                            [](const StatusRequest&) { return Told{"ask_status"}; },
                            [](const Step& step) {
                              return Told{
                                  "step",
                                  {whole("motor", step.motor), whole("direction", step.direction)}};
                            },
                            [this](const Select& select) {
                              selected_ = select.motor;
                              replies_.expect(Due::kBlock);
                              return Told{"select", {whole("motor", select.motor)}};
                            }},
                      **read);
  }

  std::optional<Told> reply(std::uint8_t byte) {
    if (replies_.due() == Due::kNothing) return bad("unasked");
    const auto read = replies_.push(byte);
    if (!read) return std::nullopt;
    if (!*read) return bad("damaged");
    if (const auto* status = std::get_if<Status>(&**read)) return told(*status);
    if (const auto* refused = std::get_if<Refused>(&**read)) {
      return Told{"refused", {word("why", name_of(refused->why))}};
    }
    return Told{"ack"};
  }

  Told told(const Status& status) const {
    std::string flags;
    for (const tmc222::FlagWord& word : tmc222::kFlagWords) {
      if (status.one.flags.*word.flag) flags += (flags.empty() ? "" : " ") + std::string(word.name);
    }
    return {"status",
            {whole("motor", selected_), word("motion", tmc222::words(status.one.motion).name),
             whole("actual", status.two.actual), whole("target", status.two.target),
             word("temperature", tmc222::temperature_name(status.one.flags)),
             word("flags", flags.empty() ? "none" : flags)}};
  }

  Dialect dialect_;
  RequestDecoder requests_;
  ReplyDecoder replies_;
  std::uint8_t selected_ = 0;
};

}  // namespace

std::unique_ptr<WireReader> icp_reader(const IcpDevice& device) {
  return std::make_unique<IcpReader>(
      Dialect{device.firmware.knows_wake, device.firmware.checks_selector});
}

}  // namespace sinew::wires

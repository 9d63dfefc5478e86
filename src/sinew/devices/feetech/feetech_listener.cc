#include "sinew/devices/feetech/feetech_listener.h"

#include <array>

#include "sinew/devices/feetech/feetech_wire.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace feetech;

WireField data(const Data& bytes) {
  return word("bytes", hex_of({bytes.begin(), bytes.end()}));
}

/// "1:2048 2:1980": what a common write says to each; positions where it is one of goals.
WireField parts(const SyncWrite& write, std::endian order) {
  const std::size_t goal = Register::kGoal - write.address;
  const bool goals = write.address <= Register::kGoal && !write.parts.empty() &&
                     write.parts[0].data.size() >= goal + 2;
  std::string text;
  for (const SyncWrite::Part& part : write.parts) {
    text += (text.empty() ? "" : " ") + std::to_string(part.id) + ":";
    const std::span bytes(part.data.data(), part.data.size());
    text += goals ? std::to_string(signed_word(word_at(bytes, goal, order), kPositionSign))
                  : hex_of({bytes.begin(), bytes.end()});
  }
  return word("servos", text);
}

Told read(const Request& request, std::endian order) {
  return std::visit(
      Cases{[](const Ping& m) { return Told{"ping", {whole("servo", m.id)}}; },
            [](const Read& m) {
              return Told{
                  "read",
                  {whole("servo", m.id), whole("register", m.address), whole("count", m.count)}};
            },
            [](const Write& m) {
              return Told{m.waits ? "write_later" : "write",
                          {whole("servo", m.id), whole("register", m.address), data(m.data)}};
            },
            [](const Action& m) { return Told{"action", {whole("servo", m.id)}}; },
            [](const SetMiddle& m) { return Told{"set_middle", {whole("servo", m.id)}}; },
            [](const SyncRead& m) {
              return Told{
                  "read_all",
                  {whole("register", m.address), whole("count", m.count), list("servos", m.ids)}};
            },
            [&](const SyncWrite& m) {
              return Told{"write_all", {whole("register", m.address), parts(m, order)}};
            }},
      request);
}

class FeetechReader : public StreamReader {
 public:
  explicit FeetechReader(std::endian order) : order_(order) {}

 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    PacketDecoder& packets = at(way);
    const PacketDecoder::Result result = packets.push(byte);
    if (result == PacketDecoder::Result::kMore) return std::nullopt;
    if (result == PacketDecoder::Result::kDamaged) return bad("damaged");
    const Packet& packet = packets.packet();
    Told told = bad("unknown", {whole("servo", packet.id), whole("what", packet.what)});
    if (way == WireWay::kToDevice) {
      if (const auto request = decode_request(packet)) told = wires::read(*request, order_);
    } else if (const auto reply = decode_reply(packet)) {
      told = {"reply", {whole("servo", reply->id)}};
      if (reply->trouble != 0) told.fields.push_back(whole("trouble", reply->trouble));
      if (!reply->data.empty()) told.fields.push_back(data(reply->data));
    }
    told.size = 6 + packet.parameters.size();
    return told;
  }
  bool between(WireWay way) const override {
    return packets_[static_cast<std::size_t>(way)].at_boundary();
  }
  void reset(WireWay way) override { at(way).reset(); }

 private:
  PacketDecoder& at(WireWay way) { return packets_[static_cast<std::size_t>(way)]; }

  std::endian order_;
  std::array<PacketDecoder, 2> packets_;
};

}  // namespace

std::unique_ptr<WireReader> feetech_reader(const FeetechDevice& device) {
  return std::make_unique<FeetechReader>(device.byte_order());
}

}  // namespace sinew::wires

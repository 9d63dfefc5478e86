#include "sinew/devices/lsc/lsc_listener.h"

#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace lsc;

/// "1:1500 2:1480"
WireField servos(const auto& values) {
  std::string text;
  for (const ServoValue& one : values) {
    text += (text.empty() ? "" : " ") + std::to_string(one.id) + ":" + std::to_string(one.value);
  }
  return word("servos", text);
}
WireField offsets(const auto& values) {
  std::string text;
  for (const ServoOffset& one : values) {
    text += (text.empty() ? "" : " ") + std::to_string(one.id) + ":" + std::to_string(one.offset);
  }
  return word("offsets", text);
}
WireFields moved(const Move& move) {
  return {whole("time_ms", move.time_ms), servos(move.servos)};
}

std::string_view name_of(GroupStep::Kind kind) {
  constexpr std::array<std::string_view, 5> kNames{"begin", "count", "blocks", "action", "end"};
  return kNames[(static_cast<std::size_t>(kind) - 1) % kNames.size()];
}

Told read(const Request& request) {
  return std::visit(
      Cases{
          [](const ReadVersion&) { return Told{"read_version"}; },
          [](const ReadOffsets&) { return Told{"read_offsets"}; },
          [](const Move& m) { return Told{"move", moved(m)}; },
          [](const Jog& m) {
            return Told{
                "board_jog",
                {whole("dx_mm", m.dx_mm), whole("dy_mm", m.dy_mm), whole("dz_mm", m.dz_mm)}};
          },
          [](const GroupStep& m) {
            return Told{"write_group", {word("step", name_of(m.kind)), whole("value", m.value)}};
          },
          [](const RunGroup& m) {
            return Told{"run_group", {whole("group", m.group), whole("times", m.times)}};
          },
          [](const StopGroup&) { return Told{"stop_group"}; },
          [](const EraseGroup& m) { return Told{"erase_group", {whole("group", m.group)}}; },
          [](const Chassis& m) { return Told{"chassis", {list("parameters", m.parameters)}}; },
          [](const SetOffset& m) {
            return Told{"set_offset",
                        {whole("servo", m.servo.id), whole("offset", m.servo.offset)}};
          },
          [](const SetGroupSpeed& m) {
            return Told{"group_speed", {whole("group", m.group), whole("percent", m.percent)}};
          },
          [](const SaveOffsets&) { return Told{"save_offsets"}; },
          [](const GoHome&) { return Told{"board_home"}; },
          [](const ReadCommanded&) { return Told{"read_commanded"}; },
          [](const ReadBattery&) { return Told{"read_battery"}; },
          [](const Unload& m) { return Told{"unload", {list("servos", m.ids)}}; },
          [](const ReadPositions& m) { return Told{"read_positions", {list("servos", m.ids)}}; },
          [](const StoreBusOffsets& m) { return Told{"store_offsets", {list("servos", m.ids)}}; },
          [](const ReadBusOffsets& m) { return Told{"read_offsets", {list("servos", m.ids)}}; },
          [](const AdjustBusOffset& m) {
            return Told{"set_offset", {whole("servo", m.id), whole("offset", m.offset)}};
          },
          [](const StoreAction& m) {
            WireFields fields = moved(m.move);
            fields.insert(fields.begin(), {whole("group", m.group), whole("index", m.index)});
            return Told{"store_action", fields};
          },
          [](const SetMode& m) {
            return Told{"set_mode",
                        {whole("servo", m.id), whole("mode", m.mode), whole("speed", m.speed)}};
          },
          [](const WriteBusInfo& m) { return Told{"write_bus", {list("bytes", m.parameters)}}; },
          [](const ReadBusInfo& m) { return Told{"read_bus", {list("bytes", m.parameters)}}; },
      },
      request);
}

Told read(const Reply& reply) {
  return std::visit(
      Cases{
          [](const Version& m) {
            return Told{"version", {whole("type", m.type), whole("version", m.version)}};
          },
          [](const Offsets& m) { return Told{"offsets", {offsets(m.servos)}}; },
          [](const GroupStepTaken& m) { return Told{"group_written", {whole("step", m.step)}}; },
          [](const GroupStarted& m) {
            return Told{"group_started", {whole("group", m.group), whole("times", m.times)}};
          },
          [](const GroupStopped&) { return Told{"group_stopped"}; },
          [](const GroupFinished& m) {
            return Told{"group_finished", {whole("group", m.group), whole("times", m.times)}};
          },
          [](const GroupErased&) { return Told{"group_erased"}; },
          [](const OffsetsSaved&) { return Told{"offsets_saved"}; },
          [](const Commanded& m) { return Told{"commanded", {servos(m.servos)}}; },
          [](const Battery& m) { return Told{"battery", {real("volts", m.millivolts / 1000.0)}}; },
          [](const Positions& m) { return Told{"positions", {servos(m.servos)}}; },
          [](const BusOffsets& m) { return Told{"offsets", {offsets(m.servos)}}; },
          [](const ActionStored&) { return Told{"action_stored"}; },
          [](const BusInfo& m) { return Told{"bus_info", {list("bytes", m.parameters)}}; },
      },
      reply);
}

Dialect dialect_of(LscProfile profile) {
  if (profile == LscProfile::kBus) return Dialect::kBus;
  return profile == LscProfile::kEsp32 ? Dialect::kEsp32 : Dialect::kLsc6;
}

class LscReader : public StreamReader {
 public:
  explicit LscReader(Dialect dialect) : dialect_(dialect) {}

 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    const auto frame = at(way).push(byte);
    if (!frame) return std::nullopt;
    Told told = bad("unknown", {whole("command", frame->command)});
    if (way == WireWay::kToDevice) {
      if (const auto request = decode_request(*frame, dialect_)) told = wires::read(*request);
    } else if (const auto reply = decode_reply(*frame)) {
      told = wires::read(*reply);
    }
    told.size = 4 + frame->parameters.size();
    return told;
  }
  bool between(WireWay way) const override {
    return frames_[static_cast<std::size_t>(way)].at_boundary();
  }
  void reset(WireWay way) override { at(way).reset(); }

 private:
  FrameDecoder& at(WireWay way) { return frames_[static_cast<std::size_t>(way)]; }

  Dialect dialect_;
  std::array<FrameDecoder, 2> frames_;
};

}  // namespace

std::unique_ptr<WireReader> lsc_reader(const LscDevice& device) {
  return std::make_unique<LscReader>(dialect_of(device.profile));
}

}  // namespace sinew::wires

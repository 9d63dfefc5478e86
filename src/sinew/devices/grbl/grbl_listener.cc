#include "sinew/devices/grbl/grbl_listener.h"

#include <algorithm>

#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace grbl;

std::optional<Told> read_real_time(std::uint8_t byte) {
  switch (static_cast<RealTime>(byte)) {
    case RealTime::kReset:
      return Told{.name = "reset", .size = 1};
    case RealTime::kStatus:
      return Told{.name = "ask", .size = 1};
    case RealTime::kHold:
      return Told{.name = "hold", .size = 1};
    case RealTime::kResume:
      return Told{.name = "resume", .size = 1};
    case RealTime::kJogCancel:
      return Told{.name = "jog_cancel", .size = 1};
  }
  return std::nullopt;
}

Told read(const Request& request) {
  return std::visit(
      Cases{[](const Move& m) {
              return Told{"move", {list("deg", m.to), real("time_s", m.duration)}};
            },
            [](const Jog& m) {
              return Told{"jog",
                          {word("axis", {&kAxisLetters[m.axis], 1}), real("deg", m.by),
                           real("deg_per_min", m.rate)}};
            },
            [](const Probe& m) {
              return Told{"probe",
                          {word("axis", {&kAxisLetters[m.axis], 1}), real("deg", m.by),
                           real("deg_per_min", m.rate)}};
            },
            [](const Home&) { return Told{"home"}; }, [](const Unlock&) { return Told{"unlock"}; },
            [](const AskSettings&) { return Told{"ask_settings"}; },
            [](const AskBuild&) { return Told{"ask_build"}; },
            [](const Modes&) { return Told{"modes"}; },
            [](const ToolOffset& m) { return Told{"tool_offset", {real("z", m.z)}}; }},
      request);
}

Told read_status(const Status& status) {
  WireFields fields{word("state", word_of(status.state)), list("deg", status.position)};
  if (status.detail != 0) fields.push_back(whole("detail", status.detail));
  if (status.room) fields.push_back(whole("room", status.room->blocks));
  if (status.pins && status.pins->limits != 0) {
    fields.push_back(whole("switches", status.pins->limits));
  }
  if (status.pins && status.pins->probe) fields.push_back(whole("probe", 1));
  return {"status", fields};
}

Told read(const Reply& reply) {
  return std::visit(
      Cases{[](const Ok&) { return Told{"ok"}; },
            [](const Refused& m) { return Told{"refused", {whole("error", m.code)}}; },
            [](const Alarm& m) { return Told{"alarm", {whole("alarm", m.code)}}; },
            [](const Welcome& m) {
              return Told{"welcome", {whole("major", m.major), whole("minor", m.minor)}};
            },
            [](const Status& m) { return read_status(m); },
            [](const Setting& m) {
              return Told{"setting", {whole("number", m.number), real("value", m.value)}};
            },
            [](const Build& m) {
              return Told{"build", {whole("blocks", m.blocks), whole("bytes", m.bytes)}};
            },
            [](const Probed& m) {
              return Told{"probed", {list("deg", m.at), whole("touched", m.touched ? 1 : 0)}};
            },
            [](const Note&) { return Told{"note"}; }},
      reply);
}

class GrblReader : public StreamReader {
 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    if (way == WireWay::kToDevice) {
      if (auto told = read_real_time(byte)) return told;
    }
    LineDecoder& lines = at(way);
    const LineDecoder::Result result = lines.push(byte);
    const bool blank = byte == '\n' && lines.at_boundary();
    if (result == LineDecoder::Result::kMore) {
      return blank ? std::optional(Told{.name = "blank", .size = 2}) : std::nullopt;
    }
    if (result == LineDecoder::Result::kDamaged) return bad("damaged");
    if (way == WireWay::kToDevice) {
      const auto request = decode_request(lines.line());
      return request ? wires::read(*request) : bad("unknown");
    }
    const auto reply = decode_reply(lines.line());
    return reply ? wires::read(*reply) : bad("unknown");
  }
  bool between(WireWay way) const override {
    return lines_[static_cast<std::size_t>(way)].at_boundary();
  }
  bool belongs(WireWay /*way*/, std::uint8_t byte) const override {
    return byte == '\r' || byte == '\n';
  }
  void reset(WireWay way) override { at(way).reset(); }

 private:
  LineDecoder& at(WireWay way) { return lines_[static_cast<std::size_t>(way)]; }

  std::array<LineDecoder, 2> lines_;
};

}  // namespace

std::unique_ptr<WireReader> grbl_reader() {
  return std::make_unique<GrblReader>();
}

}  // namespace sinew::wires

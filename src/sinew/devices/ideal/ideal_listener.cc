#include "sinew/devices/ideal/ideal_listener.h"

#include "sinew/devices/ideal/ideal_wire.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace ideal;

Told read(const Request& request) {
  return std::visit(
      Cases{[](const Hello&) { return Told{"hello"}; }, [](const Ask&) { return Told{"ask"}; },
            [](const Stop&) { return Told{"stop"}; }, [](const Clear&) { return Told{"clear"}; },
            [](const Jaws& m) { return Told{"jaws", {whole("width_um", m.width_um)}}; },
            [](const Move& m) {
              return Told{"move",
                          {whole("number", m.number), whole("time_us", m.duration_us),
                           list("urad", m.q), list("urad_s", m.qd)}};
            }},
      request);
}

Told read(const Reply& reply) {
  return std::visit(
      Cases{[](const Identity& m) {
              return Told{"identity",
                          {whole("version", m.version), whole("joints", m.joints),
                           whole("taken", m.taken)}};
            },
            [](const State& m) {
              WireFields fields{word("phase", word_of(m.phase))};
              if (m.held != Held::kNo) {
                fields.push_back(word("held", word_of(m.held)));
              }
              fields.insert(fields.end(), {whole("taken", m.taken), whole("done", m.done),
                                           list("urad", m.q), list("urad_s", m.qd)});
              return Told{"state", fields};
            },
            [](const Refusal& m) { return Told{"refused", {word("why", word_of(m.why))}}; }},
      reply);
}

class IdealReader : public StreamReader {
 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    LineDecoder& lines = at(way);
    const LineDecoder::Result result = lines.push(byte);
    if (result == LineDecoder::Result::kMore) return std::nullopt;
    if (result == LineDecoder::Result::kDamaged) return bad("damaged");
    if (way == WireWay::kToDevice) {
      const auto request = decode_request(lines.words());
      return request ? wires::read(request->what) : bad("unknown");
    }
    const auto reply = decode_reply(lines.words());
    return reply ? wires::read(reply->what) : bad("unknown");
  }
  bool between(WireWay way) const override {
    return lines_[static_cast<std::size_t>(way)].at_boundary();
  }
  void reset(WireWay way) override { at(way).reset(); }

 private:
  LineDecoder& at(WireWay way) { return lines_[static_cast<std::size_t>(way)]; }

  std::array<LineDecoder, 2> lines_;
};

}  // namespace

std::unique_ptr<WireReader> ideal_reader() {
  return std::make_unique<IdealReader>();
}

}  // namespace sinew::wires

#include "sinew/devices/bigrobotarm/bigrobotarm_listener.h"

#include "sinew/core/spelling.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_facts.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using namespace bigrobotarm;

WireFields gripper(const Gripper& gripper) {
  return {flag("gripper", gripper.enabled), whole("gripper_deg", gripper.position)};
}

Told read(const Request& request) {
  return std::visit(
      Cases{
          [](const Goto& m) { return Told{"goto", {list("steps", m.positions)}}; },
          [](const Home&) { return Told{"goto_zero"}; }, [](const Reset&) { return Told{"reset"}; },
          [](const SetSpeeds& m) { return Told{"set_speeds", {list("speeds", m.speeds)}}; },
          [](const SetAccelerations& m) {
            return Told{"set_accelerations", {list("accelerations", m.accelerations)}};
          },
          [](const SetGripper& m) { return Told{"set_gripper", gripper({m.enabled, m.position})}; },
          [](const SetSync& m) { return Told{"set_sync", {flag("on", m.on)}}; },
          [](const ReadStatus&) { return Told{"ask_status"}; }},
      request);
}

Told read(const Status& status) {
  Told told{"status",
            {list("steps", status.positions), list("speeds", status.speeds),
             list("accelerations", status.accelerations)}};
  if (status.gripper) {
    for (WireField& field : gripper(*status.gripper)) told.fields.push_back(std::move(field));
  }
  told.fields.push_back(flag("sync", status.sync));
  return told;
}

Told read(const Reply& reply) {
  return std::visit(
      Cases{[](const MotionStarted&) { return Told{"motion_started"}; },
            [](const GotoDone& m) { return Told{"goto_done", {list("steps", m.positions)}}; },
            [](const HomeDone& m) { return Told{"goto_done", {list("steps", m.positions)}}; },
            [](const ResetDone& m) { return Told{"reset_done", {list("steps", m.positions)}}; },
            [](const Speeds& m) { return Told{"speeds", {list("speeds", m.speeds)}}; },
            [](const Accelerations& m) {
              return Told{"accelerations", {list("accelerations", m.accelerations)}};
            },
            [](const Gripper& m) { return Told{"gripper", gripper(m)}; },
            [](const Sync& m) { return Told{"sync", {flag("on", m.on)}}; },
            [](const Status& m) { return read(m); }, [](const Accepted&) { return Told{"ready"}; },
            [](const Invalid&) { return bad("not_understood"); },
            [](const Queued& m) { return Told{"queued", {list("steps", m.positions)}}; },
            [](const QueueFull&) { return Told{"queue_full"}; },
            [](const QueueDrained&) { return Told{"queue_drained"}; },
            [](const QueueCleared&) { return Told{"queue_cleared"}; }},
      reply);
}

/// Of one of the two wires; the other one begins anew.
template <BigRobotArmWire kWire>
class ReaderOf : public StreamReader {
 public:
  bool fits(const DeviceFacts& facts) const override {
    const auto* found = facts.as<BigRobotArmFacts>();
    return found == nullptr || found->wire == kWire;
  }
};

class ByteWireReader : public ReaderOf<BigRobotArmWire::kByte> {
 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    if (way == WireWay::kToDevice) {
      const auto request = requests_.push(byte);
      if (!request) return std::nullopt;
      return *request ? wires::read(**request) : bad("not_understood");
    }
    const auto reply = replies_.push(byte);
    if (!reply) return std::nullopt;
    return *reply ? wires::read(**reply) : bad("damaged");
  }
  bool between(WireWay way) const override {
    return way == WireWay::kToHost && replies_.at_boundary();
  }
  bool belongs(WireWay way, std::uint8_t byte) const override {
    return way == WireWay::kToDevice && byte == byte::kTerminator && requests_.terminator_due();
  }
  void reset(WireWay way) override {
    if (way == WireWay::kToHost) return replies_.reset();
    requests_ = {};
  }

 private:
  byte::RequestDecoder requests_;
  byte::ReplyDecoder replies_;
};

Told read(const text::Line& line) {
  return std::visit(
      Cases{
          [](const Request& request) { return read(request); },
          [](const text::Begin& m) { return Told{"begin", {whole("repeats", m.repeats)}}; },
          [](const text::End&) { return Told{"end"}; },
          [](const text::QueueGoto& m) { return Told{"queue_goto", {list("steps", m.positions)}}; },
          [](const text::QueueFlush&) { return Told{"queue_flush"}; },
          [](const text::QueueClear&) { return Told{"queue_clear"}; }},
      line.command);
}

Told read(const text::ReplyLine& line) {
  return std::visit(
      Cases{[](const text::FreeMemory& m) {
              return Told{"free_memory", {whole("free_bytes", m.bytes)}};
            },
            [](const text::Echo& m) {
              // Whatever the device likes to say, to people's terminals and pages.
              return Told{"echo", {word("line", printable({m.line.data(), m.line.size()}))}};
            },
            [](const text::MovingTo&) { return Told{"motion_started"}; },
            [](const text::PositionLine& m) { return Told{"steps", {list("steps", m.positions)}}; },
            [](const text::QueuedTo&) { return Told{"queued"}; },
            [](const text::Ready&) { return Told{"ready"}; },
            [](const auto& same) { return read(Reply{same}); }},
      line);
}

/// Line by line: a reply is several of them.
class TextWireReader : public ReaderOf<BigRobotArmWire::kText> {
 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    std::string& line = lines_[static_cast<std::size_t>(way)];
    const bool down = way == WireWay::kToDevice;
    const char end = down ? text::kLineEnd : '\n';
    if (static_cast<char>(byte) != end) {
      if (line.size() < kLineMax) line += static_cast<char>(byte);
      return std::nullopt;
    }
    std::string whole_line;
    whole_line.swap(line);
    if (!whole_line.empty() && whole_line.back() == '\r') whole_line.pop_back();
    if (down) {
      const auto command = text::decode_line(whole_line);
      return command ? wires::read(*command) : bad("not_understood");
    }
    const auto reply = text::decode_reply_line(whole_line);
    return reply ? wires::read(*reply) : bad("damaged");
  }
  bool between(WireWay way) const override {
    static_cast<void>(way);
    return false;
  }
  void reset(WireWay way) override { lines_[static_cast<std::size_t>(way)].clear(); }

 private:
  static constexpr std::size_t kLineMax = 96;
  std::array<std::string, 2> lines_;
};

}  // namespace

std::unique_ptr<WireReader> bigrobotarm_reader(BigRobotArmWire wire) {
  if (wire == BigRobotArmWire::kByte) return std::make_unique<ByteWireReader>();
  return std::make_unique<TextWireReader>();
}

}  // namespace sinew::wires

#include "sinew/devices/axis/axis_listener.h"

#include <algorithm>

#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_wire_words.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/driver/stream_reader.h"

namespace sinew::wires {
namespace {

using Kind = WireMessage::Kind;

template <class Status, std::size_t N>
WireField flags(const Status& status, const std::array<AxisFlagWord<Status>, N>& words) {
  std::string text;
  for (const auto& one : words) {
    if (status.*one.flag) text += (text.empty() ? "" : " ") + std::string(one.name);
  }
  return word("flags", text.empty() ? "none" : text);
}

void put(const WirePiece& piece, Told told, std::vector<WireMessage>& out) {
  out.push_back({piece.at, piece.way, piece.select, piece.bytes, told.name, std::move(told.fields),
                 told.kind});
}

Told fill() {
  return {"fill", {}, Kind::kFill};
}

/// Seven transfers a transaction; which one it is, is told by the one before.
class RegistersReader : public WireReader {
 public:
  explicit RegistersReader(const AxisRegistersDevice& device) : device_(device) {}

  void read(const WirePiece& piece, std::vector<WireMessage>& out) override {
    const bool down = piece.way == WireWay::kToDevice;
    if (down) step_ = step_of(piece.bytes);
    put(piece, down ? to_device(piece.bytes) : to_host(piece.bytes), out);
  }
  void forget() override { step_ = Step::kUnknown; }

 private:
  enum class Step : std::uint8_t {
    kUnknown,
    kResync,
    kSyn,
    kSynAck,
    kAck,
    kHeader,
    kValidation,
    kData,
    kCommit,
  };

  Step step_of(const std::vector<std::uint8_t>& bytes) const {
    using namespace axis_registers;
    if (bytes.size() == kResyncSize) return Step::kResync;
    if (bytes.size() == kHeaderSize) return Step::kHeader;
    if (bytes.size() == 1) {
      if (bytes[0] == kSyn) return Step::kSyn;
      if (bytes[0] == kAck) return Step::kAck;
      return step_ == Step::kHeader ? Step::kValidation : Step::kSynAck;
    }
    if (step_ == Step::kValidation) return Step::kData;
    return step_ == Step::kData ? Step::kCommit : Step::kUnknown;
  }

  bool writes() const { return header_.operation == 2; }

  Told to_device(const std::vector<std::uint8_t>& bytes) {
    using namespace axis_registers;
    switch (step_) {
      case Step::kResync:
        return {"resync"};
      case Step::kSyn:
        return {"syn"};
      case Step::kAck:
        return {"ack"};
      case Step::kHeader:
        return header(bytes);
      case Step::kData:
        return writes() ? data(bytes) : fill();
      case Step::kCommit:
        return writes() ? fill() : verdict(decode_commit(bytes), "commit");
      case Step::kSynAck:
      case Step::kValidation:
        return fill();
      case Step::kUnknown:
        break;
    }
    return bad("unknown");
  }

  Told to_host(const std::vector<std::uint8_t>& bytes) const {
    using namespace axis_registers;
    if (bytes.empty()) return bad("unknown");
    switch (step_) {
      case Step::kSynAck:
        return bytes[0] == kSynAck ? Told{"syn_ack"} : bad("no_answer");
      case Step::kValidation:
        return verdict(verdict_of(bytes[0]), "validation");
      case Step::kData:
        return writes() ? fill() : data(bytes);
      case Step::kCommit:
        return writes() ? verdict(decode_commit(bytes), "commit") : fill();
      default:
        return fill();
    }
  }

  Told header(const std::vector<std::uint8_t>& bytes) {
    using namespace axis_registers;
    HeaderBytes raw{};
    std::ranges::copy(bytes, raw.begin());
    const auto header = decode_header(raw);
    if (!header) return verdict(header.error(), "header");
    header_ = *header;
    return {writes() ? "write_register" : "read_register",
            {word("register", register_name()), whole("frame_id", header_.frame_id),
             whole("size", header_.size)}};
  }

  Told data(const std::vector<std::uint8_t>& bytes) const {
    using namespace axis_registers;
    const auto data = unseal(bytes);
    if (!data) return bad("damaged");
    Told told{"data", {word("register", register_name())}};
    const auto status = header_.address == device_.registers.diag_status ? decode_status(*data)
                                                                         : std::optional<Status>();
    AngleBytes angle{};
    const bool is_angle =
        header_.address == device_.registers.move_angle && data->size() == angle.size();
    if (status) {
      told.fields.push_back(flags(*status, kStatusWords));
      told.fields.push_back(whole("fault", status->fault));
    } else if (is_angle) {
      std::copy(data->begin(), data->end(), angle.begin());
      if (const auto degrees = decode_angle(device_.encoding, angle)) {
        told.fields.push_back(real("angle_deg", *degrees));
      }
    } else if (data->size() == 1) {
      told.fields.push_back(whole("value", (*data)[0]));
    }
    return told;
  }

  static Told verdict(std::optional<axis_registers::Verdict> verdict, std::string_view what) {
    if (!verdict) return bad(what, {word("verdict", "none")});
    const bool good = *verdict == axis_registers::Verdict::kOk;
    return {what, {word("verdict", name(*verdict))}, good ? Kind::kGood : Kind::kBad};
  }

  std::string_view register_name() const {
    using axis_registers::Register;
    const AxisRegisterMap& map = device_.registers;
    const std::array<std::pair<std::uint16_t, Register>, 5> places{
        {{map.homing, Register::kHoming},
         {map.move_angle, Register::kMoveAngle},
         {map.diag_control, Register::kDiagControl},
         {map.diag_status, Register::kDiagStatus},
         {map.emergency_stop, Register::kEmergencyStop}}};
    for (const auto& [address, which] : places) {
      if (address == header_.address) return name(which);
    }
    return "unknown";
  }

  AxisRegistersDevice device_;
  Step step_ = Step::kUnknown;
  axis_registers::Header header_;
};

/// A frame each way at the same time.
class LinkReader : public WireReader {
 public:
  void read(const WirePiece& piece, std::vector<WireMessage>& out) override {
    put(piece, told(piece), out);
  }
  void forget() override {}

 private:
  static Told told(const WirePiece& piece) {
    using namespace axis_link;
    if (piece.bytes.size() != kFrameSize) return bad("unknown");
    const std::span<const std::uint8_t, kFrameSize> frame(piece.bytes.data(), kFrameSize);
    if (piece.way == WireWay::kToDevice) {
      const auto request = decode_request(frame);
      return request ? told(*request) : rejected(request.error());
    }
    const auto reply = decode_reply(frame);
    if (reply) return told(*reply);
    const bool alike =
        std::ranges::all_of(piece.bytes, [&](auto b) { return b == piece.bytes[0]; });
    return alike ? bad("no_answer") : rejected(reply.error());
  }

  static Told rejected(axis_link::Reject why) {
    constexpr std::array<std::string_view, 3> kNames{"checksum", "other_version", "content"};
    return bad("damaged", {word("why", kNames[static_cast<std::size_t>(why) % kNames.size()])});
  }

  static Told told(const axis_link::Request& request) {
    using namespace axis_link;
    Told told{name(request.mode), {whole("sequence", request.sequence)}};
    if (request.to_all) told.fields.push_back(flag("to_all", true));
    if (request.mode == Mode::kTrack || request.mode == Mode::kMove) {
      told.fields.push_back(real("target_deg", to_deg(from_units(request.target))));
      told.fields.push_back(real("velocity_deg_s", to_deg(request.velocity / kVelocityUnits)));
    }
    return told;
  }

  static Told told(const axis_link::Reply& reply) {
    using namespace axis_link;
    Told told = std::visit(
        Cases{[](const State& m) {
                return Told{"state",
                            {real("position_deg", to_deg(from_units(m.position))),
                             real("velocity_deg_s", to_deg(m.velocity / kStateVelocityUnits)),
                             flags(m, kStateWords), whole("fault", m.fault),
                             word("verdict", name(m.verdict))}};
              },
              [](const Identity& m) {
                return Told{"identity", {whole("model_hash", m.model_hash), whole("boot", m.boot)}};
              },
              [](const Health& m) {
                Told health{"health"};
                if (m.supply_mv) health.fields.push_back(real("volts", *m.supply_mv / 1000.0));
                if (m.temperature_c01) {
                  health.fields.push_back(real("temperature_c", *m.temperature_c01 / 100.0));
                }
                health.fields.push_back(word("motor_magnet", magnet_word(m.motor_magnet)));
                health.fields.push_back(word("joint_magnet", magnet_word(m.joint_magnet)));
                return health;
              },
              [](const SetupWord& m) {
                return Told{"setup_word", {whole("index", m.index), whole("value", m.value)}};
              }},
        reply.body);
    told.fields.insert(told.fields.begin(), whole("sequence", reply.sequence));
    return told;
  }
};

}  // namespace

std::unique_ptr<WireReader> axis_registers_reader(const AxisRegistersDevice& device) {
  return std::make_unique<RegistersReader>(device);
}
std::unique_ptr<WireReader> axis_link_reader() {
  return std::make_unique<LinkReader>();
}

}  // namespace sinew::wires

#include "sinew/devices/lsc/lsc_wire.h"

#include <span>

#include "sinew/core/assert.h"

namespace sinew::lsc {
namespace {

constexpr std::uint8_t kLengthMin = 2;
constexpr std::uint8_t kLengthMax = kParametersMax + 2;
constexpr std::uint8_t kActionMark = 0x0B;  // stands in every action of command 5

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

/// Parameters, number by number.
class Writer {
 public:
  explicit Writer(std::uint8_t command) { frame_.command = command; }
  Writer& u8(std::uint8_t value) {
    frame_.parameters.push_back(value);
    return *this;
  }
  Writer& i8(std::int8_t value) { return u8(static_cast<std::uint8_t>(value)); }
  Writer& u16(std::uint16_t value) {
    return u8(static_cast<std::uint8_t>(value)).u8(static_cast<std::uint8_t>(value >> 8));
  }
  Writer& i16(std::int16_t value) { return u16(static_cast<std::uint16_t>(value)); }
  Writer& ids(const ServoIds& ids) {
    u8(static_cast<std::uint8_t>(ids.size()));
    for (const std::uint8_t id : ids) u8(id);
    return *this;
  }
  Writer& values(std::span<const ServoValue> servos) {
    for (const ServoValue& servo : servos) u8(servo.id).u16(servo.value);
    return *this;
  }
  Writer& offsets(std::span<const ServoOffset> servos) {
    for (const ServoOffset& servo : servos) u8(servo.id).i8(servo.offset);
    return *this;
  }
  Writer& move(const Move& move) {
    return u8(static_cast<std::uint8_t>(move.servos.size()))
        .u16(move.time_ms)
        .values({move.servos.data(), move.servos.size()});
  }
  Writer& raw(const Parameters& bytes) {
    for (const std::uint8_t byte : bytes) u8(byte);
    return *this;
  }
  const Frame& frame() const { return frame_; }

 private:
  Frame frame_;
};

/// The way back. What is not there reads as 0 and is remembered.
class Reader {
 public:
  explicit Reader(const Parameters& parameters) : rest_(parameters.data(), parameters.size()) {}

  std::uint8_t u8() {
    if (rest_.empty()) {
      good_ = false;
      return 0;
    }
    const std::uint8_t value = rest_.front();
    rest_ = rest_.subspan(1);
    return value;
  }
  std::int8_t i8() { return static_cast<std::int8_t>(u8()); }
  std::uint16_t u16() {
    const std::uint8_t low = u8();
    return static_cast<std::uint16_t>(low | u8() << 8);
  }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  ServoValue value() {
    const std::uint8_t id = u8();
    return {id, u16()};
  }
  ServoOffset offset() {
    const std::uint8_t id = u8();
    return {id, i8()};
  }
  /// How many servos follow: at least one, and no more than a frame holds.
  std::size_t count() {
    const std::size_t count = u8();
    good_ = good_ && count >= 1 && count <= kServosMax;
    return good_ ? count : 0;
  }
  ServoIds ids() {
    ServoIds ids;
    for (std::size_t n = count(); n > 0; --n) ids.push_back(u8());
    return ids;
  }
  Move move() {
    Move move;
    const std::size_t servos = count();
    move.time_ms = u16();
    for (std::size_t n = servos; n > 0; --n) move.servos.push_back(value());
    return move;
  }
  void expect(std::uint8_t byte) { good_ = u8() == byte && good_; }
  void expect(bool right) { good_ = good_ && right; }
  std::size_t left() const { return rest_.size(); }
  /// All was there, and nothing is left over.
  bool done() const { return good_ && rest_.empty(); }

 private:
  std::span<const std::uint8_t> rest_;
  bool good_ = true;
};

Frame frame_of(const GroupStep& step) {
  Writer writer(5);
  writer.u8(static_cast<std::uint8_t>(step.kind));
  if (step.kind == GroupStep::Kind::kAction) {
    writer.u8(step.block).u8(step.index).u8(kActionMark).u16(step.move.time_ms);
    writer.values({step.move.servos.data(), step.move.servos.size()});
  } else if (step.kind != GroupStep::Kind::kEnd) {
    writer.u8(step.value);
  }
  return writer.frame();
}

GroupStep read_group_step(Reader& reader) {
  GroupStep step;
  const std::uint8_t kind = reader.u8();
  if (kind < 1 || kind > static_cast<std::uint8_t>(GroupStep::Kind::kEnd)) {
    reader.expect(false);
    return step;
  }
  step.kind = static_cast<GroupStep::Kind>(kind);
  if (step.kind == GroupStep::Kind::kAction) {
    step.block = reader.u8();
    step.index = reader.u8();
    reader.expect(kActionMark);
    step.move.time_ms = reader.u16();
    reader.expect(reader.left() >= 3 && reader.left() <= 3 * kServosMax);
    while (reader.left() >= 3 && !step.move.servos.full()) {
      step.move.servos.push_back(reader.value());
    }
  } else if (step.kind != GroupStep::Kind::kEnd) {
    step.value = reader.u8();
  }
  return step;
}

Frame frame_of(const Request& request) {
  return std::visit(
      Overload{
          [](const ReadVersion&) { return Writer(1).frame(); },
          [](const ReadOffsets&) { return Writer(2).frame(); },
          [](const Move& m) { return Writer(3).move(m).frame(); },
          [](const Jog& m) { return Writer(4).i8(m.dx_mm).i8(m.dy_mm).i8(m.dz_mm).frame(); },
          [](const GroupStep& m) { return frame_of(m); },
          [](const RunGroup& m) { return Writer(6).u8(m.group).u16(m.times).frame(); },
          [](const StopGroup&) { return Writer(7).frame(); },
          [](const EraseGroup& m) { return Writer(8).u8(m.group).frame(); },
          [](const Chassis& m) { return Writer(9).raw(m.parameters).frame(); },
          [](const SetOffset& m) { return Writer(10).offsets({&m.servo, 1}).frame(); },
          [](const SetGroupSpeed& m) { return Writer(11).u8(m.group).u16(m.percent).frame(); },
          [](const SaveOffsets&) { return Writer(11).frame(); },
          [](const GoHome&) { return Writer(12).frame(); },
          [](const ReadCommanded&) { return Writer(13).frame(); },
          [](const ReadBattery&) { return Writer(15).frame(); },
          [](const Unload& m) { return Writer(20).ids(m.ids).frame(); },
          [](const ReadPositions& m) { return Writer(21).ids(m.ids).frame(); },
          [](const StoreBusOffsets& m) { return Writer(22).ids(m.ids).frame(); },
          [](const ReadBusOffsets& m) { return Writer(23).ids(m.ids).frame(); },
          [](const AdjustBusOffset& m) {
            Writer writer(24);
            writer.u8(m.id);
            return (m.wide ? writer.i16(m.offset) : writer.i8(static_cast<std::int8_t>(m.offset)))
                .frame();
          },
          [](const StoreAction& m) {
            return Writer(25).u8(m.group).u8(m.count).u8(m.index).move(m.move).frame();
          },
          [](const SetMode& m) { return Writer(26).u8(m.id).u8(m.mode).i16(m.speed).frame(); },
          [](const WriteBusInfo& m) { return Writer(27).raw(m.parameters).frame(); },
          [](const ReadBusInfo& m) { return Writer(28).raw(m.parameters).frame(); },
      },
      request);
}

Frame frame_of(const Reply& reply) {
  return std::visit(
      Overload{
          [](const Version& m) { return Writer(1).u8(m.type).u8(m.version).frame(); },
          [](const Offsets& m) { return Writer(2).offsets(m.servos).frame(); },
          [](const GroupStepTaken& m) { return Writer(5).u8(m.step).u8(0).frame(); },
          [](const GroupStarted& m) { return Writer(6).u8(m.group).u16(m.times).frame(); },
          [](const GroupStopped&) { return Writer(7).frame(); },
          [](const GroupFinished& m) { return Writer(8).u8(m.group).u16(m.times).frame(); },
          [](const GroupErased&) { return Writer(8).frame(); },
          [](const OffsetsSaved&) { return Writer(11).frame(); },
          [](const Commanded& m) { return Writer(13).values(m.servos).frame(); },
          [](const Battery& m) { return Writer(15).u16(m.millivolts).frame(); },
          [](const Positions& m) {
            return Writer(21)
                .u8(static_cast<std::uint8_t>(m.servos.size()))
                .values({m.servos.data(), m.servos.size()})
                .frame();
          },
          [](const BusOffsets& m) {
            return Writer(23)
                .u8(static_cast<std::uint8_t>(m.servos.size()))
                .offsets({m.servos.data(), m.servos.size()})
                .frame();
          },
          [](const ActionStored&) { return Writer(25).frame(); },
          [](const BusInfo& m) { return Writer(28).raw(m.parameters).frame(); },
      },
      reply);
}

constexpr bool knows(Dialect dialect, std::uint8_t command) {
  switch (command) {
    case 3:
    case 6:
    case 7:
    case 8:
    case 11:
      return true;
    case 1:
    case 2:
    case 4:
    case 9:
    case 10:
    case 12:
    case 13:
    case 25:
      return dialect == Dialect::kEsp32;
    case 5:
    case 15:
      return dialect != Dialect::kEsp32;
    default:
      return dialect == Dialect::kBus &&
             ((command >= 20 && command <= 24) || (command >= 26 && command <= 28));
  }
}

Request read_store_action(Reader& reader) {
  StoreAction action{reader.u8(), reader.u8(), reader.u8(), {}};
  action.move = reader.move();
  reader.expect(action.move.servos.size() == kBoardServos);
  return action;
}

/// The numbers that mean the same wherever they are known, up to 13.
Request read_low(std::uint8_t command, Reader& reader) {
  switch (command) {
    case 1:
      return ReadVersion{};
    case 2:
      return ReadOffsets{};
    case 3:
      return reader.move();
    case 4:
      return Jog{reader.i8(), reader.i8(), reader.i8()};
    case 5:
      return read_group_step(reader);
    case 6:
      return RunGroup{reader.u8(), reader.u16()};
    case 7:
      return StopGroup{};
    case 8:
      return EraseGroup{reader.u8()};
    case 10:
      return SetOffset{reader.offset()};
    case 12:
      return GoHome{};
    default:
      SINEW_ASSERT(command == 13);
      return ReadCommanded{};
  }
}

/// The same from 15 on.
Request read_high(std::uint8_t command, Reader& reader) {
  switch (command) {
    case 15:
      return ReadBattery{};
    case 20:
      return Unload{reader.ids()};
    case 21:
      return ReadPositions{reader.ids()};
    case 22:
      return StoreBusOffsets{reader.ids()};
    case 23:
      return ReadBusOffsets{reader.ids()};
    case 24: {
      const std::uint8_t id = reader.u8();
      const bool wide = reader.left() == 2;
      return AdjustBusOffset{id, wide ? reader.i16() : std::int16_t{reader.i8()}, wide};
    }
    case 25:
      return read_store_action(reader);
    default:
      SINEW_ASSERT(command == 26);
      return SetMode{reader.u8(), reader.u8(), reader.i16()};
  }
}

template <class List, class Item>
List read_list(Reader& reader, Item item) {
  List list;
  for (std::size_t n = reader.count(); n > 0; --n) list.push_back(item());
  return list;
}

Reply read_commanded(Reader& reader) {
  Commanded commanded;
  for (ServoValue& servo : commanded.servos) servo = reader.value();
  return commanded;
}

Reply read_offsets(Reader& reader) {
  Offsets offsets;
  for (ServoOffset& servo : offsets.servos) servo = reader.offset();
  return offsets;
}

/// Nothing where no board sends such a command.
std::optional<Reply> read_reply(const Frame& frame, Reader& reader) {
  switch (frame.command) {
    case 1:
      return Version{reader.u8(), reader.u8()};
    case 2:
      return read_offsets(reader);
    case 5: {
      const GroupStepTaken taken{reader.u8()};
      reader.expect(std::uint8_t{0});
      return taken;
    }
    case 6:
      return GroupStarted{reader.u8(), reader.u16()};
    case 7:
      return GroupStopped{};
    case 8:
      if (frame.parameters.empty()) return GroupErased{};
      return GroupFinished{reader.u8(), reader.u16()};
    case 11:
      return OffsetsSaved{};
    case 13:
      return read_commanded(reader);
    case 15:
      return Battery{reader.u16()};
    case 21:
      return Positions{read_list<ServoValues>(reader, [&] { return reader.value(); })};
    case 23:
      return BusOffsets{read_list<ServoOffsets>(reader, [&] { return reader.offset(); })};
    case 25:
      return ActionStored{};
    default:
      return std::nullopt;
  }
}

}  // namespace

Bytes encode(const Frame& frame) {
  Bytes bytes{kHeader, kHeader, static_cast<std::uint8_t>(frame.parameters.size() + 2),
              frame.command};
  for (const std::uint8_t byte : frame.parameters) bytes.push_back(byte);
  return bytes;
}

Bytes encode(const Request& request) {
  return encode(frame_of(request));
}

Bytes encode(const Reply& reply) {
  return encode(frame_of(reply));
}

std::optional<Request> decode_request(const Frame& frame, Dialect dialect) {
  if (!knows(dialect, frame.command)) return std::nullopt;
  if (frame.command == 9) return Chassis{frame.parameters};
  if (frame.command == 27) return WriteBusInfo{frame.parameters};
  if (frame.command == 28) return ReadBusInfo{frame.parameters};
  Reader reader(frame.parameters);
  Request request;
  if (frame.command == 11 && dialect == Dialect::kEsp32) {
    request = SaveOffsets{};
  } else if (frame.command == 11) {
    request = SetGroupSpeed{reader.u8(), reader.u16()};
  } else if (frame.command < 15) {
    request = read_low(frame.command, reader);
  } else {
    request = read_high(frame.command, reader);
  }
  if (!reader.done()) return std::nullopt;
  return request;
}

std::optional<Reply> decode_reply(const Frame& frame) {
  if (frame.command == 28) return BusInfo{frame.parameters};
  Reader reader(frame.parameters);
  const auto reply = read_reply(frame, reader);
  if (!reader.done()) return std::nullopt;
  return reply;
}

void FrameDecoder::reset() {
  state_ = State::kFirst;
}

std::optional<Frame> FrameDecoder::push(std::uint8_t byte) {
  switch (state_) {
    case State::kFirst:
      if (byte == kHeader) {
        state_ = State::kSecond;
      } else {
        ++skipped_;
      }
      return std::nullopt;
    case State::kSecond:
      if (byte == kHeader) {
        state_ = State::kLength;
      } else {
        state_ = State::kFirst;
        skipped_ += 2;
      }
      return std::nullopt;
    case State::kLength:
      take_length(byte);
      return std::nullopt;
    case State::kCommand:
      frame_.command = byte;
      frame_.parameters.clear();
      state_ = State::kParameters;
      taken_ = kLengthMin;
      break;
    case State::kParameters:
      if (!frame_.parameters.full()) frame_.parameters.push_back(byte);
      ++taken_;
      break;
  }
  return taken_ == length_ ? finish() : std::nullopt;
}

void FrameDecoder::take_length(std::uint8_t byte) {
  const bool bounded = rule_ == LengthRule::kBounded;
  if (bounded && byte == kHeader) {
    ++skipped_;
  } else if (byte < kLengthMin || (bounded && byte > kLengthMax)) {
    state_ = State::kFirst;
    skipped_ += 3;
  } else {
    length_ = byte;
    state_ = State::kCommand;
  }
}

std::optional<Frame> FrameDecoder::finish() {
  state_ = State::kFirst;
  if (length_ <= kLengthMax) return frame_;
  skipped_ += 3U + length_ - 1U;
  return std::nullopt;
}

}  // namespace sinew::lsc

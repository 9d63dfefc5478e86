#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

#include "sinew/core/fixed_vector.h"

/// The LSC wire of the LeArm's servo boards: 55 55 LEN CMD parameters, LEN = parameters + 2. No
/// checksum, no escape; integers are little endian. docs/wires/lsc.md has the tables. All is @rt.
namespace sinew::lsc {

inline constexpr std::uint8_t kHeader = 0x55;
inline constexpr std::size_t kServosMax = 8;       ///< in one frame; boards of this kind have six
inline constexpr std::size_t kBoardServos = 6;     ///< what the fixed reports of the ESP32 list
inline constexpr std::size_t kParametersMax = 32;  ///< no frame that is known has more than 27
inline constexpr std::size_t kFrameMax = 4 + kParametersMax;
inline constexpr std::uint16_t kLeavePosition = 0xFF00;  ///< bus: this servo stays as it is
inline constexpr std::uint8_t kAllGroups = 255;

/// The boards give some numbers different meanings.
enum class Dialect : std::uint8_t { kLsc6, kBus, kEsp32 };

using Bytes = FixedVector<std::uint8_t, kFrameMax>;
using Parameters = FixedVector<std::uint8_t, kParametersMax>;

/// One frame, whatever it means.
struct Frame {
  std::uint8_t command = 0;
  Parameters parameters;
  friend bool operator==(const Frame&, const Frame&) = default;
};

struct ServoValue {
  std::uint8_t id = 0;
  std::uint16_t value = 0;  ///< us of pulse, or thousandths of 240 degrees on the bus
  friend bool operator==(const ServoValue&, const ServoValue&) = default;
};
struct ServoOffset {
  std::uint8_t id = 0;
  std::int8_t offset = 0;  ///< units
  friend bool operator==(const ServoOffset&, const ServoOffset&) = default;
};
using ServoValues = FixedVector<ServoValue, kServosMax>;
using ServoOffsets = FixedVector<ServoOffset, kServosMax>;
using ServoIds = FixedVector<std::uint8_t, kServosMax>;

// Requests, host to board. In brackets the command's number and the boards that know it.

struct ReadVersion {  ///< [1, ESP32]
  friend bool operator==(const ReadVersion&, const ReadVersion&) = default;
};
struct ReadOffsets {  ///< [2, ESP32]
  friend bool operator==(const ReadOffsets&, const ReadOffsets&) = default;
};
struct Move {  ///< [3, all] every servo named goes evenly to its value in `time_ms`
  std::uint16_t time_ms = 0;
  ServoValues servos;
  friend bool operator==(const Move&, const Move&) = default;
};
struct Jog {  ///< [4, ESP32] tool by so many mm, with the board's own kinematics
  std::int8_t dx_mm = 0, dy_mm = 0, dz_mm = 0;
  friend bool operator==(const Jog&, const Jog&) = default;
};
/// [5, classic board and bus] One of the five steps of writing an action group.
struct GroupStep {
  enum class Kind : std::uint8_t { kBegin = 1, kCount, kBlocks, kAction, kEnd } kind = Kind::kBegin;
  std::uint8_t value = 0;  ///< group (kBegin), actions (kCount), blocks (kBlocks)
  std::uint8_t block = 0;  ///< kAction: where it belongs
  std::uint8_t index = 0;
  Move move;  ///< kAction
  friend bool operator==(const GroupStep&, const GroupStep&) = default;
};
struct RunGroup {  ///< [6, all]
  std::uint8_t group = 0;
  std::uint16_t times = 1;  ///< 0: for ever
  friend bool operator==(const RunGroup&, const RunGroup&) = default;
};
struct StopGroup {  ///< [7, all] ends an action group, never a Move
  friend bool operator==(const StopGroup&, const StopGroup&) = default;
};
struct EraseGroup {  ///< [8, all] the ESP32 erases every group
  std::uint8_t group = 0;
  friend bool operator==(const EraseGroup&, const EraseGroup&) = default;
};
struct Chassis {  ///< [9, ESP32] does nothing; its parameters are unknown
  Parameters parameters;
  friend bool operator==(const Chassis&, const Chassis&) = default;
};
struct SetOffset {  ///< [10, ESP32]
  ServoOffset servo;
  friend bool operator==(const SetOffset&, const SetOffset&) = default;
};
struct SetGroupSpeed {  ///< [11, classic board and bus] until power-off
  std::uint8_t group = 0;
  std::uint16_t percent = 100;
  friend bool operator==(const SetGroupSpeed&, const SetGroupSpeed&) = default;
};
struct SaveOffsets {  ///< [11, ESP32] the same number, another meaning
  friend bool operator==(const SaveOffsets&, const SaveOffsets&) = default;
};
struct GoHome {  ///< [12, ESP32] moves all servos to the board's own home
  friend bool operator==(const GoHome&, const GoHome&) = default;
};
struct ReadCommanded {  ///< [13, ESP32]
  friend bool operator==(const ReadCommanded&, const ReadCommanded&) = default;
};
struct ReadBattery {  ///< [15, classic board and bus]
  friend bool operator==(const ReadBattery&, const ReadBattery&) = default;
};
struct Unload {  ///< [20, bus] the servos named go limp
  ServoIds ids;
  friend bool operator==(const Unload&, const Unload&) = default;
};
struct ReadPositions {  ///< [21, bus]
  ServoIds ids;
  friend bool operator==(const ReadPositions&, const ReadPositions&) = default;
};
struct StoreBusOffsets {  ///< [22, bus] keeps them in the servos
  ServoIds ids;
  friend bool operator==(const StoreBusOffsets&, const StoreBusOffsets&) = default;
};
struct ReadBusOffsets {  ///< [23, bus]
  ServoIds ids;
  friend bool operator==(const ReadBusOffsets&, const ReadBusOffsets&) = default;
};
struct AdjustBusOffset {  ///< [24, bus]
  std::uint8_t id = 0;
  std::int16_t offset = 0;
  bool wide = true;  ///< two bytes on the wire; sources disagree, so both are read
  friend bool operator==(const AdjustBusOffset&, const AdjustBusOffset&) = default;
};
struct StoreAction {  ///< [25, ESP32] one action of a group of `count`
  std::uint8_t group = 0;
  std::uint8_t count = 0;
  std::uint8_t index = 0;
  Move move;  ///< all six servos
  friend bool operator==(const StoreAction&, const StoreAction&) = default;
};
struct SetMode {  ///< [26, bus] servo, or motor with a speed
  std::uint8_t id = 0;
  std::uint8_t mode = 0;
  std::int16_t speed = 0;
  friend bool operator==(const SetMode&, const SetMode&) = default;
};
struct WriteBusInfo {  ///< [27, bus] overwrites every servo that is attached
  Parameters parameters;
  friend bool operator==(const WriteBusInfo&, const WriteBusInfo&) = default;
};
struct ReadBusInfo {  ///< [28, bus]
  Parameters parameters;
  friend bool operator==(const ReadBusInfo&, const ReadBusInfo&) = default;
};

using Request =
    std::variant<ReadVersion, ReadOffsets, Move, Jog, GroupStep, RunGroup, StopGroup, EraseGroup,
                 Chassis, SetOffset, SetGroupSpeed, SaveOffsets, GoHome, ReadCommanded, ReadBattery,
                 Unload, ReadPositions, StoreBusOffsets, ReadBusOffsets, AdjustBusOffset,
                 StoreAction, SetMode, WriteBusInfo, ReadBusInfo>;

// Replies and what a board says unasked.

struct Version {          ///< [1]
  std::uint8_t type = 1;  ///< 1 PWM, 2 bus
  std::uint8_t version = 0;
  friend bool operator==(const Version&, const Version&) = default;
};
struct Offsets {  ///< [2]
  std::array<ServoOffset, kBoardServos> servos{};
  friend bool operator==(const Offsets&, const Offsets&) = default;
};
struct GroupStepTaken {  ///< [5]
  std::uint8_t step = 1;
  friend bool operator==(const GroupStepTaken&, const GroupStepTaken&) = default;
};
struct GroupStarted {  ///< [6] whoever started it
  std::uint8_t group = 0;
  std::uint16_t times = 0;
  friend bool operator==(const GroupStarted&, const GroupStarted&) = default;
};
struct GroupStopped {  ///< [7]
  friend bool operator==(const GroupStopped&, const GroupStopped&) = default;
};
struct GroupFinished {  ///< [8, with parameters]
  std::uint8_t group = 0;
  std::uint16_t times = 0;
  friend bool operator==(const GroupFinished&, const GroupFinished&) = default;
};
struct GroupErased {  ///< [8, without]
  friend bool operator==(const GroupErased&, const GroupErased&) = default;
};
struct OffsetsSaved {  ///< [11]
  friend bool operator==(const OffsetsSaved&, const OffsetsSaved&) = default;
};
struct Commanded {  ///< [13] where the board's pulses are at this moment
  std::array<ServoValue, kBoardServos> servos{};
  friend bool operator==(const Commanded&, const Commanded&) = default;
};
struct Battery {  ///< [15]
  std::uint16_t millivolts = 0;
  friend bool operator==(const Battery&, const Battery&) = default;
};
struct Positions {  ///< [21] measured by the servos
  ServoValues servos;
  friend bool operator==(const Positions&, const Positions&) = default;
};
struct BusOffsets {  ///< [23]
  ServoOffsets servos;
  friend bool operator==(const BusOffsets&, const BusOffsets&) = default;
};
struct ActionStored {  ///< [25]
  friend bool operator==(const ActionStored&, const ActionStored&) = default;
};
struct BusInfo {  ///< [28]
  Parameters parameters;
  friend bool operator==(const BusInfo&, const BusInfo&) = default;
};

using Reply = std::variant<Version, Offsets, GroupStepTaken, GroupStarted, GroupStopped,
                           GroupFinished, GroupErased, OffsetsSaved, Commanded, Battery, Positions,
                           BusOffsets, ActionStored, BusInfo>;

Bytes encode(const Frame& frame);
Bytes encode(const Request& request);
Bytes encode(const Reply& reply);

/// What a frame means to a board of that dialect; nothing where the number is unknown there or the
/// parameters are not as many as it has. Whether a value makes sense is the board's affair.
std::optional<Request> decode_request(const Frame& frame, Dialect dialect);
/// What a frame from a board means.
std::optional<Reply> decode_reply(const Frame& frame);

/// How a receiver reads the byte behind the header.
enum class LengthRule : std::uint8_t {
  /// A third 55 moves the header by one byte; a LEN that no frame has sends it back to searching.
  kBounded,
  /// The ESP32's parser: whatever follows 55 55 is LEN, and as many bytes are swallowed.
  kAnything,
};

/// Bytes to frames. LEN alone ends a frame, so that 55 55 inside data is data.
///
///   state       | byte                  | next
///   first 55    | 55 / other            | second 55 / stays, skipped
///   second 55   | 55 / other            | length / first 55, skipped
///   length      | 2..34 / 55 / other    | command / stays / first 55, skipped
///   command     | any                   | parameters, or a frame where LEN is 2
///   parameters  | any                   | a frame after LEN - 2 of them
class FrameDecoder {
 public:
  explicit FrameDecoder(LengthRule rule = LengthRule::kBounded) : rule_(rule) {}

  /// A frame, where this byte completes one.
  std::optional<Frame> push(std::uint8_t byte);
  /// Forgets what was begun.
  void reset();
  /// True between frames.
  bool at_boundary() const { return state_ == State::kFirst; }
  /// Bytes that belonged to no frame, since construction.
  std::uint64_t skipped() const { return skipped_; }

 private:
  enum class State : std::uint8_t { kFirst, kSecond, kLength, kCommand, kParameters };

  void take_length(std::uint8_t byte);
  std::optional<Frame> finish();

  LengthRule rule_;
  State state_ = State::kFirst;
  std::uint8_t length_ = 0;  ///< LEN
  std::uint8_t taken_ = 0;   ///< of the bytes that LEN counts, itself included
  Frame frame_;
  std::uint64_t skipped_ = 0;
};

}  // namespace sinew::lsc

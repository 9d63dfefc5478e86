#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "sinew/core/fixed_vector.h"

/// The bus of Feetech's serial servos (STS, SMS, SCS): FF FF ID LEN WHAT parameters SUM, both ways.
/// A host speaks, one servo replies, and each servo is a table of registers.
/// docs/wires/feetech.md has the tables. All is @rt.
namespace sinew::feetech {

inline constexpr std::uint8_t kHeader = 0xFF;
inline constexpr std::uint8_t kBroadcast = 0xFE;  ///< id of all servos; none replies to it
inline constexpr std::uint8_t kIdMax = 253;
inline constexpr std::size_t kServosMax = 8;       ///< in one packet of ours
inline constexpr std::size_t kDataMax = 40;        ///< registers of one servo in one packet
inline constexpr std::size_t kParametersMax = 96;  ///< of a packet of ours
inline constexpr std::size_t kPacketMax = 6 + kParametersMax;

using Bytes = FixedVector<std::uint8_t, kPacketMax>;
using Data = FixedVector<std::uint8_t, kDataMax>;
using Ids = FixedVector<std::uint8_t, kServosMax>;

/// One packet, whatever it means.
struct Packet {
  std::uint8_t id = 0;
  std::uint8_t what = 0;  ///< instruction to a servo, error bits from one
  FixedVector<std::uint8_t, kParametersMax> parameters;
  friend bool operator==(const Packet&, const Packet&) = default;
};

// Requests. In brackets the instruction.

struct Ping {  ///< [1]
  std::uint8_t id = 0;
  friend bool operator==(const Ping&, const Ping&) = default;
};
struct Read {  ///< [2]
  std::uint8_t id = 0;
  std::uint8_t address = 0;
  std::uint8_t count = 1;
  friend bool operator==(const Read&, const Read&) = default;
};
struct Write {  ///< [3]; [4] where it waits for an Action
  std::uint8_t id = 0;
  std::uint8_t address = 0;
  Data data;
  bool waits = false;
  friend bool operator==(const Write&, const Write&) = default;
};
struct Action {  ///< [5] what waits happens now
  std::uint8_t id = kBroadcast;
  friend bool operator==(const Action&, const Action&) = default;
};
/// [0x0B] Where the servo is becomes the middle of its range (STS): it writes its offset.
struct SetMiddle {
  std::uint8_t id = 0;
  friend bool operator==(const SetMiddle&, const SetMiddle&) = default;
};
struct SyncRead {  ///< [0x82] each replies in turn (STS and SMS)
  std::uint8_t address = 0;
  std::uint8_t count = 1;
  Ids ids;
  friend bool operator==(const SyncRead&, const SyncRead&) = default;
};
struct SyncWrite {  ///< [0x83] none replies
  struct Part {
    std::uint8_t id = 0;
    Data data;  ///< as many bytes for each
    friend bool operator==(const Part&, const Part&) = default;
  };
  std::uint8_t address = 0;
  FixedVector<Part, kServosMax> parts;
  friend bool operator==(const SyncWrite&, const SyncWrite&) = default;
};
using Request = std::variant<Ping, Read, Write, Action, SetMiddle, SyncRead, SyncWrite>;

/// What a servo says of itself in each reply.
struct Trouble {
  static constexpr std::uint8_t kVoltage = 0x01;
  static constexpr std::uint8_t kSensor = 0x02;
  static constexpr std::uint8_t kHeat = 0x04;
  static constexpr std::uint8_t kCurrent = 0x08;
  static constexpr std::uint8_t kAngle = 0x10;
  static constexpr std::uint8_t kOverload = 0x20;
};

struct Reply {
  std::uint8_t id = 0;
  std::uint8_t trouble = 0;  ///< bits of Trouble
  Data data;                 ///< of a Read
  friend bool operator==(const Reply&, const Reply&) = default;
};

/// @pre ids, addresses and counts fit a packet: kServosMax, kDataMax, kParametersMax
Bytes encode(const Request& request);
Bytes encode(const Reply& reply);
std::optional<Request> decode_request(const Packet& packet);
std::optional<Reply> decode_reply(const Packet& packet);

/// Finds packets in a stream of bytes, also behind noise.
class PacketDecoder {
 public:
  enum class Result : std::uint8_t { kMore, kPacket, kDamaged };
  /// What this byte completes; packet() has it then.
  Result push(std::uint8_t byte);
  const Packet& packet() const { return packet_; }
  bool at_boundary() const { return buffer_.empty(); }
  void reset() { buffer_.clear(); }

 private:
  Packet packet_;
  FixedVector<std::uint8_t, kPacketMax> buffer_;
};

// The registers of a servo.

/// Addresses that both series have alike, but where a comment says otherwise.
struct Register {
  static constexpr std::uint8_t kFirmware = 0;  ///< two bytes
  static constexpr std::uint8_t kModel = 3;
  static constexpr std::uint8_t kId = 5;
  static constexpr std::uint8_t kBaud = 6;  ///< 0 to 7: 1M, 500k, 250k, 128k, 115200 ..
  static constexpr std::uint8_t kReturnDelay = 7;
  static constexpr std::uint8_t kReplies = 8;  ///< 0: to a ping and a read only
  static constexpr std::uint8_t kLowest = 9;
  static constexpr std::uint8_t kHighest = 11;
  static constexpr std::uint8_t kHottest = 13;       ///< deg C
  static constexpr std::uint8_t kVoltsMax = 14;      ///< tenths
  static constexpr std::uint8_t kVoltsMin = 15;      ///< tenths
  static constexpr std::uint8_t kTorqueMax = 16;     ///< thousandths
  static constexpr std::uint8_t kOffset = 31;        ///< STS
  static constexpr std::uint8_t kMode = 33;          ///< STS: 0 is a position servo
  static constexpr std::uint8_t kSettings = 40;      ///< so many registers outlive the power
  static constexpr std::uint8_t kTorque = 40;        ///< 0: off
  static constexpr std::uint8_t kAcceleration = 41;  ///< STS: hundreds of steps/s^2; 0: no limit
  static constexpr std::uint8_t kGoal = 42;
  static constexpr std::uint8_t kTime = 44;         ///< ms, of SCS servos
  static constexpr std::uint8_t kSpeed = 46;        ///< steps/s; 0: as fast as it can
  static constexpr std::uint8_t kTorqueLimit = 48;  ///< STS; thousandths
  static constexpr std::uint8_t kLockScs = 48;
  static constexpr std::uint8_t kLockSts = 55;
  static constexpr std::uint8_t kPosition = 56;
  static constexpr std::uint8_t kSpeedNow = 58;
  static constexpr std::uint8_t kLoad = 60;   ///< thousandths of the voltage that the motor gets
  static constexpr std::uint8_t kVolts = 62;  ///< tenths
  static constexpr std::uint8_t kHeat = 63;   ///< deg C
  static constexpr std::uint8_t kTrouble = 65;
  static constexpr std::uint8_t kMoving = 66;
  static constexpr std::uint8_t kCurrent = 69;  ///< STS; units of 6.5 mA
  static constexpr std::uint8_t kEnd = 71;
};

/// Numbers of two bytes: an STS servo has the low one first, an SCS servo the high one.
std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t index, std::endian order);
void put_word(Data& data, std::uint16_t word, std::endian order);
/// Negative where bit `sign` is set: magnitude and sign, no complement.
int signed_word(std::uint16_t word, int sign);
std::uint16_t sign_and_magnitude(int value, int sign);

inline constexpr int kPositionSign = 15;  ///< bit, as of speeds
inline constexpr int kLoadSign = 10;
inline constexpr int kOffsetSign = 11;

}  // namespace sinew::feetech

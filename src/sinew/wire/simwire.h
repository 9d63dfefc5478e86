#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string_view>
#include <variant>

#include "sinew/core/fixed_vector.h"

/// simwire, version 1: a line protocol by which a host that believes in spidev and GPIO talks to
/// simulated boards. ASCII lines, each ended by LF; every request gets exactly one reply line, in
/// order. docs/wires/simwire.md has the table. Everything here is @rt.
namespace sinew::simwire {

inline constexpr int kVersion = 1;
inline constexpr std::size_t kLineMax = 8400;      ///< characters, without the LF
inline constexpr std::size_t kTransferMax = 4096;  ///< bytes, spidev's own bound
inline constexpr std::size_t kTextMax = 256;       ///< of free text

using Bytes = FixedVector<std::uint8_t, kTransferMax>;
using Text = FixedVector<char, kTextMax>;
using Line = FixedVector<char, kLineMax>;

enum class Pull : std::uint8_t { kUp, kDown, kOff };

struct Hello {
  std::uint32_t version = kVersion;
  friend bool operator==(const Hello&, const Hello&) = default;
};
/// GPIO direction and pull; an output begins at its latch, 0 at power-on.
struct Direction {
  std::uint32_t pin = 0;
  bool output = false;
  Pull pull = Pull::kOff;
  friend bool operator==(const Direction&, const Direction&) = default;
};
struct SetPin {
  std::uint32_t pin = 0;
  bool high = false;
  friend bool operator==(const SetPin&, const SetPin&) = default;
};
struct GetPin {
  std::uint32_t pin = 0;
  friend bool operator==(const GetPin&, const GetPin&) = default;
};
/// A spidev device with its settings.
struct BusSettings {
  std::uint32_t bus = 0;
  std::uint32_t device = 0;
  std::uint32_t clock_hz = 0;
  std::uint32_t mode = 0;
  friend bool operator==(const BusSettings&, const BusSettings&) = default;
};
struct Open {
  BusSettings settings;
  friend bool operator==(const Open&, const Open&) = default;
};
/// One full-duplex transfer, its first clock edge at the request's time.
struct Exchange {
  BusSettings settings;
  Bytes mosi;
  friend bool operator==(const Exchange&, const Exchange&) = default;
};
struct Close {
  std::uint32_t bus = 0;
  std::uint32_t device = 0;
  friend bool operator==(const Close&, const Close&) = default;
};
struct Statistics {
  friend bool operator==(const Statistics&, const Statistics&) = default;
};
struct Dump {
  friend bool operator==(const Dump&, const Dump&) = default;
};
/// Sets a register from outside; tests only, and refused by our own boards: nothing is poked.
struct Poke {
  std::uint32_t reg = 0;
  Bytes value;
  friend bool operator==(const Poke&, const Poke&) = default;
};
/// What follows FAULT, as it stands.
struct Fault {
  Text text;
  friend bool operator==(const Fault&, const Fault&) = default;
};
struct Bye {
  friend bool operator==(const Bye&, const Bye&) = default;
};

using Action = std::variant<Hello, Direction, SetPin, GetPin, Open, Exchange, Close, Statistics,
                            Dump, Poke, Fault, Bye>;

struct Request {
  std::uint64_t time_us = 0;  ///< the host's clock, monotone
  Action action;
  friend bool operator==(const Request&, const Request&) = default;
};

struct Ok {
  Text text;  ///< behind "OK"; empty for most
  friend bool operator==(const Ok&, const Ok&) = default;
};
struct Level {
  bool high = false;
  friend bool operator==(const Level&, const Level&) = default;
};
struct Miso {
  Bytes bytes;
  friend bool operator==(const Miso&, const Miso&) = default;
};
/// "STAT k=v k=v" and "DUMP k=v k=v".
struct Report {
  bool dump = false;
  Line text;
  friend bool operator==(const Report&, const Report&) = default;
};
struct Refused {
  Text text;
  friend bool operator==(const Refused&, const Refused&) = default;
};

using Reply = std::variant<Ok, Level, Miso, Report, Refused>;

/// Lines without their LF.
Line encode_request(const Request& request);
Line encode_reply(const Reply& reply);

/// @return the request, or why the line is none, as a sentence for the ERR reply.
std::expected<Request, std::string_view> decode_request(std::string_view line);
/// @return nullopt where no reply looks like this.
std::optional<Reply> decode_reply(std::string_view line);

/// Collects one line at a time; what is longer than kLineMax is dropped and told as such.
class LineReader {
 public:
  enum class Result : std::uint8_t { kMore, kLine, kTooLong };
  Result push(char character);
  std::string_view line() const { return {line_.data(), line_.size()}; }

 private:
  Line line_;
  bool too_long_ = false;
  bool complete_ = false;
};

template <std::size_t Capacity>
std::string_view view(const FixedVector<char, Capacity>& text) {
  return {text.data(), text.size()};
}
/// The first `Capacity` characters.
template <std::size_t Capacity = kTextMax>
FixedVector<char, Capacity> text_of(std::string_view text) {
  FixedVector<char, Capacity> out;
  for (const char c : text.substr(0, Capacity)) out.push_back(c);
  return out;
}

}  // namespace sinew::simwire

#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>

#include "sinew/driver/wire_reader.h"

/// What the readers of the single wires have in common.
namespace sinew::wires {

/// What a message says, without the bytes that said it.
struct Told {
  std::string_view name;
  WireFields fields{};
  WireMessage::Kind kind = WireMessage::Kind::kGood;
  std::size_t size = 0;  ///< its bytes, the last ones; 0: all since the message before
};

inline Told bad(std::string_view name, WireFields fields = {}) {
  return {name, std::move(fields), WireMessage::Kind::kBad};
}

template <class... Each>
struct Cases : Each... {
  using Each::operator()...;
};

template <class Number>
WireField whole(std::string_view name, Number value) {
  return {name, static_cast<std::int64_t>(value)};
}
inline WireField real(std::string_view name, double value) {
  return {name, value};
}
inline WireField word(std::string_view name, std::string_view value) {
  return {name, std::string(value)};
}
inline WireField flag(std::string_view name, bool value) {
  return word(name, value ? "yes" : "no");
}
/// "1 2 3"
template <class Numbers>
WireField list(std::string_view name, const Numbers& numbers) {
  std::string text;
  for (const auto& one : numbers) text += (text.empty() ? "" : " ") + std::to_string(one);
  return word(name, text);
}

/// A wire that is a stream of bytes each way: finds where messages begin and end.
class StreamReader : public WireReader {
 public:
  void read(const WirePiece& piece, std::vector<WireMessage>& out) final;
  void forget() final;

 protected:
  /// What this byte completes.
  virtual std::optional<Told> push(WireWay way, std::uint8_t byte) = 0;
  /// No message has begun: what came since the last one is noise.
  virtual bool between(WireWay way) const = 0;
  /// A byte right behind a message that still is part of it.
  virtual bool belongs(WireWay way, std::uint8_t byte) const {
    static_cast<void>(way), static_cast<void>(byte);
    return false;
  }
  virtual void reset(WireWay way) = 0;

 private:
  struct Begun {
    Instant at{};
    std::vector<std::uint8_t> bytes;
    std::size_t noise = 0;  ///< of them, the first ones
  };

  static void tell(const WirePiece& piece, Begun& begun, std::size_t size, Told told,
                   std::vector<WireMessage>& out);
  void end_stale(const WirePiece& piece, std::vector<WireMessage>& out);

  std::array<Begun, 2> begun_;
};

}  // namespace sinew::wires

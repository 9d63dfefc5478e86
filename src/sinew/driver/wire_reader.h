#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/driver/device_facts.h"
#include "sinew/driver/wire_ring.h"

namespace sinew {

/// One value of a message: its name carries its unit.
struct WireField {
  std::string_view name;
  std::variant<std::int64_t, double, std::string> value;
};
using WireFields = std::vector<WireField>;

/// One message of a wire with its bytes.
struct WireMessage {
  enum class Kind : std::uint8_t {
    kGood,
    kFill,  ///< clocks and nothing else: what is sent where only the other side speaks
    kBad,   ///< nobody's message: damaged, cut short, or noise
  };

  Instant at{};  ///< of its first byte
  WireWay way = WireWay::kToDevice;
  std::uint8_t select = 0;  ///< SPI: bit i is axis i
  std::vector<std::uint8_t> bytes;
  std::string_view name;
  WireFields fields;
  Kind kind = Kind::kGood;
};

/// Listens to a wire and says what passes, by the same codecs that host and devices use. It only
/// looks on: what it makes of bytes that were damaged on the way may differ from what the device
/// makes of them.
class WireReader {
 public:
  virtual ~WireReader() = default;
  /// The next piece, in the order in which they passed; what it completes is appended.
  virtual void read(const WirePiece& piece, std::vector<WireMessage>& out) = 0;
  /// Pieces are missing here: what was begun is forgotten.
  virtual void forget() = 0;
  /// False once the driver has found another wire than this one reads.
  /// @param facts  the driver's, now
  virtual bool fits(const DeviceFacts& /*facts*/) const { return true; }
};

/// "read angle: frame_id 7, size 4", for people.
std::string text_of(const WireMessage& message);
/// "55 AA 01", for people.
std::string hex_of(const std::vector<std::uint8_t>& bytes);

}  // namespace sinew

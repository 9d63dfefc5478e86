#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "sinew/driver/wire_reader.h"
#include "sinew/driver/wire_ring.h"
#include "sinew/model/device.h"

namespace sinew::runtime {

/// The last messages of one robot's wire, numbered, for all who look at them. Reads the ring only
/// when it is asked, in the thread of whoever asks.
class WireMonitor {
 public:
  static constexpr std::size_t kKept = 4000;

  struct Frame {
    std::uint64_t sequence = 0;  ///< from 1 on; what was missed has its numbers too
    WireMessage message;
    std::string text{};  ///< of whoever shows it; the message may be empty then
  };
  struct Frames {
    std::vector<Frame*> frames;  ///< until the next read()
    std::uint64_t last = 0;      ///< sequence to go on from
    std::uint64_t lost = 0;      ///< behind `since`, and not among them
  };

  /// @param ring, device  outlive the monitor
  WireMonitor(const WireRing& ring, const Device& device) : ring_(ring), device_(device) {}

  /// @param facts  the driver's, now. @param since  what the client has; 0: as far back as there is
  /// @return  the latest `limit` behind `since`, in their order
  Frames read(const DeviceFacts& facts, std::uint64_t since, std::size_t limit);

 private:
  void update(const DeviceFacts& facts);

  const WireRing& ring_;
  const Device& device_;
  std::unique_ptr<WireReader> reader_;
  WireRing::Place place_ = 0;
  std::uint64_t last_ = 0;
  std::deque<Frame> frames_;
  std::vector<WirePiece> pieces_;
  std::vector<WireMessage> messages_;
};

}  // namespace sinew::runtime

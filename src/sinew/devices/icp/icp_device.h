#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/icp/tmc222_device.h"

namespace sinew {

/// Where the document contradicts itself or is silent; docs/wires/icp.md lists why. The defaults
/// are what a host expects.
struct IcpQuirks {
  icp::Dialect dialect{};
  bool bit_one_is_plus = false;       ///< direction bit 1 is sent to the motor as +1
  std::int16_t minus_one = -1;        ///< FFFF; -2 is FFFE, the ones' complement of 1
  bool silent_without_motor = false;  ///< motor 0 or 7: no reply at all instead of 11
  bool ack_without_module = false;    ///< 00 although the module did not acknowledge; else silence
  Duration processing{};              ///< from a byte that needs the modules to its reply
  Duration boot = std::chrono::milliseconds(20);  ///< deaf after power-up
  /// Without a byte for so long the controller is dead until its power is cut.
  std::optional<Duration> idle_shutdown{};
};

/// The hexapod's controller between serial wire and I2C bus, as its document says, with the
/// firmware's own order of I2C messages. The serial states are those of icp::RequestDecoder; beside
/// them it is
///
///   kBooting  for `boot`: wakes all modules, writes their parameters; deaf
///   kReady    one byte at a time
///   kWorking  for `processing`: one byte waits in the receiver, the next ones are lost
///   kDead     after E0 or a long idle time, until power_cycle()
///
/// It looks at no module's state: it acknowledges what it sent. @rt
class IcpController {
 public:
  enum class State : std::uint8_t { kBooting, kReady, kWorking, kDead };

  IcpController(const IcpQuirks& quirks, std::span<Tmc222, icp::kMotors> modules, Instant boot);

  void receive(std::uint8_t byte, Instant now);
  void advance(Instant now);
  std::optional<Instant> next_event() const;
  std::size_t take_output(std::span<std::uint8_t> out);

  /// Supply off and on at `now`.
  void power_cycle(Instant now);
  /// The supply fell away and did not come back yet.
  void power_off();

  State state() const { return state_; }
  std::uint64_t bytes_lost() const { return bytes_lost_; }

 private:
  void take(std::uint8_t byte, Instant now);
  void work(const icp::Request& request, Instant now);
  void step(const icp::Step& step, Instant now);
  void read_module(std::uint8_t motor, Instant now);
  bool send(std::uint8_t motor, const tmc222::Command& command, Instant now);
  void finish_boot(Instant now);
  void wake_all(Instant now);
  void refuse(icp::Refusal why);
  void reply(const icp::Reply& reply);

  IcpQuirks quirks_;
  std::span<Tmc222, icp::kMotors> modules_;
  State state_ = State::kBooting;
  icp::RequestDecoder decoder_;
  std::optional<icp::Request> job_;
  std::optional<std::uint8_t> waiting_;  ///< the receiver's one byte
  Instant due_{};                        ///< end of boot or of the work
  Instant last_byte_{};
  FixedVector<std::uint8_t, 64> output_;
  std::uint64_t bytes_lost_ = 0;
};

}  // namespace sinew

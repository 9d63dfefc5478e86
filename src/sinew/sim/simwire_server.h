#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "sinew/model/robot_model.h"
#include "sinew/sim/machine.h"
#include "sinew/wire/simwire.h"

namespace sinew::sim {

/// Answers simwire requests from a machine of boards on SPI: pins, transfers, statistics. The
/// machine's time is the host's: it advances to the stamp of each request, so that a host with a
/// virtual clock can run it as fast or slow as it likes. Stamps that run back, and those more than
/// an hour ahead of the last good one, are refused and change nothing; HELLO begins a new clock.
///
/// Pins that no board is wired to are ordinary outputs and inputs that nothing hangs on.
class SimwireServer {
 public:
  static constexpr std::size_t kPins = 64;
  static constexpr std::size_t kDevices = 8;  ///< that a host may have open at a time

  /// @param boards  where each axis is wired; @param name  answered to HELLO
  SimwireServer(SpiMachine& machine, std::span<const AxisBoard> boards, std::string_view name);

  /// The reply to one line, which has no LF.
  simwire::Reply answer(std::string_view line);

  /// The host said BYE: whoever comes next starts with HELLO.
  bool finished() const { return finished_; }
  /// A new host is there; pins and buses are as at power-on, the machine stays as it is.
  void restart();
  /// The machine's time.
  Instant now() const { return now_; }

 private:
  struct Pin {
    bool output = false;
    bool latch = false;  ///< what an output drives
    simwire::Pull pull = simwire::Pull::kOff;
  };

  /// As spidev has it: opened as often as a host likes, and open until each of these is closed.
  struct OpenDevice {
    std::uint32_t bus = 0;
    std::uint32_t device = 0;
    std::uint32_t users = 0;
  };

  simwire::Reply act(const simwire::Hello& hello);
  simwire::Reply act(const simwire::Direction& direction);
  simwire::Reply act(const simwire::SetPin& set);
  simwire::Reply act(const simwire::GetPin& get);
  simwire::Reply act(const simwire::Open& open);
  simwire::Reply act(const simwire::Exchange& exchange);
  simwire::Reply act(const simwire::Close& close);
  simwire::Reply act(const simwire::Statistics& statistics);
  simwire::Reply act(const simwire::Dump& dump);
  simwire::Reply act(const simwire::Poke& poke);
  simwire::Reply act(const simwire::Fault& fault);
  simwire::Reply act(const simwire::Bye& bye);

  /// Why not; nothing where the time has passed.
  std::optional<std::string_view> advance_to(std::uint64_t time_us);
  void update_selects();
  /// Nothing where the host has not opened it.
  OpenDevice* find_open(std::uint32_t bus, std::uint32_t device);
  simwire::Report report(bool dump) const;

  SpiMachine& machine_;
  FixedVector<AxisBoard, kMaxJoints> boards_;
  simwire::Text name_;
  std::array<Pin, kPins> pins_{};
  FixedVector<OpenDevice, kDevices> open_;
  bool greeted_ = false;
  bool finished_ = false;
  std::optional<std::uint64_t> last_us_;
  Instant stamp_{};  ///< of the last request, on the machine's time line
  Instant now_{};
  simwire::Bytes miso_;
};

}  // namespace sinew::sim

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

struct uc_struct;

/// Hosts that run the images of firmware/ as they are flashed. Test programs only: libunicorn is
/// under the GPL, and nothing of this is linked into `sinew`.
namespace sinew::emulation {

/// Processor cycles since power came on.
using Cycles = std::uint64_t;

class CortexM;

/// A block of registers on the bus, with a clock that it shares with the processor.
class Peripheral {
 public:
  virtual ~Peripheral() = default;
  virtual std::uint32_t read(std::uint32_t offset) = 0;
  virtual void write(std::uint32_t offset, std::uint32_t value) = 0;
  /// When something happens in it by itself; not in the past.
  virtual std::optional<Cycles> next_event() const { return std::nullopt; }
  /// Everything that has happened by itself until `now`.
  virtual void advance(Cycles /*now*/) {}
};

/// A Cortex-M3 or M4 with its interrupt controller: libunicorn executes the instructions, and this
/// class takes interrupts in and out, counts cycles and lets time pass while the processor waits.
///
/// Time: each instruction takes `cycles_per_instruction` (flash wait states included; only silicon
/// knows better). Peripherals see the time of the block of instructions that runs, so that what
/// they do by themselves is exact, and what the program does is late by a block at most.
class CortexM {
 public:
  struct Settings {
    std::uint32_t flash_at = 0x0800'0000;
    std::uint32_t flash_size = 64 * 1024;
    std::uint32_t ram_at = 0x2000'0000;
    std::uint32_t ram_size = 20 * 1024;
    std::uint32_t clock_hz = 72'000'000;
    double cycles_per_instruction = 1.5;
  };

  explicit CortexM(const Settings& settings);
  ~CortexM();
  CortexM(const CortexM&) = delete;
  CortexM& operator=(const CortexM&) = delete;

  /// What would be flashed, from the first address on. The rest of the flash is erased (FF).
  void flash(std::span<const std::uint8_t> image);
  /// Registers at `address`, 1024 bytes; `peripheral` outlives this.
  void map(std::uint32_t address, Peripheral& peripheral);
  /// As the pin does it: registers as the vector table says, memory as it is.
  void reset();
  /// What memory holds when power comes back is anybody's guess.
  void spoil_memory();

  /// Runs until `cycles`, or until the program does what no program may; what that was.
  std::optional<std::string> run_until(Cycles cycles);

  Cycles now() const { return now_; }
  std::uint32_t clock_hz() const { return settings_.clock_hz; }
  std::uint64_t instructions() const { return instructions_; }
  /// Cycles in which the processor waited for an interrupt.
  Cycles idle() const { return idle_; }

  /// The longest time without such waiting, since it was last asked for.
  Cycles longest_work() { return std::exchange(longest_work_, 0); }

  /// A line of the interrupt controller: 0 is the first one behind the core's own.
  void raise(int line);
  /// As a broken program would do it.
  void disable(int line);
  /// Ends run_until() before its time.
  void stop();
  /// What the program did is no program's business; run_until() says so.
  void fail(std::string why);
  /// Done once run_until() has stopped.
  void after_stop(std::function<void()> what) { after_stop_ = std::move(what); }
  /// The processor stands still for so long.
  void stall(Cycles cycles) { now_ += cycles, look_again_ = true; }
  /// The program asked for a reset since reset().
  bool reset_wanted() const { return reset_wanted_; }
  /// Before the program writes into the flash.
  std::function<void(std::uint32_t address, std::uint32_t value, unsigned size)> on_flash_write =
      [](std::uint32_t, std::uint32_t, unsigned) {};
  /// What a peripheral does changed: its next event may be sooner now.
  void look_again() { look_again_ = true; }

  std::uint32_t load_word(std::uint32_t address) const;
  std::uint8_t load_byte(std::uint32_t address) const;
  void store_byte(std::uint32_t address, std::uint8_t value);
  /// Of one line: how often it was taken, and the most that it took and waited, in cycles.
  struct InterruptFigures {
    std::uint64_t taken = 0;
    Cycles longest = 0;
    Cycles latest = 0;
  };
  const InterruptFigures& figures(int line) const { return lines_[line].figures; }
  /// How deep the stack has been since spoil_memory(): what of the memory above all data was ever
  /// written. @return  bytes
  std::uint32_t stack_depth() const;

 private:
  static constexpr int kLines = 84;
  static constexpr int kThread = 256;  ///< priority of code that no interrupt runs

  struct Line {
    bool enabled = false;
    bool pending = false;
    std::uint8_t priority = 0;
    Cycles raised = 0;
    InterruptFigures figures;
  };
  struct Frame {
    int line;
    int priority;
    Cycles begun;
  };

  void block(std::uint32_t address, std::uint32_t size);
  std::uint32_t count(std::uint32_t address, std::uint32_t size);
  void advance_peripherals();
  int pending_line() const;
  void choose_line() { next_line_ = pending_line(); }
  int priority() const { return frames_.empty() ? kThread : frames_.back().priority; }
  bool masked() const;
  void enter(int line);
  void leave();
  std::uint32_t core_read(std::uint32_t offset) const;
  void core_write(std::uint32_t offset, std::uint32_t value);
  std::uint32_t reg(int id) const;
  void set_reg(int id, std::uint32_t value);

  struct Bus;
  std::unique_ptr<Bus> bus_;

  Settings settings_;
  uc_struct* uc_ = nullptr;
  std::vector<std::uint64_t> hooks_;
  std::unordered_map<std::uint64_t, std::uint32_t> counted_;  ///< instructions, by block
  double cycle_part_ = 0;
  Cycles now_ = 0;
  Cycles until_ = 0;
  Cycles next_event_ = 0;
  Cycles idle_ = 0;
  Cycles woke_ = 0;
  bool waiting_ = false;  ///< for an interrupt
  Cycles longest_work_ = 0;
  std::uint64_t instructions_ = 0;
  bool look_again_ = true;
  bool stopped_ = false;  ///< the block that was about to run has not
  std::optional<std::string> broken_;
  std::array<Line, kLines> lines_;
  std::vector<Frame> frames_;
  int next_line_ = -1;  ///< that would interrupt now, masks aside; -1 for none
  std::uint32_t vectors_ = 0;
  bool reset_wanted_ = false;
  bool stop_wanted_ = false;
  std::function<void()> after_stop_;
};

}  // namespace sinew::emulation

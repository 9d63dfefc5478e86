#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "firmware/emulation/cortex_m.h"
#include "firmware/emulation/stm32_flash.h"
#include "firmware/emulation/stm32_serial.h"
#include "firmware/emulation/stm32_timers.h"
#include "firmware/emulation/stm32_usart.h"

namespace sinew::emulation {

enum class Stm32Chip : std::uint8_t { kF103, kF401 };

/// An STM32 with the peripherals that the boards of firmware/stm32 use, its pins as they are seen
/// from outside, and a host on its SPI bus.
///
/// What only silicon can tell: how many cycles an instruction takes, what a flash with wait states
/// and an oscillator that is off by a percent make of it, and every level between high and low.
class Stm32 {
 public:
  Stm32(Stm32Chip chip, std::span<const std::uint8_t> image);

  /// As the reset pin does it: memory is what it was.
  void reset();
  /// Power was off: memory holds whatever it holds then.
  void power_cycle();
  std::optional<std::string> run_until(Cycles cycles);
  std::optional<std::string> run_for(double seconds);
  double seconds() const { return static_cast<double>(core_.now()) / core_.clock_hz(); }

  /// What drives a pin from outside; high where nothing does, as pull-ups have it.
  void set_input(char port, unsigned pin, bool high);
  /// What the program drives a pin to.
  bool output(char port, unsigned pin) const;

  /// The chip's own supply is below the threshold of its voltage detector (PVD), or not.
  void set_supply_low(bool low);

  /// A transfer of the host: chip select low, `setup` later the clocks, chip select high.
  /// @return  what came back; where the program broke, what there was
  std::vector<std::uint8_t> transfer(std::span<const std::uint8_t> mosi, std::uint32_t clock_hz,
                                     double setup_s);

  /// The clocks of a transfer begin; whoever is not selected must not get them.
  void clock_spi(std::span<const std::uint8_t> mosi, std::uint32_t clock_hz);
  /// What came back of them until now.
  std::span<const std::uint8_t> miso() const { return spi_.miso(); }

  CortexM& core() { return core_; }
  Stm32Timers& timers() { return timers_; }
  Stm32I2c& i2c1() { return i2c1_; }
  Stm32I2c& i2c2() { return i2c2_; }
  Stm32Usart& usart2() { return usart2_; }
  Stm32Flash& flash() { return flash_; }
  /// Resets by its watchdog.
  int bites() const { return bites_; }

 private:
  /// Registers that keep what is written, and say at once that all is ready.
  class Plain : public Peripheral {
   public:
    std::uint32_t read(std::uint32_t offset) override { return word[offset / 4]; }
    void write(std::uint32_t offset, std::uint32_t value) override;
    std::array<std::uint32_t, 256> word{};
    std::function<void(std::uint32_t offset, std::uint32_t value)> on_write = [](std::uint32_t,
                                                                                 std::uint32_t) {};
  };
  class Port : public Peripheral {
   public:
    Port(Stm32& chip, unsigned number) : chip_(chip), number_(number) {}
    std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value) override;
    std::array<std::uint32_t, 16> word{};
    std::uint32_t driven = 0;        ///< by the program
    std::uint32_t outside = 0xFFFF;  ///< by the world

   private:
    Stm32& chip_;
    unsigned number_;
  };
  class Interrupts : public Peripheral {
   public:
    explicit Interrupts(Stm32& chip) : chip_(chip) {}
    std::uint32_t read(std::uint32_t offset) override { return word[offset / 4]; }
    void write(std::uint32_t offset, std::uint32_t value) override;
    void edge(unsigned port, unsigned pin, bool high);
    std::array<std::uint32_t, 8> word{};

   private:
    Stm32& chip_;
  };
  class Dma : public Peripheral {
   public:
    explicit Dma(Stm32& chip) : chip_(chip) {}
    std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value) override;
    std::array<std::uint32_t, 64> word{};

   private:
    Stm32& chip_;
  };
  class Watchdog : public Peripheral {
   public:
    explicit Watchdog(Stm32& chip) : chip_(chip) {}
    std::uint32_t read(std::uint32_t offset) override { return word[offset / 4]; }
    void write(std::uint32_t offset, std::uint32_t value) override;
    std::optional<Cycles> next_event() const override { return bites_at; }
    void advance(Cycles now) override;
    std::array<std::uint32_t, 4> word{};
    std::optional<Cycles> bites_at;

   private:
    Stm32& chip_;
  };

  static CortexM::Settings core_settings(Stm32Chip chip);
  std::uint32_t pin_port(unsigned pin) const;

  Stm32Chip chip_;
  CortexM core_;
  Stm32Timers timers_;
  Stm32SpiSlave spi_;
  Stm32I2c i2c1_, i2c2_;
  Stm32Usart usart2_;
  Stm32Flash flash_;
  Plain clocks_, multiplexer_, power_;
  Plain backup_;  ///< survives a reset
  std::vector<Port> ports_;
  Interrupts interrupts_;
  Dma dma_;
  Watchdog watchdog_;
  int bites_ = 0;
  bool bitten_ = false;
};

/// The image of a board, as `make firmware` leaves it.
std::vector<std::uint8_t> read_image(const std::filesystem::path& path);

}  // namespace sinew::emulation

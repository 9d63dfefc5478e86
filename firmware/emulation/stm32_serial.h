#pragma once

#include <functional>
#include <vector>

#include "firmware/emulation/cortex_m.h"

namespace sinew::emulation {

/// SPI1 as a slave whose bytes go by DMA. What waits to be sent is fetched one byte ahead, as the
/// chip does it: what is changed in memory after that comes too late.
class Stm32SpiSlave : public Peripheral {
 public:
  /// One direction of its DMA, as the chip's own registers set it.
  struct Direction {
    bool enabled = false;
    std::uint32_t memory = 0;
    std::uint32_t left = 0;
  };

  explicit Stm32SpiSlave(CortexM& core) : core_(core) {}
  std::uint32_t read(std::uint32_t offset) override { return word_[offset / 4]; }
  void write(std::uint32_t offset, std::uint32_t value) override;
  void reset();

  std::optional<Cycles> next_event() const override;
  void advance(Cycles now) override;

  /// Clocks from now on, while it is selected; each byte takes so many cycles.
  void begin(std::span<const std::uint8_t> mosi, Cycles per_byte);
  /// What has come back since begin().
  std::span<const std::uint8_t> miso() const { return miso_; }
  void fetch();

  Direction in, out;

 private:
  std::uint8_t clock(std::uint8_t mosi);

  CortexM& core_;
  std::array<std::uint32_t, 4> word_{};
  bool waiting_ = false;  ///< a byte stands ready
  std::uint8_t next_ = 0;
  std::uint8_t last_ = 0;
  std::vector<std::uint8_t> mosi_, miso_;
  Cycles begun_ = 0;
  Cycles per_byte_ = 1;
};

/// A chip on the I2C bus, byte by byte.
class I2cChip {
 public:
  virtual ~I2cChip() = default;
  virtual bool acknowledges(std::uint8_t address) = 0;
  virtual void begin_write() = 0;
  virtual void put(std::uint8_t byte) = 0;
  virtual std::uint8_t get() = 0;
};

/// I2C1 as a master, RM0008 26.3.3 and RM0368 18.3.3.
class Stm32I2c : public Peripheral {
 public:
  explicit Stm32I2c(CortexM& core) : core_(core) {}
  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  std::optional<Cycles> next_event() const override { return done_at_; }
  void advance(Cycles now) override;
  void reset();

  I2cChip* chip = nullptr;
  bool data_held_low = false;  ///< by a chip that lost count: nothing goes on

 private:
  enum class Doing : std::uint8_t { kNothing, kStart, kAddress, kWrite, kRead, kStop };

  void start(Doing what, Cycles bits);
  void finish();
  void receive_next();

  CortexM& core_;
  std::uint32_t cr1_ = 0, cr2_ = 0, ccr_ = 0, trise_ = 0, sr1_ = 0;
  Doing doing_ = Doing::kNothing;
  std::optional<Cycles> done_at_;
  bool reads_ = false;
  bool data_full_ = false, shift_full_ = false, last_ = false, status_read_ = false;
  std::uint8_t data_ = 0, shift_ = 0;
};

}  // namespace sinew::emulation

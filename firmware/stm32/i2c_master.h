#pragma once

#include "firmware/stm32/board.h"
#include "firmware/stm32/registers.h"
#include "sinew/devices/encoder/encoder_device_i2c.h"

namespace sinew::stm32 {

/// An I2C block at 400 kHz, by asking its flags: a reading of three bytes takes 0.16 ms. What does
/// not come in time is a refusal, and the next transaction begins by freeing the bus: nine clocks
/// (UM10204, 3.1.16).
class I2cMaster : public I2cBus {
 public:
  struct Pin {
    board::Place place;
    unsigned function;  ///< alternate one, where the chip numbers them
  };
  /// @param block  one of I2C1 and I2C2
  I2cMaster(std::uint32_t block, Pin clock, Pin data) : block_(block), clock_(clock), data_(data) {}

  void start();
  bool write(std::uint8_t address, std::span<const std::uint8_t> bytes) override;
  /// @pre 3 <= out.size() <= 8
  bool read(std::uint8_t address, std::span<std::uint8_t> out) override;

 private:
  I2c& i2c() const { return at<I2c>(block_); }
  bool begin(std::uint8_t address_byte);
  bool wait(std::uint32_t flag);
  bool give_up();
  void free_bus();

  std::uint32_t block_;
  Pin clock_;
  Pin data_;
  bool stuck_ = false;
};

}  // namespace sinew::stm32

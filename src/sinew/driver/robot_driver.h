#pragma once

#include <memory>

#include "sinew/driver/driver.h"

namespace sinew {

/// A robot's driver: one of the two is there.
struct RobotDriver {
  std::unique_ptr<ByteDriver> byte;
  std::unique_ptr<SpiDriver> spi;

  explicit operator bool() const { return byte || spi; }
  Driver& get() const { return byte ? static_cast<Driver&>(*byte) : *spi; }
};

}  // namespace sinew

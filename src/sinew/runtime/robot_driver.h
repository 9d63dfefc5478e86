#pragma once

#include <memory>

#include "sinew/driver/driver.h"

namespace sinew::runtime {

/// A robot's driver: one of the two is there.
struct RobotDriver {
  std::unique_ptr<ByteDriver> byte;
  std::unique_ptr<SpiDriver> spi;

  explicit operator bool() const { return byte || spi; }
  Driver& get() const { return byte ? static_cast<Driver&>(*byte) : *spi; }
};

/// @param patience  a device whose time runs faster than ours is answered late; what the driver
///                  waits for answers is stretched by so much.
RobotDriver make_driver(const RobotModel& robot, double patience = 1);

}  // namespace sinew::runtime

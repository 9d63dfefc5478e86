#pragma once

#include <memory>
#include <string_view>

#include "sinew/driver/driver.h"

namespace sinew::runtime {

/// A robot's driver: one of the two is there.
struct RobotDriver {
  std::unique_ptr<ByteDriver> byte;
  std::unique_ptr<SpiDriver> spi;

  explicit operator bool() const { return byte || spi; }
  Driver& get() const { return byte ? static_cast<Driver&>(*byte) : *spi; }
};

/// How long a device may take from an opened port to its first good answer, and what for.
///
/// Nobody can see whether a port's opening has reset the board behind it: an Arduino's boot loader
/// then listens for some 2 s, an ESP32 needs as long to start, and a MaxArm's MicroPython program
/// sleeps 10 s and homes 3.5 s. Elsewhere the driver's own three tries are all there is to wait
/// for.
struct Opening {
  Duration limit{};
  std::string_view waits_for;  ///< for people; behind "the device"
};
Opening opening_of(const RobotModel& robot);

/// @param patience  a device whose time runs faster than ours is answered late; what the driver
///                  waits for answers is stretched by so much.
RobotDriver make_driver(const RobotModel& robot, double patience = 1);

}  // namespace sinew::runtime

#pragma once

#include <memory>

#include "sinew/driver/driver.h"
#include "sinew/io/clock.h"
#include "sinew/io/port.h"
#include "sinew/io/spi_bus.h"
#include "sinew/runtime/links/byte_line.h"
#include "sinew/runtime/links/byte_log.h"

namespace sinew::runtime {

/// A driver on its wire in real (or scaled) time: what it has to say goes out, what comes goes in.
class DriverLine {
 public:
  virtual ~DriverLine() = default;

  /// Sends what is due, waits for an answer or for the driver's next deadline, `wait` at most, and
  /// hands both to the driver.
  /// @error  the wire failed; the driver has been told
  virtual io::IoResult<void> turn(Duration wait) = 0;

  virtual const ByteCount& count() const = 0;

  /// Nothing moves, and the control loop need not look before `wait` is over, however much time of
  /// a simulated machine passes meanwhile.
  void set_at_rest(bool at_rest) { at_rest_ = at_rest; }

 protected:
  bool at_rest() const { return at_rest_; }

 private:
  bool at_rest_ = false;
};

/// @param driver, port, clock, log  outlive the line
std::unique_ptr<DriverLine> line_over(ByteDriver& driver, io::Port& port, const io::Clock& clock,
                                      ByteLog& log);
std::unique_ptr<DriverLine> line_over(SpiDriver& driver, io::SpiBus& bus, const io::Clock& clock,
                                      ByteLog& log);

}  // namespace sinew::runtime

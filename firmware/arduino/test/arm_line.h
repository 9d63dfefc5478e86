#pragma once

#include <Arduino.h>

#include <deque>
#include <functional>
#include <vector>

#include "sinew/devices/maxarm/maxarm_machine.h"

namespace sinew::arduino {

struct TimedByte {
  std::uint8_t byte = 0;
  Instant due{};
};

/// A serial port of 9600 baud with a simulated MaxArm behind it, in virtual time.
class ArmLine : public Stream {
 public:
  using Chunk = std::vector<TimedByte>;

  explicit ArmLine(MaxArmChecksum checksum = MaxArmChecksum::kSpec,
                   MaxArmVariant variant = MaxArmVariant::kArduino, std::uint64_t seed = 3);

  size_t write(uint8_t byte) override { return write(&byte, 1); }
  size_t write(const uint8_t* bytes, size_t count) override;
  int available() override;
  int read() override;
  int peek() override;

  /// Unsolicited bytes, in the port now.
  void put_unsolicited(const std::vector<std::uint8_t>& bytes);
  /// Lets time pass for the arm, too.
  void wait(Duration time);
  sim::MaxArmMachine& machine() { return *machine_; }
  /// Another arm on the same line, powered for 20 s.
  void exchange(MaxArmChecksum checksum, MaxArmVariant variant);
  /// Servo pulse by the actual position.
  double pulse(std::size_t servo) const;

  /// write() waits until its bytes have left, as SoftwareSerial does.
  bool blocking = false;
  /// Faults: change each write before it reaches the arm, and each reply before the port.
  std::function<void(Chunk&)> to_arm;
  std::function<void(Chunk&)> from_arm;
  /// Each read returns this byte, without end.
  std::optional<std::uint8_t> babble;

  struct Write {
    Instant at{};
    std::vector<std::uint8_t> bytes;
  };
  std::vector<Write> writes;

 private:
  void pump();
  void take_replies(Instant at);

  std::unique_ptr<sim::MaxArmMachine> machine_;
  std::deque<TimedByte> outgoing_;
  std::deque<TimedByte> incoming_;
  Instant sent_until_{};
  Instant machine_now_{};
};

}  // namespace sinew::arduino

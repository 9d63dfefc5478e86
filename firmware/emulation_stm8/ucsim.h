#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace sinew::emulation {

/// The emulator sstm8 of uCsim as a process of its own, driven over its console. It is under the
/// GPL and is not linked.
class Ucsim {
 public:
  /// @param image  Intel hex. @throws std::runtime_error where the emulator does not start
  explicit Ucsim(const std::string& image);
  ~Ucsim();
  Ucsim(const Ucsim&) = delete;
  Ucsim& operator=(const Ucsim&) = delete;

  /// Commands, one a line, that are answered at once. @return what the console printed
  std::string command(std::string_view lines);
  /// Runs for that many clocks. @return what the console printed
  std::string run(std::uint64_t clocks);
  /// Bytes for the UART's input. They arrive while it runs, one behind the other.
  void send_uart(std::string_view bytes) const;

 private:
  std::string read() const;
  void write(std::string_view text) const;

  pid_t pid_ = -1;
  int in_ = -1;    ///< its console's input
  int out_ = -1;   ///< its console's output
  int uart_ = -1;  ///< its UART's input
};

}  // namespace sinew::emulation

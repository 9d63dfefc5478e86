#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace sinew::test {

/// An STM32's boot loader in its ROM, behind a pseudo-terminal (ST AN3155): what it is asked is
/// what a tool asks a board whose BOOT0 is 1.
class BootLoader {
 public:
  struct Chip {
    std::uint16_t id = 0x410;            ///< of an STM32F103 of medium density
    bool extended_erase = false;         ///< newer ones
    std::vector<std::uint32_t> sizes{};  ///< of the flash's pages or sectors, bytes
    bool read_protected = false;
    std::optional<std::size_t> dies_at{};  ///< its cable is pulled out at so many bytes written
  };
  explicit BootLoader(Chip chip);
  ~BootLoader();
  BootLoader(const BootLoader&) = delete;
  BootLoader& operator=(const BootLoader&) = delete;

  const std::string& port() const { return port_; }
  std::vector<std::uint8_t> flash() const;
  void put(std::size_t place, const std::vector<std::uint8_t>& bytes);
  /// Where it was told to start what was written; nothing: it was not.
  std::optional<std::uint32_t> started() const;
  /// Flash was written without an erase, so its content is wrong.
  bool spoiled() const;

 private:
  void serve();
  std::optional<std::uint8_t> next();
  std::optional<std::vector<std::uint8_t>> next(std::size_t count);
  void say(const std::vector<std::uint8_t>& bytes) const;
  void answer(bool good) const;
  void carry_out(std::uint8_t command);
  std::optional<std::uint32_t> address();
  void read_memory();
  void write_memory();
  void erase();
  void erase_page(std::size_t page);

  Chip chip_;
  int master_ = -1;
  int held_ = -1;  ///< the other end, so that it stays
  std::string port_;
  mutable std::mutex mutex_;
  std::vector<std::uint8_t> flash_;
  std::optional<std::uint32_t> started_;
  bool spoiled_ = false;
  std::size_t written_ = 0;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace sinew::test

#include "sinew/cli/boards/flash_tools.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace sinew::cli {
namespace {

constexpr std::uint32_t kFlashBegin = 0x08000000;
constexpr std::string_view kSpeed = "115200";
constexpr std::string_view kDfu = "0483:df11";

std::string place(std::uint32_t bytes) {
  return fmt::format("0x{:08x}:{}", kFlashBegin, bytes);
}

/// A hexadecimal number behind `before`.
std::optional<std::uint32_t> number_behind(std::string_view text, std::string_view before) {
  const std::size_t found = text.find(before);
  if (found == std::string_view::npos) return std::nullopt;
  text.remove_prefix(found + before.size());
  text.remove_prefix(std::min(text.find_first_not_of(" :\t"), text.size()));
  if (text.starts_with("0x")) text.remove_prefix(2);
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return error == std::errc{} && end != text.data() ? std::optional(value) : std::nullopt;
}

/// What a debug probe is run with.
std::vector<std::string> openocd(const FlashBoard& board, const std::string& commands) {
  return {"openocd", "-f",    "interface/stlink.cfg", "-f", std::string(board.probe_target),
          "-c",      commands};
}

/// What the boot loader of an Arduino Mega is spoken to with; it erases pages as it writes them.
std::vector<std::string> avrdude(const FlashBoard& board, const std::string& port,
                                 std::vector<std::string> more = {}) {
  std::vector<std::string> all{"avrdude", "-p", std::string(board.part), "-c", "wiring", "-P",
                               port,      "-b", std::string(kSpeed),     "-D"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos;
       at = text.find(part, at + part.size())) {
    ++count;
  }
  return count;
}

}  // namespace

std::string_view FlashTool::program() const {
  switch (way_) {
    case FlashWay::kSerial:
      return "stm32flash";
    case FlashWay::kUsb:
      return "dfu-util";
    case FlashWay::kArduino:
      return "avrdude";
    case FlashWay::kProbe:
      break;
  }
  return "openocd";
}

std::string_view FlashTool::how_to_end() const {
  if (way_ == FlashWay::kArduino) return "It has started: its LED blinks";
  return "BOOT0 back to 0, then reset. A new board is set up by sinew device ROBOT setup; sinew "
         "device ROBOT firmware shows what runs";
}

std::string_view FlashTool::how_to_begin() const {
  switch (way_) {
    case FlashWay::kSerial:
      return "wire a 3.3 V serial adapter to PA9 (its RX) and PA10 (its TX), set BOOT0 to 1 (or "
             "hold it down) and press reset";
    case FlashWay::kUsb:
      return "hold BOOT0 down, press and release reset (NRST), release BOOT0";
    case FlashWay::kArduino:
      return "plug the board's USB in; nothing else may use its port";
    case FlashWay::kProbe:
      break;
  }
  return "wire the ST-Link to SWDIO, SWCLK, 3V3 and GND";
}

FlashStep FlashTool::ask() const {
  const std::string what = "asks which chip is there";
  switch (way_) {
    case FlashWay::kSerial:
      return {what, {"stm32flash", "-b", std::string(kSpeed), port_}};
    case FlashWay::kUsb:
      return {what, {"dfu-util", "-l"}};
    case FlashWay::kArduino:
      return {what, avrdude(board_, port_)};
    case FlashWay::kProbe:
      break;
  }
  return {what, openocd(board_, "init; reset halt; mdw 0xe0042000; shutdown")};
}

std::expected<void, std::string> FlashTool::answered(std::string_view output) const {
  const auto wrong = [](std::string sentence) { return std::unexpected(std::move(sentence)); };
  if (way_ == FlashWay::kUsb) {
    const std::string device = fmt::format("[{}]", kDfu);
    const std::size_t flashes = count_of(output, "@Internal Flash");
    if (!output.contains(device) || flashes == 0) {
      return wrong(fmt::format("no board in boot mode is on USB: {}", how_to_begin()));
    }
    if (flashes > 1) return wrong("several boards in boot mode are on USB: unplug all but one");
    if (output.contains(board_.usb_flash)) return {};
    return wrong(fmt::format("the board on USB has another flash than a {}", board_.what));
  }
  const bool avr = way_ == FlashWay::kArduino;
  const std::string_view before = avr                         ? "Device signature ="
                                  : way_ == FlashWay::kSerial ? "Device ID"
                                                              : "0xe0042000:";
  const auto number = number_behind(output, before);
  if (!number) return wrong(fmt::format("no chip answers: {}", how_to_begin()));
  const auto chip = static_cast<std::uint16_t>(*number & (avr ? 0xFFFF : 0xFFF));
  if (std::ranges::find(board_.chips, chip) != board_.chips.end()) return {};
  return wrong(fmt::format("the chip there says that it is {:03x}; a {} says {:03x}", chip,
                           board_.what, board_.chips[0]));
}

FlashStep FlashTool::read_to(const std::string& file, std::uint32_t bytes) const {
  const std::string what = "reads what is on it";
  switch (way_) {
    case FlashWay::kSerial:
      return {what,
              {"stm32flash", "-b", std::string(kSpeed), "-r", file, "-S", place(bytes), port_}};
    case FlashWay::kUsb:
      return {what,
              {"dfu-util", "-d", std::string(kDfu), "-a", "0", "-s", place(bytes), "-U", file}};
    case FlashWay::kArduino:
      return {what, avrdude(board_, port_, {"-U", "flash:r:" + file + ":r"})};
    case FlashWay::kProbe:
      break;
  }
  return {what, openocd(board_, fmt::format("init; reset halt; dump_image {{{}}} 0x{:08x} {}; "
                                            "shutdown",
                                            file, kFlashBegin, bytes))};
}

FlashStep FlashTool::write(const std::string& file, std::uint32_t bytes) const {
  const std::string what = "writes the image";
  switch (way_) {
    case FlashWay::kSerial:
      // Without a length it would erase the setup as well.
      return {what,
              {"stm32flash", "-b", std::string(kSpeed), "-w", file, "-v", "-S", place(bytes), "-g",
               fmt::format("0x{:08x}", kFlashBegin), port_}};
    case FlashWay::kUsb:
      return {what,
              {"dfu-util", "-d", std::string(kDfu), "-a", "0", "-s",
               fmt::format("0x{:08x}", kFlashBegin), "-D", file}};
    case FlashWay::kArduino:
      return {what, avrdude(board_, port_, {"-U", "flash:w:" + file + ":r"})};
    case FlashWay::kProbe:
      break;
  }
  return {what, openocd(board_, fmt::format("program {{{}}} verify reset exit 0x{:08x}", file,
                                            kFlashBegin))};
}

}  // namespace sinew::cli

#include <fcntl.h>
#include <linux/gpio.h>
#include <linux/spi/spidev.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "sinew/io/spi_bus.h"

namespace sinew::io {
namespace {

constexpr std::size_t kBytesMax = 4096;  // of one exchange; spidev's own default bound

/// A descriptor that closes itself.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  int get() const { return number_; }
  bool valid() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

struct Bus {
  std::uint8_t bus = 0;
  std::uint8_t device = 0;
  std::string path;
  Descriptor descriptor;
};

IoError open_error(const std::string& path, int error, const char* group, const char* absent) {
  IoError complaint = system_error(path, error);
  if (error == EACCES) {
    complaint.sentence += std::string("; the group '") + group +
                          "' may use it: sudo adduser $USER " + group + ", then log in again";
  } else if (error == ENOENT) {
    complaint.sentence += std::string("; ") + absent;
  }
  return complaint;
}

IoResult<Bus> open_bus(const SpiBoard& board) {
  Bus bus{board.bus, board.device, {}, {}};
  bus.path = "/dev/spidev" + std::to_string(board.bus) + "." + std::to_string(board.device);
  bus.descriptor = Descriptor(::open(bus.path.c_str(), O_RDWR | O_CLOEXEC));
  if (!bus.descriptor.valid()) {
    return std::unexpected(
        open_error(bus.path, errno, "spi",
                   "on a Raspberry Pi switch SPI on with dtparam=spi=on in config.txt, or sudo "
                   "raspi-config, Interface Options"));
  }
  if (flock(bus.descriptor.get(), LOCK_EX | LOCK_NB) != 0) {
    return std::unexpected(IoError{bus.path + ": another program is using this bus"});
  }
  // Our selects are GPIO lines; where the driver cannot leave its own alone, nothing hangs on it.
  const std::uint8_t without_select = SPI_MODE_0 | SPI_NO_CS;
  const std::uint8_t plain = SPI_MODE_0;
  if (ioctl(bus.descriptor.get(), SPI_IOC_WR_MODE, &without_select) != 0 &&
      ioctl(bus.descriptor.get(), SPI_IOC_WR_MODE, &plain) != 0) {
    return std::unexpected(system_error(bus.path + ": SPI mode 0", errno));
  }
  return bus;
}

/// Lines of one chip, kept to this process by the kernel.
IoResult<Descriptor> request_lines(const Descriptor& chip, const std::string& name,
                                   std::span<const std::uint32_t> lines, bool output) {
  gpio_v2_line_request request{};
  request.num_lines = static_cast<std::uint32_t>(lines.size());
  std::copy(lines.begin(), lines.end(), std::begin(request.offsets));
  std::snprintf(request.consumer, sizeof request.consumer, "sinew");
  request.config.flags =
      output ? GPIO_V2_LINE_FLAG_OUTPUT : GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_BIAS_PULL_UP;
  if (output) {  // high before they become outputs: no board sees an edge that means nothing
    request.config.num_attrs = 1;
    request.config.attrs[0].mask = (1ULL << lines.size()) - 1;
    request.config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES;
    request.config.attrs[0].attr.values = (1ULL << lines.size()) - 1;
  }
  if (ioctl(chip.get(), GPIO_V2_GET_LINE_IOCTL, &request) != 0) {
    const int error = errno;
    std::string which;
    for (const std::uint32_t line : lines) which += " " + std::to_string(line);
    if (error == EBUSY) {
      return std::unexpected(IoError{name + ": another program holds one of the lines" + which});
    }
    return std::unexpected(system_error(name + ": lines" + which, error));
  }
  return Descriptor(request.fd);
}

class SpidevBus : public SpiBus {
 public:
  SpidevBus(std::vector<SpiBoard> boards, std::vector<Bus> buses, std::string chip_name,
            Descriptor selects, Descriptor ready_lines)
      : boards_(std::move(boards)),
        buses_(std::move(buses)),
        chip_name_(std::move(chip_name)),
        selects_(std::move(selects)),
        ready_lines_(std::move(ready_lines)) {}

  IoResult<void> exchange(std::uint8_t select, std::span<const std::uint8_t> mosi,
                          std::span<std::uint8_t> miso, Duration setup,
                          std::uint32_t clock_hz) override {
    if (mosi.size() != miso.size() || mosi.size() > kBytesMax) {
      return std::unexpected(IoError{"SPI: an exchange of this length cannot be made"});
    }
    if (auto low = drive(select, false); !low) return low;
    std::ranges::fill(miso, 0xFF);
    IoResult<void> result;
    for (const Bus& bus : buses_) {
      if ((boards_on(bus) & select) == 0) continue;
      result = transfer(bus, mosi, miso, setup, clock_hz);
      if (!result) break;
    }
    const auto high = drive(select, true);
    return result ? high : result;
  }

  IoResult<bool> ready(std::size_t board) override {
    gpio_v2_line_values values{};
    values.mask = 1ULL << board;
    if (ioctl(ready_lines_.get(), GPIO_V2_LINE_GET_VALUES_IOCTL, &values) != 0) {
      return std::unexpected(system_error(chip_name_, errno));
    }
    return (values.bits & values.mask) != 0;
  }

 private:
  std::uint8_t boards_on(const Bus& bus) const {
    std::uint8_t mask = 0;
    for (std::size_t i = 0; i < boards_.size(); ++i) {
      if (boards_[i].bus == bus.bus && boards_[i].device == bus.device) {
        mask = static_cast<std::uint8_t>(mask | (1U << i));
      }
    }
    return mask;
  }

  IoResult<void> drive(std::uint8_t select, bool high) {
    gpio_v2_line_values values{};
    values.mask = select;
    values.bits = high ? select : 0;
    if (ioctl(selects_.get(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values) != 0) {
      return std::unexpected(system_error(chip_name_ + ": chip selects", errno));
    }
    return {};
  }

  IoResult<void> transfer(const Bus& bus, std::span<const std::uint8_t> mosi,
                          std::span<std::uint8_t> miso, Duration setup, std::uint32_t clock_hz) {
    received_.assign(mosi.size(), 0);
    // The setup time is an empty message of its own: the kernel waits it more exactly than we do.
    spi_ioc_transfer messages[2]{};
    messages[0].speed_hz = clock_hz;
    messages[0].delay_usecs = static_cast<std::uint16_t>(
        std::clamp<std::int64_t>(setup / std::chrono::microseconds(1), 0, 0xFFFF));
    messages[1].tx_buf = reinterpret_cast<std::uintptr_t>(mosi.data());
    messages[1].rx_buf = reinterpret_cast<std::uintptr_t>(received_.data());
    messages[1].len = static_cast<std::uint32_t>(mosi.size());
    messages[1].speed_hz = clock_hz;
    messages[1].bits_per_word = 8;
    if (ioctl(bus.descriptor.get(), SPI_IOC_MESSAGE(2), messages) < 0) {
      return std::unexpected(system_error(bus.path, errno));
    }
    for (std::size_t i = 0; i < miso.size(); ++i) miso[i] &= received_[i];
    return {};
  }

  std::vector<SpiBoard> boards_;
  std::vector<Bus> buses_;
  std::string chip_name_;
  Descriptor selects_;
  Descriptor ready_lines_;
  std::vector<std::uint8_t> received_;
};

}  // namespace

IoResult<std::unique_ptr<SpiBus>> open_spidev(std::span<const SpiBoard> boards,
                                              const std::string& gpio_chip) {
  std::vector<Bus> buses;
  for (const SpiBoard& board : boards) {
    const bool known = std::ranges::any_of(
        buses, [&](const Bus& bus) { return bus.bus == board.bus && bus.device == board.device; });
    if (known) continue;
    auto bus = open_bus(board);
    if (!bus) return std::unexpected(bus.error());
    buses.push_back(std::move(*bus));
  }
  const Descriptor chip(::open(gpio_chip.c_str(), O_RDWR | O_CLOEXEC));
  if (!chip.valid()) {
    return std::unexpected(open_error(gpio_chip, errno, "gpio",
                                      "ls /dev/gpiochip* shows the chips; this needs a board with "
                                      "GPIO lines, as a Raspberry Pi"));
  }
  std::vector<std::uint32_t> selects;
  std::vector<std::uint32_t> ready_lines;
  for (const SpiBoard& board : boards) {
    selects.push_back(board.select_gpio);
    ready_lines.push_back(board.ready_gpio);
  }
  auto select_lines = request_lines(chip, gpio_chip, selects, true);
  if (!select_lines) return std::unexpected(select_lines.error());
  auto input_lines = request_lines(chip, gpio_chip, ready_lines, false);
  if (!input_lines) return std::unexpected(input_lines.error());
  return std::make_unique<SpidevBus>(std::vector<SpiBoard>(boards.begin(), boards.end()),
                                     std::move(buses), gpio_chip, std::move(*select_lines),
                                     std::move(*input_lines));
}

}  // namespace sinew::io

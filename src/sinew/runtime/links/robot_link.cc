#include "sinew/runtime/links/robot_link.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/kinds.h"
#include "sinew/io/local_socket.h"
#include "sinew/runtime/cameras/simulated_table.h"
#include "sinew/runtime/links/robot_variant.h"
#include "sinew/runtime/links/simulated_line.h"
#include "sinew/runtime/links/simwire_bus.h"

namespace sinew::runtime {
namespace {

constexpr std::string_view kSimwire = "simwire:";
constexpr std::string_view kSpidev = "spidev";

constexpr std::string_view kUnix = "unix:";
constexpr std::string_view kTcp = "tcp:";

bool is_simwire(const std::string& port) {
  return port.starts_with(kSimwire) || port.starts_with(kUnix);
}

std::string place_of(const std::string& port) {
  return port.starts_with(kSimwire) ? port.substr(kSimwire.size()) : port;
}

}  // namespace

io::IoResult<std::unique_ptr<io::SpiBus>> open_spi(const RobotModel& robot, const std::string& port,
                                                   const io::Clock& clock) {
  const auto boards = boards_of(robot.device);
  if (port == kSpidev) {
    std::vector<io::SpiBoard> places;
    for (const AxisBoard& board : boards) {
      places.push_back({board.spi_bus, board.spi_device, board.select_gpio, board.ready_gpio});
    }
    return io::open_spidev(places);
  }
  const std::string place = place_of(port);
  auto connected = place.starts_with(kUnix) ? io::connect_local(place.substr(kUnix.size()))
                                            : io::connect_tcp(place.substr(kTcp.size()));
  if (!connected) return std::unexpected(connected.error());
  return connect_simwire(std::move(*connected), boards, clock);
}

/// In the order in which they are taken apart, last first.
struct RobotLink::Parts {
  const RobotModel& robot;
  const io::Clock& clock;
  ByteLog& log;
  std::unique_ptr<sim::ByteMachine> device;  ///< a simulated one that speaks bytes
  std::unique_ptr<sim::SpiMachine> boards;   ///< simulated ones on SPI
  std::optional<io::Port> port;
  std::unique_ptr<io::SpiBus> bus;
  RobotDriver driver;
  std::unique_ptr<DriverLine> line;
  std::string name;
};

std::unique_ptr<RobotLink::Parts> RobotLink::parts_for(const RobotModel& robot,
                                                       const io::Clock& clock, ByteLog& log) {
  // Real delays of this computer do not shrink where the device's time runs faster.
  const double patience = clock.is_simulated() ? 1 : std::max(1.0, clock.scale());
  return std::unique_ptr<Parts>(new Parts{.robot = robot,
                                          .clock = clock,
                                          .log = log,
                                          .device = {},
                                          .boards = {},
                                          .port = {},
                                          .bus = {},
                                          .driver = make_driver(robot, patience),
                                          .line = {},
                                          .name = {}});
}

RobotLink::RobotLink(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
RobotLink::RobotLink(RobotLink&&) noexcept = default;
RobotLink::~RobotLink() = default;

io::IoResult<RobotLink> RobotLink::prepare(const RobotModel& robot, const std::string& port,
                                           const io::Clock& clock, ByteLog& log) {
  if (const auto why = wrong_port(robot, port)) return std::unexpected(io::IoError{*why});
  auto parts = parts_for(robot, clock, log);
  parts->name = port;
  return RobotLink(std::move(parts));
}

io::IoResult<void> RobotLink::connect() {
  Parts& parts = *parts_;
  if (parts.device || parts.boards) return {};
  disconnect();  // before it is opened again: it is held exclusively
  if (parts.driver.byte) {
    auto opened = parts.name.starts_with(kTcp)
                      ? io::connect_tcp(parts.name.substr(kTcp.size()))
                      : io::Port::open_serial(parts.name, parts.robot.device.baud);
    if (!opened) return std::unexpected(opened.error());
    parts.port.emplace(std::move(*opened));
    parts.line = line_over(*parts.driver.byte, *parts.port, parts.clock, parts.log);
    return {};
  }
  auto bus = open_spi(parts.robot, parts.name, parts.clock);
  if (!bus) return std::unexpected(bus.error());
  parts.bus = std::move(*bus);
  parts.line = line_over(*parts.driver.spi, *parts.bus, parts.clock, parts.log);
  return {};
}

void RobotLink::disconnect() {
  if (simulated()) return;
  parts_->line.reset();
  parts_->port.reset();
  parts_->bus.reset();
}

io::IoResult<RobotLink> RobotLink::simulate(const RobotModel& robot,
                                            const SimulatedMachine& simulated,
                                            const io::Clock& clock, ByteLog& log) {
  SINEW_ASSERT(clock.is_simulated());
  auto machine = make_machine(robot, simulated.variant, clock.now());
  if (!machine) return std::unexpected(io::IoError{machine.error()});
  if (machine->byte && simulated.table != nullptr) {
    machine->byte =
        simulated.table->under(std::move(machine->byte), robot, simulated.place, clock.now());
  }
  auto parts = parts_for(robot, clock, log);
  parts->name = "its simulated device";
  if (machine->spi) {
    parts->boards = std::move(machine->spi);
    parts->bus = bus_of(*parts->boards, clock);
    parts->line = line_over(*parts->driver.spi, *parts->bus, clock, log);
  } else {
    parts->device = std::move(machine->byte);
    parts->line =
        simulated_line(*parts->driver.byte, *parts->device, robot.device.baud, clock, log);
  }
  return RobotLink(std::move(parts));
}

Driver& RobotLink::driver() const {
  return parts_->driver.get();
}
DriverLine& RobotLink::line() const {
  return *parts_->line;
}
const std::string& RobotLink::name() const {
  return parts_->name;
}
bool RobotLink::simulated() const {
  return parts_->device || parts_->boards;
}

std::optional<sim::Truth> RobotLink::truth() const {
  if (parts_->device) return parts_->device->truth();
  if (parts_->boards) return parts_->boards->truth();
  return std::nullopt;
}

std::optional<std::string> wrong_port(const RobotModel& robot, const std::string& port) {
  if (!boards_of(robot.device).empty()) {
    const std::string place = place_of(port);
    const bool place_known = place.starts_with(kUnix) || place.starts_with(kTcp);
    if ((is_simwire(port) && place_known) || port == kSpidev) return std::nullopt;
    return port + ": this robot hangs on SPI; its port is spidev, simwire:unix:PATH or " +
           "simwire:tcp:HOST:PORT";
  }
  if (!is_simwire(port) && port != kSpidev) return std::nullopt;
  return port + ": " + robot.id + " hangs on a serial port, not on SPI; its port is a device as " +
         "/dev/ttyUSB0, tcp:HOST:PORT, or the pseudo-terminal that sinew sim " + robot.id +
         " shows";
}

io::Clock clock_for(const std::optional<std::string>& port, double scale) {
  return !port || is_simwire(*port) ? io::Clock::simulated(scale) : io::Clock(scale);
}

bool may_be_simulated(const std::optional<std::string>& port) {
  if (!port || is_simwire(*port)) return true;
  std::error_code error;  // the port may be a link to a pseudo-terminal
  return std::filesystem::weakly_canonical(*port, error).string().starts_with("/dev/pts/");
}

}  // namespace sinew::runtime

#include "sinew/runtime/robot_link.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/driver/axis_link.h"
#include "sinew/driver/axis_registers.h"
#include "sinew/io/local_socket.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/simulated_line.h"
#include "sinew/runtime/simwire_bus.h"

namespace sinew::runtime {
namespace {

constexpr std::string_view kSimwire = "simwire:";
constexpr std::string_view kSpidev = "spidev";

constexpr std::string_view kUnix = "unix:";
constexpr std::string_view kTcp = "tcp:";

bool is_simwire(const std::string& port) {
  return port.starts_with(kSimwire) || port.starts_with(kUnix) || port.starts_with(kTcp);
}

std::string place_of(const std::string& port) {
  return port.starts_with(kSimwire) ? port.substr(kSimwire.size()) : port;
}

io::IoResult<std::unique_ptr<io::SpiBus>> open_bus(const RobotModel& robot, const std::string& port,
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

}  // namespace

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
    auto opened = io::Port::open_serial(parts.name, parts.robot.device.baud);
    if (!opened) return std::unexpected(opened.error());
    parts.port.emplace(std::move(*opened));
    parts.line = line_over(*parts.driver.byte, *parts.port, parts.clock, parts.log);
    return {};
  }
  auto bus = open_bus(parts.robot, parts.name, parts.clock);
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

io::IoResult<RobotLink> RobotLink::simulate(const RobotModel& robot, const MachineOptions& options,
                                            const io::Clock& clock, ByteLog& log) {
  SINEW_ASSERT(clock.is_simulated());
  auto machine = make_machine(robot, options, clock.now());
  if (!machine) return std::unexpected(io::IoError{machine.error()});
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
  const std::string place = place_of(port);
  const bool simwire = place.starts_with(kUnix) || place.starts_with(kTcp);
  if (!boards_of(robot.device).empty()) {
    if (simwire || port == kSpidev) return std::nullopt;
    return port + ": this robot hangs on SPI; its port is spidev, simwire:unix:PATH or " +
           "simwire:tcp:HOST:PORT";
  }
  if (!simwire && !port.starts_with(kSimwire) && port != kSpidev) return std::nullopt;
  return port + ": " + robot.id + " hangs on a serial port, not on SPI; its port is a device as " +
         "/dev/ttyUSB0, or the pseudo-terminal that sinew sim " + robot.id + " shows";
}

io::Clock clock_for(const std::optional<std::string>& port, double scale) {
  return !port || is_simwire(*port) ? io::Clock::simulated(scale) : io::Clock(scale);
}

namespace {

/// The boards that are silent while others answer, for people; empty where there are none.
template <class BoardDriver>
std::string silent_boards(const BoardDriver& driver) {
  std::string names;
  std::size_t silent = 0;
  const std::size_t joints = driver.positions().size();
  for (std::size_t i = 0; i < joints; ++i) {
    const auto fault = driver.axis_fault(i);
    if (!fault || fault->code != ErrorCode::kDeviceSilent) continue;
    names += (silent++ == 0 ? "J" : ", J") + std::to_string(i + 1);
  }
  if (silent == 0 || silent == joints) return {};
  const std::string many = std::to_string(silent) + " of " + std::to_string(joints) + " boards";
  std::string list = "[";
  for (std::size_t i = 0; i < joints; ++i) {
    const auto fault = driver.axis_fault(i);
    if (!fault || fault->code != ErrorCode::kDeviceSilent) continue;
    list += (list.size() > 1 ? ", \"J" : "\"J") + std::to_string(i + 1) + "\"";
  }
  std::string option = names;
  std::erase(option, ' ');
  return many + (silent == 1 ? " does" : " do") + " not answer: " + names +
         "; to use the others: --without " + option +
         " of run, commission, doctor or device, in a cell's file without = " + list + "]";
}

}  // namespace

std::string suspicion(const Driver& driver) {
  if (const auto* link = dynamic_cast<const AxisLinkDriver*>(&driver)) return silent_boards(*link);
  const auto* boards = dynamic_cast<const AxisRegistersDriver*>(&driver);
  if (boards == nullptr) return {};
  if (const std::string silent = silent_boards(*boards); !silent.empty()) return silent;
  if (!boards->statuses_are_blank()) return {};
  return "the status of every board reads zero: looks like boards with the first firmware; "
         "try --profile as-built";
}

bool may_be_simulated(const std::optional<std::string>& port) {
  if (!port || is_simwire(*port)) return true;
  std::error_code error;  // the port may be a link to a pseudo-terminal
  return std::filesystem::weakly_canonical(*port, error).string().starts_with("/dev/pts/");
}

}  // namespace sinew::runtime

#include "sinew/io/port.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <vector>

#include "sinew/io/baud_rate.h"
#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

/// Both ends of a line: the device's side and the host's.
struct Pair {
  Port device;
  Port host;
};

Pair make_pair() {
  auto device = Port::open_pseudo_terminal();
  if (!device) throw std::runtime_error(device.error().sentence);
  auto host = Port::open_serial(device->path(), 250'000);
  if (!host) throw std::runtime_error(host.error().sentence);
  return {std::move(*device), std::move(*host)};
}

Bytes read_all(Port& port, std::size_t count) {
  Bytes bytes;
  std::array<std::uint8_t, 100> buffer{};
  while (bytes.size() < count) {
    const auto size = port.read(buffer, 1s);
    if (!size || *size == 0) break;
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + static_cast<long>(*size));
  }
  return bytes;
}

std::string refusal(const IoResult<Port>& result) {
  return result ? "accepted" : result.error().sentence;
}

/// All values, then the ones that terminals like to act on, once more and next to each other.
Bytes every_byte() {
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  const Bytes more{0x11, 0x13, 0x0D, 0x0A, 0x03, 0x04, 0x1A, 0x1C, 0x7F,
                   0x00, 0xFF, 0xFF, 0x00, 0x0D, 0x0D, 0x0A, 0x0A};
  bytes.insert(bytes.end(), more.begin(), more.end());
  return bytes;
}

TEST(Port, every_byte_passes_unchanged_both_ways) {
  auto [device, host] = make_pair();
  const Bytes bytes = every_byte();
  ASSERT_TRUE(host.write(bytes));
  EXPECT_EQ(read_all(device, bytes.size()), bytes);
  ASSERT_TRUE(device.write(bytes));
  EXPECT_EQ(read_all(host, bytes.size()), bytes);
  // And none came back as an echo.
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(*host.read(buffer, 1ms), 0U);
  EXPECT_EQ(*device.read(buffer, 1ms), 0U);
}

TEST(Port, read_gives_up_after_about_the_time_asked_for) {
  auto [device, host] = make_pair();
  std::array<std::uint8_t, 8> buffer{};
  for (const auto timeout : {0ms, 20ms, 60ms}) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(*host.read(buffer, timeout), 0U);
    const auto took = std::chrono::steady_clock::now() - start;
    EXPECT_GE(took, timeout);
    EXPECT_LT(took, timeout + 150ms);
  }
}

TEST(Port, read_without_patience_still_takes_what_is_there) {
  auto [device, host] = make_pair();
  ASSERT_TRUE(device.write(Bytes{1, 2, 3}));
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(*host.read(buffer, Duration::zero()), 3U);
  EXPECT_EQ(buffer[2], 3);
}

TEST(Port, read_returns_at_once_with_what_there_is_and_keeps_the_rest) {
  auto [device, host] = make_pair();
  ASSERT_TRUE(device.write(Bytes{1, 2, 3, 4, 5}));
  std::array<std::uint8_t, 3> buffer{};
  EXPECT_EQ(*host.read(buffer, 1s), 3U);
  EXPECT_EQ(*host.read(buffer, 1s), 2U);
  EXPECT_EQ(buffer[1], 5);
}

TEST(Port, long_messages_pass_while_the_other_side_reads) {
  auto [device, host] = make_pair();
  Bytes sent;
  Bytes received;
  for (int piece = 0; piece < 40; ++piece) {
    Bytes bytes(1000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(&byte - bytes.data() + piece);
    ASSERT_TRUE(host.write(bytes));
    const Bytes arrived = read_all(device, bytes.size());
    sent.insert(sent.end(), bytes.begin(), bytes.end());
    received.insert(received.end(), arrived.begin(), arrived.end());
  }
  EXPECT_EQ(received, sent);
}

TEST(Port, reader_that_takes_nothing_ends_a_write_but_not_a_write_now) {
  auto [device, host] = make_pair();
  const Bytes much(1 << 20);
  const auto taken = device.write_now(much);
  ASSERT_TRUE(taken);
  EXPECT_GT(*taken, 0U);
  EXPECT_LT(*taken, much.size());
  const auto again = device.write_now(much);
  ASSERT_TRUE(again);
  EXPECT_LT(*again, much.size());
  const auto start = std::chrono::steady_clock::now();
  const auto written = device.write(much);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().sentence, device.path() + ": the port takes no bytes");
  EXPECT_LT(std::chrono::steady_clock::now() - start, 3s);
}

TEST(Port, second_opener_is_refused_until_the_first_has_gone) {
  auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  {
    const auto first = Port::open_serial(device->path(), 9600);
    ASSERT_TRUE(first);
    EXPECT_EQ(refusal(Port::open_serial(device->path(), 9600)),
              device->path() + ": another program is using this port");
  }
  EXPECT_TRUE(Port::open_serial(device->path(), 9600));
}

/// The kernel's exclusive mode stays on a pseudo-terminal that its device holds open, and only root
/// gets past it: everybody else had one run per simulation.
TEST(Port, user_who_is_not_root_opens_a_port_again_and_again) {
  auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  const bool root = geteuid() == 0;
  if (root) {
    ASSERT_EQ(chown(device->path().c_str(), 65534, 65534), 0);
    ASSERT_EQ(seteuid(65534), 0);
  }
  std::string last;
  for (int i = 0; i < 3; ++i) last = refusal(Port::open_serial(device->path(), 9600));
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  EXPECT_EQ(last, "accepted");
}

TEST(Port, host_that_was_killed_leaves_the_port_to_the_next) {
  auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  const pid_t child = fork();
  if (child == 0) {
    auto port = Port::open_serial(device->path(), 9600);
    static_cast<void>(port->write(Bytes{42}));
    pause();
  }
  EXPECT_EQ(read_all(*device, 1), Bytes{42});
  EXPECT_EQ(refusal(Port::open_serial(device->path(), 9600)),
            device->path() + ": another program is using this port");
  ASSERT_EQ(kill(child, SIGKILL), 0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_TRUE(Port::open_serial(device->path(), 9600));
}

TEST(Port, what_is_no_serial_port_is_refused_with_its_name) {
  const test::ScratchFolder folder;
  const std::string look = "; ls /dev/serial/by-id shows what is plugged in";
  const std::string file = folder.file("file", "x");
  EXPECT_EQ(refusal(Port::open_serial(file, 9600)), file + ": not a serial port" + look);
  EXPECT_EQ(test::text_of(file), "x");
  EXPECT_EQ(refusal(Port::open_serial("/dev/null", 9600)), "/dev/null: not a serial port" + look);
  EXPECT_EQ(refusal(Port::open_serial(folder.at(), 9600)), folder.at() + ": is a directory");
  EXPECT_EQ(refusal(Port::open_serial(folder.at("no"), 9600)),
            folder.at("no") + ": no such file or directory" + look);
  const std::string pipe = folder.at("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(refusal(Port::open_serial(pipe, 9600)), pipe + ": not a serial port" + look);
}

TEST(Port, other_side_that_goes_away_ends_read_and_write) {
  std::optional<Pair> pair(make_pair());
  Port host = std::move(pair->host);
  const std::string path = host.path();
  pair.reset();
  std::array<std::uint8_t, 8> buffer{};
  const auto count = host.read(buffer, 1s);
  ASSERT_FALSE(count);
  EXPECT_EQ(count.error().sentence, path + ": the other side closed the port");
  const auto written = host.write(Bytes{1});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().sentence, path + ": the other side closed the port");
  const auto now = host.write_now(Bytes{1});
  ASSERT_FALSE(now);
  EXPECT_EQ(now.error().sentence, path + ": the other side closed the port");
}

TEST(Port, write_that_finds_no_room_says_so_and_not_that_somebody_left) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  auto port = Port::from_descriptors(pipe[0], ::open("/dev/full", O_WRONLY), "stdin and stdout");
  ASSERT_TRUE(port) << port.error().sentence;
  const auto written = port->write(Bytes{1});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().sentence, "stdin and stdout: no space left on device");
  const auto now = port->write_now(Bytes{1});
  ASSERT_FALSE(now);
  EXPECT_EQ(now.error().sentence, "stdin and stdout: no space left on device");
  ::close(pipe[1]);
}

TEST(Port, device_outlives_hosts_that_come_and_go) {
  auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  for (std::uint8_t i = 0; i < 20; ++i) {
    auto host = Port::open_serial(device->path(), 9600);
    ASSERT_TRUE(host) << host.error().sentence;
    ASSERT_TRUE(host->write(Bytes{i}));
    EXPECT_EQ(read_all(*device, 1), Bytes{i});
  }
}

TEST(Port, host_does_not_get_what_was_meant_for_the_one_before) {
  auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  {
    ASSERT_TRUE(Port::open_serial(device->path(), 9600));
  }
  ASSERT_TRUE(device->write(Bytes{1, 2, 3}));
  auto host = Port::open_serial(device->path(), 9600);
  ASSERT_TRUE(host);
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(*host->read(buffer, 1ms), 0U);
}

TEST(Port, is_raw_eight_bits_at_the_asked_rate_and_keeps_dtr_when_it_closes) {
  auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  auto host = Port::open_serial(device->path(), 250'000);
  ASSERT_TRUE(host);
  const int descriptor = ::open(device->path().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(descriptor, 0);
  termios settings{};
  ASSERT_EQ(tcgetattr(descriptor, &settings), 0);
  EXPECT_EQ(baud_rate(descriptor), 250'000U);
  ::close(descriptor);
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG | IEXTEN), 0U);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF | ICRNL | INLCR | ISTRIP | PARMRK), 0U);
  EXPECT_EQ(settings.c_oflag & OPOST, 0U);
  EXPECT_EQ(settings.c_cflag & (CSIZE | PARENB | CSTOPB | CRTSCTS | HUPCL), unsigned{CS8});
}

}  // namespace
}  // namespace sinew::io

#include "sinew/io/local_socket.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "sinew/io/spi_bus.h"
#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

using namespace std::chrono_literals;

std::string all_that_came(Port& port) {
  std::array<std::uint8_t, 64> buffer{};
  const auto size = port.read(buffer, 1s);
  if (!size) return "error: " + size.error().sentence;
  return {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size)};
}

std::span<const std::uint8_t> bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(LocalSocket, carries_bytes_both_ways_and_clients_may_come_and_go) {
  const test::ScratchFolder folder;
  auto listener = LocalListener::create(folder.at("s"));
  ASSERT_TRUE(listener);
  for (int round = 0; round < 2; ++round) {
    auto client = connect_local(folder.at("s"));
    ASSERT_TRUE(client);
    auto server = listener->accept(1s);
    ASSERT_TRUE(server && *server);
    ASSERT_TRUE(client->write(bytes("HELLO\n")));
    EXPECT_EQ(all_that_came(**server), "HELLO\n");
    ASSERT_TRUE((*server)->write(bytes("OK\n")));
    EXPECT_EQ(all_that_came(*client), "OK\n");
  }
  const auto nobody = listener->accept(1ms);
  ASSERT_TRUE(nobody);
  EXPECT_FALSE(*nobody);
}

TEST(LocalSocket, name_in_use_is_refused_and_a_dead_socket_is_replaced) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("s");
  {
    auto first = LocalListener::create(path);
    ASSERT_TRUE(first);
    using std::filesystem::perms;
    EXPECT_EQ(std::filesystem::status(path).permissions(), perms::owner_read | perms::owner_write)
        << "this user's alone";
    const auto second = LocalListener::create(path);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().sentence, path + ": another program listens there");
    EXPECT_TRUE(connect_local(path)) << "the first one still listens";
  }
  EXPECT_FALSE(std::filesystem::exists(path)) << "the file goes away with its listener";
  std::ofstream(path) << "precious";
  const auto file = LocalListener::create(path);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().sentence, path + ": is there already, and is no socket");
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(LocalSocket, nobody_there_is_told_with_the_name) {
  const test::ScratchFolder folder;
  const auto none = connect_local(folder.at("nobody"));
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().sentence.find("nobody: no such file"), std::string::npos);
  EXPECT_FALSE(connect_local(std::string(200, 'x')));
  EXPECT_FALSE(connect_local(""));
  const auto no_port = connect_tcp("127.0.0.1");
  ASSERT_FALSE(no_port);
  EXPECT_EQ(no_port.error().sentence, "127.0.0.1: write HOST:PORT");
  EXPECT_FALSE(connect_tcp("127.0.0.1:1"));
}

TEST(SpidevBus, missing_device_is_told_with_the_remedy) {
  const std::array boards{SpiBoard{.bus = 9, .device = 9, .select_gpio = 5, .ready_gpio = 22}};
  const auto bus = open_spidev(boards);
  ASSERT_FALSE(bus);
  EXPECT_NE(bus.error().sentence.find("/dev/spidev9.9: no such file or directory; on a Raspberry "
                                      "Pi switch SPI on"),
            std::string::npos)
      << bus.error().sentence;
}

}  // namespace
}  // namespace sinew::io

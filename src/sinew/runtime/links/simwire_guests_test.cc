#include "sinew/runtime/links/simwire_guests.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "sinew/devices/kinds.h"
#include "sinew/io/standard_streams.h"
#include "sinew/runtime/links/robot_variant.h"
#include "sinew/runtime/links/simwire_bus.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using test::ScratchFolder;

constexpr const char* kTurnedAway =
    "ERR another host is connected to these boards; one at a time\n";

void say(io::Port& port, const std::string& text) {
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  ASSERT_TRUE(port.write(bytes));
}

/// All that comes until the other side closes; "waits" behind it where it does not.
std::string heard(io::Port& port) {
  std::string text;
  std::array<std::uint8_t, 256> buffer{};
  while (true) {
    const auto size = port.read(buffer, 5s);
    if (!size) return text;
    if (*size == 0) return text + "waits";
    text.append(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size));
  }
}

TEST(SimwireGuests, second_host_gets_one_line_for_its_hello_and_is_closed) {
  const ScratchFolder folder;
  auto listener = io::LocalListener::create(folder.at("s"));
  ASSERT_TRUE(listener);
  const io::Clock clock;
  SimwireGuests guests(*listener, clock);
  EXPECT_EQ(guests.look(), 0U);
  auto first = io::connect_local(folder.at("s"));
  const auto served = listener->accept(1s);
  ASSERT_TRUE(first && served && *served);
  auto second = io::connect_local(folder.at("s"));
  ASSERT_TRUE(second);
  say(*second, "1 HELLO 1\n");
  EXPECT_EQ(guests.look(), 1U);
  EXPECT_EQ(heard(*second), kTurnedAway);
  EXPECT_EQ(guests.look(), 0U) << "it is counted once";
  auto third = io::connect_local(folder.at("s"));
  ASSERT_TRUE(third);
  say(*third, "1 HELLO 1\n2 STAT\n");
  EXPECT_EQ(guests.look(), 1U);
  EXPECT_EQ(heard(*third), kTurnedAway);
}

TEST(SimwireGuests, guest_that_says_nothing_is_told_too) {
  const ScratchFolder folder;
  auto listener = io::LocalListener::create(folder.at("s"));
  ASSERT_TRUE(listener);
  const io::Clock clock(100);
  SimwireGuests guests(*listener, clock);
  auto silent = io::connect_local(folder.at("s"));
  ASSERT_TRUE(silent);
  const Instant begin = clock.now();
  std::size_t turned_away = 0;
  while (turned_away == 0 && clock.now() - begin < 100s) turned_away = guests.look();
  EXPECT_EQ(turned_away, 1U);
  EXPECT_GT(clock.now() - begin, SimwireGuests::kPatience);
  EXPECT_EQ(heard(*silent), kTurnedAway);
}

struct Boards {
  Boards()
      : model(test::robot("robot-arm-2")),
        machine(*make_machine(model, {}, Instant{})),
        server(*machine.spi, boards_of(model.device), "boards") {}
  RobotModel model;
  RobotMachine machine;
  sim::SimwireServer server;
};

/// `sinew sim robot-arm-2 --simwire stdio >/dev/full` ended as if all was well.
TEST(ServeSimwire, reply_that_cannot_be_delivered_is_an_error_and_a_host_that_leaves_is_none) {
  io::hold_standard_streams();  // as main() does: nobody at the other end is an error, not the end
  const ScratchFolder folder;
  auto listener = io::LocalListener::create(folder.at("s"));
  ASSERT_TRUE(listener);
  ByteLog log;
  Boards boards;
  for (const bool speaks : {false, true}) {
    {
      auto host = io::connect_local(folder.at("s"));
      ASSERT_TRUE(host);
      if (speaks) say(*host, "1 HELLO 1\n");
    }
    auto served = listener->accept(1s);
    ASSERT_TRUE(served && *served);
    const auto end = serve_simwire(boards.server, **served, log, [] { return false; });
    EXPECT_EQ(end.has_value(), !speaks);
    if (end) continue;
    EXPECT_NE(end.error().sentence.find("closed the port"), std::string::npos);
  }
}

}  // namespace
}  // namespace sinew::runtime

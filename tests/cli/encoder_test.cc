#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>
#include <thread>

#include "cli/process.h"
#include "sinew/devices/encoder/encoder_machine.h"
#include "sinew/io/clock.h"
#include "sinew/io/port.h"

/// An encoder node on a port: `sinew sim encoder` behind `sinew doctor --encoder`.
namespace sinew::test {
namespace {

/// A simulated node; its port.
class Node {
 public:
  explicit Node(Arguments more = {}) : process_(words(std::move(more))) {
    process_.wait_for_out("\n");
    port = Json::parse(process_.out())["port"].get<std::string>();
    // It says no speed in the first 128 ms.
    process_.let_run(std::chrono::milliseconds(300));
  }

  /// Ends it. Its shaft as it really is, deg.
  double stop() {
    const std::size_t before = process_.out().size();
    process_.signal(SIGINT);
    const Ended ended = process_.end();
    EXPECT_EQ(ended.exit, 0) << ended.err;
    return Json::parse(ended.out.substr(before))["truth"]["joints"][0]["q_deg"].get<double>();
  }

  std::string port;

 private:
  static Arguments words(Arguments more) {
    Arguments all{"sim", "encoder", "--json"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Process process_;
};

TEST(EncoderNodeOnAPort, tells_angle_magnet_and_how_it_replied) {
  Node node({"--speed", "0"});
  const Json seen = answer({"doctor", "--encoder", node.port});
  EXPECT_EQ(seen["magnet"], "good");
  EXPECT_EQ(seen["lost_replies"], 0);
  EXPECT_EQ(seen["i2c_errors"], 0);
  EXPECT_GT(seen["requests"], 50);
  EXPECT_NEAR(seen["velocity_ticks_s"].get<double>(), 0, 60);
  const double angle = seen["angle_deg"].get<double>();
  EXPECT_NEAR(std::remainder(angle - node.stop(), 360), 0, 0.3);
}

TEST(EncoderNodeOnAPort, shows_which_direction_counts_up_while_the_shaft_turns) {
  for (const char* speed : {"90", "-90"}) {
    Node node({"--speed", speed});
    const Ended ended = sinew({"doctor", "--encoder", node.port, "--watch", "1.5"});
    EXPECT_EQ(ended.exit, 0) << ended.err;
    const bool up = speed[0] != '-';
    EXPECT_NE(ended.out.find(up ? "this direction counts up" : "this direction counts down"),
              std::string::npos)
        << ended.out;
  }
  Node still({"--speed", "0"});
  const Ended ended = sinew({"doctor", "--encoder", still.port, "--watch", "0.3"});
  EXPECT_NE(ended.out.find("the shaft was not turned"), std::string::npos) << ended.out;
}

TEST(EncoderNodeOnAPort, says_what_is_wrong_with_a_magnet) {
  Node node({"--fault", "magnet=J1:off@0s"});
  const Ended ended = sinew({"doctor", "--encoder", node.port});
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("sees no magnet"), std::string::npos) << ended.err;
}

TEST(EncoderNodeOnAPort, is_not_taken_for_a_robot_nor_a_robot_for_it) {
  Process arm({"sim", "maxarm", "--json"});
  arm.wait_for_out("\n");
  const auto port = Json::parse(arm.out())["port"].get<std::string>();
  const Ended ended = sinew({"doctor", "--encoder", port});
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("no encoder node replies at 115200 baud"), std::string::npos)
      << ended.err;
}

/// A line with something else on it than a plain node.
class OddLine {
 public:
  /// @param serve  what comes, to what goes, some thousand times a second
  using Serve = std::function<void(std::span<const std::uint8_t> bytes, io::Port& port)>;
  explicit OddLine(Serve serve)
      : port_(std::move(*io::Port::open_pseudo_terminal())),
        thread_([this, serve = std::move(serve)] {
          std::array<std::uint8_t, 64> bytes{};
          while (!ends_) {
            const auto count = port_.read(bytes, std::chrono::microseconds(200));
            serve(std::span(bytes).first(count.value_or(0)), port_);
          }
        }) {}
  ~OddLine() {
    ends_ = true;
    thread_.join();
  }
  OddLine(const OddLine&) = delete;
  OddLine& operator=(const OddLine&) = delete;
  const std::string& path() const { return port_.path(); }

 private:
  io::Port port_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

TEST(EncoderNodeOnAPort, an_adapter_that_receives_what_it_sends_is_no_trouble) {
  const io::Clock clock;
  const Instant begin = clock.now();
  sim::EncoderMachine machine(0, 3, Instant{});
  const OddLine line([&](std::span<const std::uint8_t> bytes, io::Port& port) {
    if (bytes.empty()) return;
    static_cast<void>(port.write(bytes));
    machine.receive(bytes, Instant{} + (clock.now() - begin));
    std::array<std::uint8_t, 32> reply{};
    const std::size_t size = machine.take_output(reply);
    static_cast<void>(port.write(std::span(reply).first(size)));
  });
  const Json seen = answer({"doctor", "--encoder", line.path()});
  EXPECT_EQ(seen["magnet"], "good");
  EXPECT_EQ(seen["lost_replies"], 0);
}

TEST(EncoderNodeOnAPort, a_line_that_is_never_quiet_is_given_up) {
  const OddLine line([](std::span<const std::uint8_t>, io::Port& port) {
    static_cast<void>(port.write_now(std::array<std::uint8_t, 2>{0x31, 0x32}));
  });
  const Ended ended = sinew({"doctor", "--encoder", line.path()});
  EXPECT_EQ(ended.exit, 1);
  // On a busy computer it may have its pauses.
  const bool said = ended.err.find("never quiet") != std::string::npos ||
                    ended.err.find("other bytes came") != std::string::npos;
  EXPECT_TRUE(said) << ended.err;
}

TEST(EncoderNodeOnAPort, says_no_direction_where_replies_were_lost) {
  const io::Clock clock;
  const Instant begin = clock.now();
  sim::EncoderMachine machine(from_deg(200), 3, Instant{});
  const OddLine line([&](std::span<const std::uint8_t> bytes, io::Port& port) {
    const Duration age = clock.now() - begin;
    machine.advance(Instant{} + age);
    // The cable is loose for a second.
    const bool loose =
        age > std::chrono::milliseconds(1500) && age < std::chrono::milliseconds(2500);
    if (bytes.empty() || loose) return;
    machine.receive(bytes, Instant{} + age);
    std::array<std::uint8_t, 32> reply{};
    const std::size_t size = machine.take_output(reply);
    static_cast<void>(port.write(std::span(reply).first(size)));
  });
  const Ended ended = sinew({"doctor", "--encoder", line.path(), "--watch", "3"});
  EXPECT_EQ(ended.exit, 1) << ended.out;
  EXPECT_NE(ended.err.find("direction is not known"), std::string::npos) << ended.err;
  EXPECT_EQ(ended.out.find("counts"), std::string::npos) << ended.out;
}

TEST(EncoderNodeOnAPort, refuses_what_makes_no_sense) {
  const auto refused = [](const Arguments& words, const std::string& why) {
    const Ended ended = sinew(words);
    EXPECT_EQ(ended.exit, 2) << ended.out;
    EXPECT_NE(ended.err.find(why), std::string::npos) << ended.err;
  };
  refused({"doctor", "--encoder", "/dev/null", "--robot", "learm"}, "a node by itself");
  refused({"doctor", "--encoder", "/dev/null", "--watch", "-1"}, "--watch: 0 to 600 s");
  refused({"doctor", "--encoder", "/dev/null", "--watch", "nan"}, "--watch");
  refused({"doctor", "--watch", "3"}, "--encoder PORT");
  refused({"doctor", "--encoder", "/dev/null", "--without", "J3"}, "a node by itself");
  refused({"firmware", "flash", "encoder-stm8s103", "--port", "/dev/null"}, "sinew cannot write");
  refused({"sim", "encoder", "--profile", "document"}, "an encoder node has none of them");
  refused({"sim", "encoder", "--speed", "1e9"}, "--speed: -2880 to 2880 deg/s");
  refused({"sim", "learm", "--speed", "3"}, "--speed");
  refused({"sim", "encoder", "--simwire", "stdio"}, "--simwire");
  const Ended gone = sinew({"doctor", "--encoder", "/dev/nothing"});
  EXPECT_EQ(gone.exit, 1);
}

}  // namespace
}  // namespace sinew::test

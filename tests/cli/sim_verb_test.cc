#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "cli/process.h"
#include "sinew/io/port.h"
#include "support/scratch_folder.h"

/// `sinew sim`: a device of its own behind a pseudo-terminal.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

std::string first_line(Process& process) {
  process.wait_for_out("\n");
  const std::string& out = process.out();
  return out.substr(0, out.find('\n'));
}

Bytes exchange(const std::string& path, const Bytes& request, std::size_t reply) {
  auto port = io::Port::open_serial(path, 250'000);
  if (!port) throw std::runtime_error(port.error().sentence);
  EXPECT_TRUE(port->write(request));
  Bytes bytes;
  std::array<std::uint8_t, 256> buffer{};
  while (bytes.size() < reply) {
    const auto size = port->read(buffer, 5s);
    if (!size || *size == 0) break;
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + static_cast<long>(*size));
  }
  return bytes;
}

const Bytes kBootStatus{0xca, 0x0d, 0x0a, 0,    0,    0,    0,   0,    0, 0, 0, 0,    0, 0, 0, 0,
                        0,    0,    0,    0,    0,    0,    0,   0xc8, 0, 0, 0, 0x64, 0, 0, 0, 0x64,
                        0,    0,    0,    0x64, 0,    0,    0,   0x64, 0, 0, 0, 0xc8, 0, 0, 0, 0x64,
                        0,    0,    0,    0x64, 0,    0,    0,   0x64, 0, 0, 0, 0x64, 0, 0, 0, 0x01,
                        0x5a, 0,    0x0d, 0x0a, 0xc8, 0x0d, 0x0a};

TEST(SimVerb, answers_the_documents_status_request_and_goto_example) {
  Process sim({"sim", "bigrobotarm", "--time-scale", "100"});
  const std::string port = first_line(sim);
  EXPECT_TRUE(port.starts_with("/dev/pts/")) << port;
  EXPECT_EQ(exchange(port, {0x08, 0x0d}, 71), kBootStatus);
  // goto -2400 600 -5000 800 -1000, as the document prints it.
  const Bytes words{0xa0, 0xf6, 0xff, 0xff, 0x58, 0x02, 0x00, 0x00, 0x78, 0xec,
                    0xff, 0xff, 0x20, 0x03, 0x00, 0x00, 0x18, 0xfc, 0xff, 0xff};
  Bytes request{0x01};
  request.insert(request.end(), words.begin(), words.end());
  request.push_back(0x0d);
  Bytes reply{0x01, 0x0d, 0x0a};
  reply.insert(reply.end(), words.begin(), words.end());
  reply.insert(reply.end(), {0x0d, 0x0a, 0xc8, 0x0d, 0x0a});
  EXPECT_EQ(exchange(port, request, 28), reply);
  sim.signal(SIGINT);
  const Ended ended = sim.end();
  EXPECT_EQ(ended.exit, 0);
  // -2400 steps of 72.2 a degree, and so on; the wrist 1000 steps of 33.3 the other way.
  EXPECT_NE(ended.out.find("believes -33.231"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("believes -30.000"), std::string::npos) << ended.out;
  EXPECT_NE(ended.err.find("Ctrl-C ends it"), std::string::npos);
}

TEST(SimVerb, every_ending_signal_is_an_orderly_end_that_removes_the_link) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const ScratchFolder folder;
    const std::string link = folder.at("arm");
    Process sim({"sim", "bigrobotarm", "--link", link});
    const std::string port = first_line(sim);
    EXPECT_EQ(std::filesystem::read_symlink(link), port);
    EXPECT_EQ(exchange(link, {0x08, 0x0d}, 71), kBootStatus);
    sim.signal(signal);
    EXPECT_EQ(sim.end().exit, 0);
    EXPECT_FALSE(std::filesystem::is_symlink(link));
  }
}

TEST(SimVerb, link_of_a_killed_simulation_is_taken_over) {
  const ScratchFolder folder;
  const std::string link = folder.at("arm");
  {
    Process killed({"sim", "bigrobotarm", "--link", link});
    first_line(killed);
    killed.signal(SIGKILL);
    EXPECT_EQ(killed.end().exit, -SIGKILL);
  }
  ASSERT_TRUE(std::filesystem::is_symlink(link));
  // The new port may or may not have the dead one's name: both must do.
  Process sim({"sim", "bigrobotarm", "--link", link});
  const std::string port = first_line(sim);
  EXPECT_EQ(std::filesystem::read_symlink(link), port);
}

TEST(SimVerb, link_in_use_is_refused_and_stays) {
  const ScratchFolder folder;
  const std::string link = folder.at("arm");
  Process first({"sim", "bigrobotarm", "--link", link});
  const std::string port = first_line(first);
  const Ended second = sinew({"sim", "bigrobotarm", "--link", link, "--json"});
  EXPECT_EQ(second.exit, 1);
  EXPECT_NE(second.json()["error"]["sentence"].get<std::string>().find("in use"),
            std::string::npos);
  EXPECT_EQ(std::filesystem::read_symlink(link), port);
}

/// What went one way, in whatever pieces it came.
std::string bytes_of(const std::string& log, const std::string& direction) {
  std::string bytes;
  for (std::size_t at = log.find(direction); at != std::string::npos;
       at = log.find(direction, at + 1)) {
    const std::size_t begin = at + direction.size();
    bytes += log.substr(begin, log.find("  ", begin) - begin) + " ";
  }
  return bytes;
}

TEST(SimVerb, log_holds_the_bytes_of_both_directions) {
  const ScratchFolder folder;
  Process sim({"sim", "bigrobotarm", "--log", folder.at("log")});
  exchange(first_line(sim), {0x08, 0x0d}, 71);
  sim.signal(SIGTERM);
  EXPECT_EQ(sim.end().exit, 0);
  const std::string log = text_of(folder.at("log"));
  EXPECT_EQ(bytes_of(log, "host -> device  "), "08 0d ") << log;
  EXPECT_TRUE(bytes_of(log, "device -> host  ").starts_with("ca 0d 0a 00 ")) << log;
}

TEST(SimVerb, log_on_a_full_disk_is_told_at_the_end) {
  Process sim({"sim", "bigrobotarm", "--log", "/dev/full"});
  exchange(first_line(sim), {0x08, 0x0d}, 71);
  sim.signal(SIGINT);
  const Ended ended = sim.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("--log: /dev/full: no space left on device"), std::string::npos);
}

TEST(SimVerb, json_is_a_document_a_line) {
  Process sim({"sim", "bigrobotarm", "--json"});
  const Json first = Json::parse(first_line(sim), nullptr, false);
  ASSERT_TRUE(first.is_object());
  EXPECT_TRUE(first["port"].get<std::string>().starts_with("/dev/pts/"));
  sim.signal(SIGINT);
  const Ended ended = sim.end();
  const std::string rest = ended.out.substr(ended.out.find('\n') + 1);
  EXPECT_EQ(rest.find('\n'), rest.size() - 1);
  const Json truth = Json::parse(rest, nullptr, false)["truth"];
  ASSERT_EQ(truth["joints"].size(), 5U);
  EXPECT_EQ(truth["joints"][0]["joint"], "base");
  EXPECT_EQ(truth["joints"][0]["believed_deg"], 0);
  // Up to two full steps of its motor beside it, where the power stage caught it.
  EXPECT_LE(std::abs(truth["joints"][1]["q_deg"].get<double>()), 0.2);
  EXPECT_EQ(truth["moving"], false);
  EXPECT_EQ(truth["bytes_lost"], 0);
}

TEST(SimVerb, garbage_and_rude_hosts_leave_it_working) {
  Process sim({"sim", "bigrobotarm", "--time-scale", "100"});
  const std::string path = first_line(sim);
  {
    auto port = io::Port::open_serial(path, 250'000);
    ASSERT_TRUE(port);
    Bytes noise(3000);
    std::uint32_t state = 1;
    for (auto& byte : noise) {
      state = state * 1664525 + 1013904223;
      // Not 01 and 02: a garbled goto may take the arm a century.
      byte = static_cast<std::uint8_t>(3 + (state >> 16) % 253);
    }
    ASSERT_TRUE(port->write(noise));
    for (int i = 0; i < 300; ++i) ASSERT_TRUE(port->write(Bytes{8, 13}));
    // What it answered until now is not read by anybody.
  }
  auto port = io::Port::open_serial(path, 250'000);
  ASSERT_TRUE(port);
  std::array<std::uint8_t, 4096> buffer{};
  // 20 bytes end whatever request is open, and another 0D the one that they may have begun.
  ASSERT_TRUE(port->write(Bytes(22, 0x0d)));
  while (*port->read(buffer, 100ms) > 0) {
  }
  ASSERT_TRUE(port->write(Bytes{8, 13}));
  Bytes status;
  while (status.size() < 71) {
    const std::size_t size = *port->read(buffer, 5s);
    ASSERT_GT(size, 0U);
    status.insert(status.end(), buffer.begin(), buffer.begin() + static_cast<long>(size));
  }
  EXPECT_EQ(status[0], 0xca);
  sim.signal(SIGINT);
  EXPECT_EQ(sim.end().exit, 0);
}

}  // namespace
}  // namespace sinew::test

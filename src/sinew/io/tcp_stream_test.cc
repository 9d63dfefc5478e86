#include "sinew/io/tcp_stream.h"

#include <gtest/gtest.h>

#include <vector>

#include "sinew/io/clock.h"
#include "support/tcp_server.h"

namespace sinew::io {
namespace {

using namespace std::chrono_literals;

std::string all_of(TcpStream& stream) {
  std::string text;
  std::vector<std::uint8_t> buffer(1000);
  while (const auto count = stream.read(buffer, 20ms)) {
    text.append(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*count));
  }
  return text;
}

TEST(TcpStream, bytes_go_there_and_back_and_the_other_sides_end_is_seen) {
  test::TcpTestServer server([](auto& client, int) { client.send("<" + client.request() + ">"); });
  auto stream = TcpStream::connect("127.0.0.1", server.port(), 5s, {});
  ASSERT_TRUE(stream) << stream.error().sentence;
  const std::string text = "hello\r\n\r\n";
  ASSERT_TRUE(stream->write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, 5s));
  EXPECT_EQ(all_of(*stream), "<hello\r\n\r\n>");
  std::vector<std::uint8_t> rest(10);
  const auto after = stream->read(rest, 1s);
  ASSERT_FALSE(after);
  EXPECT_NE(after.error().sentence.find("closed the connection"), std::string::npos);
}

TEST(TcpStream, silence_ends_with_its_time) {
  test::TcpTestServer server([](auto& client, int) {
    while (client.stays(20)) {
    }
  });
  auto stream = TcpStream::connect("localhost", server.port(), 5s, {});
  ASSERT_TRUE(stream) << stream.error().sentence;
  const Clock clock;
  std::vector<std::uint8_t> buffer(10);
  EXPECT_EQ(stream->read(buffer, 30ms), 0U);
  EXPECT_GE(clock.now() - Instant{}, 30ms);
}

TEST(TcpStream, no_server_there_is_said_in_a_sentence) {
  std::uint16_t port = 0;
  {
    const test::TcpTestServer server([](auto&, int) {});
    port = server.port();
  }
  const auto refused = TcpStream::connect("127.0.0.1", port, 5s, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().sentence,
            "127.0.0.1:" + std::to_string(port) +
                ": connection refused; start the camera's server there, and compare its port");
  const auto unknown = TcpStream::connect(std::string(300, 'a'), 80, 5s, {});
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().sentence.find("compare the camera's name or address"),
            std::string::npos);
}

}  // namespace
}  // namespace sinew::io

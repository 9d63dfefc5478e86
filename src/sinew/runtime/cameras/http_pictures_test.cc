#include "sinew/runtime/cameras/http_pictures.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <mutex>

#include "sinew/core/error_code.h"
#include "sinew/runtime/cameras/written_pictures.h"
#include "sinew/vision/picture_file.h"
#include "support/tcp_server.h"
#include "support/video_files.h"

/// Cameras in a thread behind a real socket of this computer.
namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using test::TcpTestServer;

constexpr std::string_view kStreamHead =
    "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n";

/// A picture with a number of its own.
std::string picture(int number) {
  return test::text_of(
      vision::encode_png(test::plain_picture(8, 8, static_cast<std::uint8_t>(number % 256), 0, 0)));
}

std::string part(const std::string& file) {
  return "--b\r\nContent-Type: image/png\r\nContent-Length: " + std::to_string(file.size()) +
         "\r\n\r\n" + file + "\r\n";
}

std::string single(const std::string& file) {
  return "HTTP/1.1 200 OK\r\nContent-Type: image/png\r\nContent-Length: " +
         std::to_string(file.size()) + "\r\n\r\n" + file;
}

/// A phone: a new picture every few milliseconds, to each client from where it is.
class Phone {
 public:
  explicit Phone(int pictures_each = 1'000'000)
      : server_([this, pictures_each](TcpTestServer::Client& client, int) {
          client.request();
          if (!client.send(kStreamHead)) return;
          for (int i = 0; i < pictures_each && client.stays(5); ++i) {
            const int number = ++number_ % 256;
            sent_[static_cast<std::size_t>(number)] = clock_.now();
            if (!client.send(part(picture(number)))) return;
          }
        }) {}

  TcpTestServer& server() { return server_; }
  Instant now() const { return clock_.now(); }
  /// When the picture of this number was sent last.
  Instant sent(int number) const { return sent_[static_cast<std::size_t>(number)]; }

 private:
  io::Clock clock_;
  int number_ = 0;
  std::array<std::atomic<Instant>, 256> sent_{};
  TcpTestServer server_;
};

CameraSource opened(const std::string& address, double scale = 1) {
  auto source = http_pictures(address, io::Clock(scale));
  EXPECT_TRUE(source) << source.error();
  return source ? std::move(*source) : CameraSource();
}

std::string fault_of(const std::string& reply) {
  TcpTestServer server([&](TcpTestServer::Client& client, int) {
    client.request();
    client.send(reply);
  });
  const auto source = http_pictures(server.address("/p", "user:secret@"));
  const std::string fault = source ? "fine" : source.error();
  EXPECT_EQ(fault.find("secret"), std::string::npos);
  const std::string shown = server.address("/p") + " ";
  return fault.starts_with(shown) ? fault.substr(shown.size()) : fault;
}

TEST(HttpPictures, of_a_stream_were_taken_after_they_were_asked_for) {
  Phone phone;
  const CameraSource source = opened(phone.server().address());
  const io::Clock clock;
  for (const Duration pause : {0ms, 500ms, 100ms}) {
    clock.pause(pause);  // old pictures wait in the buffers of both sides
    const Instant asked = phone.now();
    const auto seen = source({});
    ASSERT_TRUE(seen);
    EXPECT_GE(phone.sent(seen->rgb[0]), asked);
    EXPECT_GE(phone.now() - asked, kPictureDelay);
  }
  EXPECT_GE(phone.server().clients(), 2) << "anew where it was left alone for long";
}

TEST(HttpPictures, stream_that_breaks_is_connected_again) {
  Phone phone(3);
  const CameraSource source = opened(phone.server().address(), 10);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(source({}));
  EXPECT_GE(phone.server().clients(), 3);
}

TEST(HttpPictures, single_picture_is_requested_again_for_each_call) {
  std::atomic<int> number = 0;
  TcpTestServer server([&](TcpTestServer::Client& client, int) {
    client.request();
    client.send(single(picture(++number)));
  });
  const CameraSource source = opened(server.address("/shot.jpg"), 10);
  EXPECT_EQ(number, 1) << "the first shows that there are pictures";
  EXPECT_EQ(source({})->rgb[0], 2);
  EXPECT_EQ(source({})->rgb[0], 3);
}

TEST(HttpPictures, jpeg_without_huffman_tables_and_chunks_are_read) {
  TcpTestServer server([](TcpTestServer::Client& client, int) {
    client.request();
    client.send(
        "HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=\"--x\"\r\n"
        "Transfer-Encoding: chunked\r\n\r\n");
    const auto bare =
        test::without_huffman_tables(vision::encode_jpeg(test::plain_picture(16, 16, 90, 90, 90)));
    const std::string one =
        "--x\r\nContent-Type: image/jpeg\r\n\r\n" + test::text_of(bare) + "\r\n";
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string size;
    for (std::size_t left = one.size(); left > 0; left /= 16) size = kDigits[left % 16] + size;
    while (client.stays(5) && client.send(size + "\r\n" + one + "\r\n")) {
    }
  });
  const auto seen = opened(server.address(), 5)({});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->rgb[0], 90, 1);
}

TEST(HttpPictures, user_and_password_are_sent) {
  std::mutex mutex;
  std::string request;
  TcpTestServer server([&](TcpTestServer::Client& client, int) {
    const std::string text = client.request();
    {
      const std::scoped_lock lock(mutex);
      request = text;
    }
    client.send(single(picture(1)));
  });
  opened(server.address("/video?res=640x480", "user:pass@"));
  const std::scoped_lock lock(mutex);
  EXPECT_TRUE(request.starts_with("GET /video?res=640x480 HTTP/1.1\r\n")) << request;
  EXPECT_NE(request.find("\r\nAuthorization: Basic dXNlcjpwYXNz\r\n"), std::string::npos);
}

TEST(HttpPictures, camera_that_went_away_is_lost_and_found_again) {
  std::atomic<bool> is_away = false;
  TcpTestServer server([&](TcpTestServer::Client& client, int) {
    client.request();
    if (!is_away) client.send(single(picture(7)));
  });
  const CameraSource source = opened(server.address(), 20);
  EXPECT_TRUE(source({}));
  is_away = true;
  const auto lost = source({});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kCameraLost);
  EXPECT_EQ(lost.error().measured, 5);
  is_away = false;
  EXPECT_TRUE(source({}));
}

TEST(HttpPictures, silent_camera_is_lost_and_the_end_of_the_run_ends_a_wait) {
  TcpTestServer silent([](TcpTestServer::Client& client, int) {
    client.request();
    client.send(kStreamHead);
    while (client.stays(20)) {
    }
  });
  const CameraSource source = opened(silent.address(), 20);
  EXPECT_EQ(source({}).error().code, ErrorCode::kCameraLost);
  std::stop_source end;
  end.request_stop();
  EXPECT_FALSE(opened(silent.address())(end.get_token()));
}

TEST(HttpPictures, what_gives_no_pictures_is_refused_when_it_is_opened) {
  EXPECT_EQ(fault_of("HTTP/1.1 404 Not Found\r\n\r\n"),
            "replies 404 Not Found; the pictures of most camera apps are at /video, /videofeed or "
            "/stream");
  EXPECT_EQ(fault_of("HTTP/1.1 401 Unauthorized\r\n\r\n"),
            "replies 401 Unauthorized; write its user and password: "
            "http://USER:PASSWORD@HOST/PATH");
  EXPECT_EQ(fault_of("RFB 003.008\n"), "replies with something other than HTTP");
  EXPECT_NE(fault_of("").find("closed the connection"), std::string::npos);
  EXPECT_EQ(http_pictures("https://cam/").error(),
            "https://cam/: https is not read; switch it off in the camera's settings and write "
            "http://HOST:PORT/PATH");
  TcpTestServer gone([](TcpTestServer::Client&, int) {});
  const std::string address = gone.address();
  gone.end();
  EXPECT_NE(http_pictures(address).error().find("connection refused"), std::string::npos);
}

TEST(HttpPictures, server_that_never_replies_is_refused) {
  TcpTestServer server([](TcpTestServer::Client& client, int) {
    while (client.stays(20)) {
    }
  });
  const auto source = http_pictures(server.address(), io::Clock(20));
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error(),
            server.address() + ": no reply within 5 s; restart the camera's server");
}

}  // namespace
}  // namespace sinew::runtime

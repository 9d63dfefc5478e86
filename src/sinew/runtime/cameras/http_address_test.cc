#include "sinew/runtime/cameras/http_address.h"

#include <gtest/gtest.h>

namespace sinew::runtime {
namespace {

std::string fault_of(const std::string& text) {
  const auto address = read_http_address(text);
  return address ? "fine" : address.error();
}

TEST(HttpAddress, host_port_path_and_query_are_read) {
  const auto plain = read_http_address("http://192.168.1.20:8080/video?a=b@c#top");
  ASSERT_TRUE(plain) << plain.error();
  EXPECT_EQ(plain->host, "192.168.1.20");
  EXPECT_EQ(plain->port, 8080);
  EXPECT_EQ(plain->target, "/video?a=b@c");
  EXPECT_EQ(plain->authorization, "");
  EXPECT_EQ(read_http_address("http://phone")->target, "/");
  EXPECT_EQ(read_http_address("http://phone?x")->target, "/?x");
  EXPECT_EQ(read_http_address("http://phone/")->port, 80);
  const auto six = read_http_address("http://[fe80::1]:81/a");
  EXPECT_EQ(six->host, "fe80::1");
  EXPECT_EQ(six->port, 81);
  EXPECT_EQ(six->shown(), "http://[fe80::1]:81/a");
}

TEST(HttpAddress, user_and_password_become_basic_authorization_and_are_not_shown) {
  const auto address = read_http_address("http://Aladdin:open%20sesame@cam:81/a");
  ASSERT_TRUE(address) << address.error();
  EXPECT_EQ(address->authorization, "Basic QWxhZGRpbjpvcGVuIHNlc2FtZQ==");  // RFC 7617, 2
  EXPECT_EQ(address->shown(), "http://cam:81/a");
  EXPECT_EQ(read_http_address("http://a:p%40ss@cam")->host, "cam");
  EXPECT_EQ(read_http_address("http://user@cam")->authorization, "Basic dXNlcjo=");
}

TEST(HttpAddress, request_names_the_host_and_ends_with_the_connection) {
  EXPECT_EQ(read_http_address("http://u:p@cam:81/a?b")->request(),
            "GET /a?b HTTP/1.1\r\nHost: cam:81\r\nUser-Agent: sinew\r\n"
            "Accept: multipart/x-mixed-replace, image/jpeg, */*\r\n"
            "Authorization: Basic dTpw\r\nConnection: close\r\n\r\n");
  EXPECT_NE(read_http_address("http://[::1]/")->request().find("Host: [::1]\r\n"),
            std::string::npos);
}

TEST(HttpAddress, what_is_no_address_is_said) {
  EXPECT_EQ(fault_of("https://cam/a"),
            "https is not read; switch it off in the camera's settings and write "
            "http://HOST:PORT/PATH");
  EXPECT_EQ(fault_of("http:///a"), "an address without a host; write http://HOST:PORT/PATH");
  EXPECT_EQ(fault_of("http://u:p@/a"), "an address without a host; write http://HOST:PORT/PATH");
  for (const char* text : {"http://cam:0/", "http://cam:65536/", "http://cam:/", "http://cam:8x"}) {
    EXPECT_EQ(fault_of(text),
              "a port that is no number from 1 to 65535; write http://HOST:PORT/PATH");
  }
  for (const char* text : {"rtsp://cam/", "", "http://cam/a b", "http://cam/\r\nX: y",
                           "http://[::1/", "http://c\xC3\xA4m/"}) {
    EXPECT_NE(fault_of(text), "fine") << text;
  }
}

}  // namespace
}  // namespace sinew::runtime

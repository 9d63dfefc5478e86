#include "sinew/vision/http_reply.h"

#include <gtest/gtest.h>

#include "support/property.h"
#include "support/video_files.h"

namespace sinew::vision {
namespace {

using test::bytes_of;

/// A body, fed in pieces of this size; in brackets what is wrong with it.
std::string body_of(const std::string& fields, const std::string& sent, std::size_t piece) {
  auto body = HttpBody::of(HttpFields::of(fields));
  if (!body) return "(" + body.error() + ")";
  std::vector<std::uint8_t> out;
  for (std::size_t at = 0; at < sent.size(); at += piece) {
    if (auto fed = body->feed(bytes_of(sent.substr(at, piece)), out); !fed) {
      return "(" + fed.error() + ")";
    }
  }
  return test::text_of(out) + (body->is_whole() ? "." : "");
}

TEST(HttpReply, head_is_read_with_its_status_and_fields) {
  const auto head = read_reply_head(
      "HTTP/1.1 404 Not Found\r\nContent-Type:text/html \r\nnonsense\r\nX-A: 1\r\n\r\n");
  ASSERT_TRUE(head) << head.error();
  EXPECT_EQ(head->status, 404);
  EXPECT_EQ(head->reason, "Not Found");
  EXPECT_EQ(head->fields.value("content-type"), "text/html");
  EXPECT_EQ(head->fields.value("x-a"), "1");
  EXPECT_EQ(head->fields.value("none"), "");
  EXPECT_EQ(read_reply_head("HTTP/1.0 200\n\n")->status, 200);
}

TEST(HttpReply, other_protocols_are_refused) {
  for (const char* text : {"", "ICY 200 OK\r\n\r\n", "HTTP/2 200\r\n\r\n", "HTTP/1.1\r\n\r\n",
                           "HTTP/1.1 2x0 OK\r\n\r\n", "HTTP/1.1 99 \r\n\r\n", "HTTP/1.1 20\r\n"}) {
    EXPECT_FALSE(read_reply_head(text)) << text;
  }
}

TEST(HttpReply, end_of_a_head_is_an_empty_line_with_or_without_carriage_returns) {
  EXPECT_EQ(head_bytes(bytes_of("a\r\nb\r\n\r\nbody")), 8U);
  EXPECT_EQ(head_bytes(bytes_of("a\nb\n\nbody")), 5U);
  EXPECT_EQ(head_bytes(bytes_of("a\r\nb\r\n\r")), 0U);
  EXPECT_EQ(head_bytes({}), 0U);
}

TEST(HttpReply, parameters_are_found_quoted_or_not) {
  const auto boundary = [](std::string_view value) { return field_parameter(value, "boundary"); };
  EXPECT_EQ(boundary("multipart/x-mixed-replace;boundary=abc"), "abc");
  EXPECT_EQ(boundary("multipart/x-mixed-replace; Boundary = abc ; x=y"), "abc");
  EXPECT_EQ(boundary("multipart/x-mixed-replace; boundary=\"a;b \\\"c\""), "a;b \"c");
  EXPECT_EQ(boundary("multipart/x; a=\"; boundary=no\"; boundary=yes"), "yes");
  EXPECT_EQ(boundary("multipart/x-mixed-replace; boundary="), "");
  EXPECT_EQ(boundary("multipart/x-mixed-replace"), "");
  EXPECT_EQ(boundary("x; boundary=\"open"), "open");
}

TEST(HttpReply, body_of_every_coding_is_read_in_pieces_of_every_size) {
  for (std::size_t piece = 1; piece < 12; ++piece) {
    EXPECT_EQ(body_of("Content-Length: 5\r\n", "helloEXTRA", piece), "hello.");
    EXPECT_EQ(body_of("", "hello", piece), "hello") << "only the connection's end ends it";
    EXPECT_EQ(body_of("Transfer-Encoding: chunked\r\nContent-Length: 1\r\n",
                      "3\r\nhel\r\n02;x=y\r\nlo\r\n0\r\nTrailer: 1\r\n\r\nEXTRA", piece),
              "hello.");
    EXPECT_EQ(body_of("Transfer-Encoding: chunked\n", "A\n0123456789\n0\n\n", piece),
              "0123456789.");
  }
}

TEST(HttpReply, broken_chunks_and_lengths_are_said) {
  EXPECT_EQ(body_of("Transfer-Encoding: chunked\n", "x\r\n", 1), "(sends chunks without a size)");
  EXPECT_EQ(body_of("Transfer-Encoding: chunked\n", "FFFFFFFFFFFFFFFFF\r\n", 1),
            "(sends chunks without a size)");
  EXPECT_EQ(body_of("Transfer-Encoding: chunked\n", "1\r\nabc\r\n", 2),
            "(sends chunks that are longer than they say)");
  EXPECT_EQ(body_of("Transfer-Encoding: chunked\n", std::string(2000, '1'), 100),
            "(sends chunks without a size)");
  EXPECT_EQ(body_of("Transfer-Encoding: gzip\n", "", 1),
            "(sends its pictures with the transfer encoding 'gzip'; only chunked is read)");
  EXPECT_EQ(body_of("Content-Length: -1\n", "", 1), "(replies with a length that is no number)");
}

TEST(HttpReply, a_million_spoiled_bytes_in_chunks_never_make_more_than_was_sent) {
  const std::string sent = "3\r\nhel\r\n2\r\nlo\r\n10\r\n0123456789abcdef\r\n0\r\n\r\n";
  const auto fields = HttpFields::of("Transfer-Encoding: chunked\n");
  test::for_random_cases(200'000, [&](test::Random& random) {
    std::string spoiled = sent;
    for (std::int64_t i = random.integer(1, 9); i > 0; --i) {
      spoiled[random.bits() % spoiled.size()] = random.chance(0.5)
                                                    ? "0123456789\r\n"[random.bits() % 12]
                                                    : static_cast<char>(random.bits());
    }
    auto body = HttpBody::of(fields);
    std::vector<std::uint8_t> out;
    const auto fed = body->feed(bytes_of(spoiled), out);
    ASSERT_LE(out.size(), spoiled.size());
    ASSERT_TRUE(fed || !fed.error().empty());
  });
}

}  // namespace
}  // namespace sinew::vision

#include "sinew/vision/picture_stream.h"

#include <gtest/gtest.h>

#include "support/property.h"
#include "support/video_files.h"

namespace sinew::vision {
namespace {

using Texts = std::vector<std::string>;

/// Pictures as text, the reply fed in pieces of this size; in brackets what is wrong.
Texts pictures_of(const std::string& reply, std::size_t piece = 1000) {
  PictureStream stream;
  Texts all;
  const auto add = [&](const std::vector<StreamedPicture>& pictures) {
    for (const StreamedPicture& picture : pictures) all.push_back(test::text_of(picture.file));
  };
  for (std::size_t at = 0; at < reply.size(); at += piece) {
    const auto come = stream.feed(test::bytes_of(reply.substr(at, piece)), Instant{});
    if (!come) {
      all.push_back("(" + come.error() + ")");
      return all;
    }
    add(*come);
  }
  add(stream.end());
  return all;
}

const std::string kStreamHead =
    "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=\"b\"\r\n";
const std::string kParts =
    "--b\r\nContent-Type: image/jpeg\r\nContent-Length: "
    "3\r\n\r\none\r\n--b\r\n\r\ntwo\r\n--b--\r\n";

std::string chunked(const std::string& text, std::size_t size) {
  std::string chunks;
  for (std::size_t at = 0; at < text.size(); at += size) {
    const std::string data = text.substr(at, size);
    chunks += std::string(1, "0123456789abcdef"[data.size()]) + "\r\n" + data + "\r\n";
  }
  return chunks + "0\r\n\r\n";
}

TEST(PictureStream, streams_come_plain_and_in_chunks_in_pieces_of_every_size) {
  for (std::size_t piece = 1; piece < 60; ++piece) {
    EXPECT_EQ(pictures_of(kStreamHead + "\r\n" + kParts, piece), (Texts{"one", "two"}));
    for (const std::size_t size : {1U, 7U, 15U}) {
      EXPECT_EQ(
          pictures_of(kStreamHead + "Transfer-Encoding: chunked\r\n\r\n" + chunked(kParts, size),
                      piece),
          (Texts{"one", "two"}));
    }
  }
}

TEST(PictureStream, one_picture_ends_with_its_length_or_with_the_connection) {
  EXPECT_EQ(pictures_of("HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: 3\r\n\r\n"
                        "one"),
            Texts{"one"});
  EXPECT_EQ(pictures_of("HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\n\r\none", 4), Texts{"one"});
  PictureStream stream;
  EXPECT_FALSE(stream.has_begun());
  ASSERT_TRUE(stream.feed(test::bytes_of("HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\n"), {}));
  EXPECT_TRUE(stream.is_single());
  EXPECT_FALSE(stream.is_over());
  EXPECT_EQ(stream.feed(test::bytes_of("one"), {})->size(), 1U);
  EXPECT_TRUE(stream.is_over());
  EXPECT_TRUE(stream.end().empty()) << "told once";
}

TEST(PictureStream, provisional_replies_are_passed_over) {
  EXPECT_EQ(pictures_of("HTTP/1.1 100 Continue\r\n\r\n" + kStreamHead + "\r\n" + kParts, 5),
            (Texts{"one", "two"}));
}

TEST(PictureStream, replies_without_pictures_say_what_to_do) {
  const auto fault = [](const std::string& head) { return pictures_of(head + "\r\n\r\n")[0]; };
  EXPECT_EQ(fault("HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Basic realm=\"cam\""),
            "(replies 401 Unauthorized; write its user and password: "
            "http://USER:PASSWORD@HOST/PATH)");
  EXPECT_EQ(fault("HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Digest realm=\"cam\""),
            "(replies 401 Unauthorized; it asks for digest authentication. Choose basic "
            "authentication, or none, in the camera's settings)");
  EXPECT_EQ(fault("HTTP/1.1 302 Found\r\nLocation: http://phone/video"),
            "(replies 302 Found; give its other address: http://phone/video)");
  EXPECT_EQ(fault("HTTP/1.1 404 Not Found"),
            "(replies 404 Not Found; the pictures of most camera apps are at /video, /videofeed "
            "or /stream)");
  EXPECT_EQ(fault("HTTP/1.1 503 Busy\x1B[31m"), "(replies 503 Busy?[31m)");
  EXPECT_EQ(fault("HTTP/1.1 200 OK\r\nContent-Type: text/html"),
            "(replies with 'text/html', which is no picture; the pictures of most camera apps are "
            "at /video, /videofeed or /stream)");
  EXPECT_EQ(fault("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace"),
            "(sends a multipart stream without a usable boundary)");
  EXPECT_EQ(fault("SSH-2.0-OpenSSH"), "(replies with something other than HTTP)");
  EXPECT_EQ(pictures_of("HTTP/1.1 200 OK\r\n" + std::string(20'000, 'x')),
            Texts{"(replies with an endless head)"});
  EXPECT_EQ(pictures_of("HTTP/1.1 200 OK\r\n\r\n" + std::string(kStreamedPictureMax + 1, 'x'),
                        std::size_t{1} << 20U),
            Texts{"(sends a picture of over 16 MB)"});
}

TEST(PictureStream, a_million_spoiled_bytes_never_make_more_than_was_sent) {
  const std::string sent = kStreamHead + "Transfer-Encoding: chunked\r\n\r\n" + chunked(kParts, 15);
  test::for_random_cases(50'000, [&](test::Random& random) {
    std::string spoiled = sent;
    const std::size_t from = random.chance(0.8) ? kStreamHead.size() + 30 : 0;
    for (std::int64_t i = random.integer(1, 39); i > 0; --i) {
      spoiled[from + random.bits() % (spoiled.size() - from)] =
          random.chance(0.7) ? "-b0123456789\r\n: "[random.bits() % 16]
                             : static_cast<char>(random.bits());
    }
    std::size_t bytes = 0;
    for (const std::string& one : pictures_of(spoiled, 1 + random.bits() % 200)) {
      bytes += one.size();
    }
    ASSERT_LE(bytes, 2 * spoiled.size() + 200);  // and a sentence
  });
}

}  // namespace
}  // namespace sinew::vision

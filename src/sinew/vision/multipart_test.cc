#include "sinew/vision/multipart.h"

#include <gtest/gtest.h>

#include "sinew/vision/http_reply.h"
#include "support/property.h"
#include "support/video_files.h"

namespace sinew::vision {
namespace {

using namespace std::chrono_literals;
using Texts = std::vector<std::string>;

/// Parts as text, fed in pieces of this size; in brackets what is wrong.
Texts parts_of(const std::string& boundary, const std::string& sent, std::size_t piece = 1000) {
  auto parts = Multipart::with_boundary(boundary);
  if (!parts) return {"(" + parts.error() + ")"};
  Texts all;
  for (std::size_t at = 0; at < sent.size(); at += piece) {
    auto come = parts->feed(test::bytes_of(sent.substr(at, piece)), Instant{});
    if (!come) {
      all.push_back("(" + come.error() + ")");
      return all;
    }
    for (const StreamedPicture& part : *come) all.push_back(test::text_of(part.file));
  }
  if (const auto last = parts->end()) all.push_back(test::text_of(last->file));
  return all;
}

std::string part(const std::string& boundary, const std::string& file, bool has_length) {
  return "--" + boundary + "\r\nContent-Type: image/jpeg\r\n" +
         (has_length ? "Content-Length: " + std::to_string(file.size()) + "\r\n" : "") + "\r\n" +
         file + "\r\n";
}

TEST(Multipart, parts_with_and_without_a_length_come_in_pieces_of_every_size) {
  for (const bool has_length : {true, false}) {
    const std::string sent = "preamble\r\n" + part("b0", "one", has_length) +
                             part("b0", "t\r\nw-o", has_length) +
                             part("b0", "\r\n--b0x\r\n", has_length) + "--b0--\r\nepilogue";
    for (std::size_t piece = 1; piece < 40; ++piece) {
      EXPECT_EQ(parts_of("b0", sent, piece), (Texts{"one", "t\r\nw-o", "\r\n--b0x\r\n"}))
          << piece << has_length;
    }
  }
}

TEST(Multipart, boundary_may_be_given_with_its_dashes) {
  for (const char* boundary : {"dcmjpeg", "--dcmjpeg"}) {
    EXPECT_EQ(parts_of(boundary, part("dcmjpeg", "one", true) + part("dcmjpeg", "two", false) +
                                     "--dcmjpeg--"),
              (Texts{"one", "two"}));
  }
  EXPECT_EQ(parts_of("--b", part("--b", "one", false) + part("--b", "two", true)),
            (Texts{"one", "two"}))
      << "and is put behind two more, as the standard says";
}

TEST(Multipart, line_feeds_alone_will_do) {
  EXPECT_EQ(parts_of("b", "--b\nContent-Type: image/jpeg\n\none\n--b\n\ntwo\n--b\n"),
            (Texts{"one", "two"}));
}

TEST(Multipart, last_part_may_end_with_the_connection) {
  EXPECT_EQ(parts_of("b", part("b", "one", true) + "--b\r\n\r\ntwo"), (Texts{"one", "two"}));
  EXPECT_EQ(parts_of("b", "--b\r\nContent-Length: 9\r\n\r\ntwo"), Texts{}) << "cut short";
}

TEST(Multipart, length_that_is_wrong_spoils_its_own_part_only) {
  const std::string longer = "--b\r\nContent-Length: 12\r\n\r\none\r\n";
  const std::string shorter = "--b\r\nContent-Length: 2\r\n\r\none\r\n";
  const std::string none = "--b\r\nContent-Length: many\r\n\r\none\r\n";
  const std::string good = part("b", "good", true);
  EXPECT_EQ(parts_of("b", shorter + good), (Texts{"on", "good"}));
  EXPECT_EQ(parts_of("b", none + good), (Texts{"one", "good"}));
  EXPECT_EQ(parts_of("b", longer + good + good).back(), "good");
}

TEST(Multipart, first_byte_of_a_part_says_when_it_began) {
  auto parts = *Multipart::with_boundary("b");
  const auto feed = [&](const char* text, Duration at) {
    return *parts.feed(test::bytes_of(text), Instant{} + at);
  };
  feed("--b\r\n\r", 1s);
  feed("\n", 2s);
  feed("o", 3s);
  feed("ne\r\n", 4s);
  auto first = feed("--b\r\n\r\ntw", 5s);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].begun, Instant{} + 3s);
  auto second = feed("o\r\n--b\r\n", 6s);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].begun, Instant{} + 5s);
}

TEST(Multipart, what_never_ends_is_given_up_within_bounds) {
  EXPECT_EQ(parts_of("b", "--b\r\nContent-Length: 99999999999\r\n\r\n"),
            Texts{"(sends a picture of 99999999999 bytes; at most 16 MB are read)"});
  EXPECT_EQ(parts_of("b", "--b\r\n" + std::string(20'000, 'x')),
            Texts{"(sends a part with a head of over 16 kB)"});
  EXPECT_EQ(parts_of("b", "--b\r\n\r\n" + std::string(kStreamedPictureMax + 10, 'x'), 1U << 20U),
            Texts{"(sends a picture of over 16 MB)"});
  EXPECT_EQ(parts_of("b", std::string(1U << 20U, '-')), Texts{}) << "no boundary at all";
  EXPECT_EQ(parts_of("----", ""), Texts{"(sends a multipart stream without a usable boundary)"});
  EXPECT_EQ(parts_of("", ""), Texts{"(sends a multipart stream without a usable boundary)"});
}

TEST(Multipart, a_million_spoiled_bytes_never_make_more_than_was_sent) {
  const std::string sent =
      part("b0", "one", true) + part("b0", "two", false) + part("b0", "three", true) + "--b0--";
  test::for_random_cases(100'000, [&](test::Random& random) {
    std::string spoiled = sent;
    for (std::int64_t i = random.integer(1, 19); i > 0; --i) {
      spoiled[random.bits() % spoiled.size()] =
          random.chance(0.5) ? "-b0\r\n: 9"[random.bits() % 8] : static_cast<char>(random.bits());
    }
    std::size_t bytes = 0;
    for (const std::string& one : parts_of("b0", spoiled, 1 + random.bits() % 200)) {
      bytes += one.size();
    }
    ASSERT_LE(bytes, spoiled.size() + 100);  // and a sentence
  });
}

}  // namespace
}  // namespace sinew::vision

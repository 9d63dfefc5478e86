#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sinew/runtime/records/mcap_reader.h"
#include "sinew/runtime/records/mcap_record.h"
#include "support/property.h"

/// Files of the writer, read back, cut, damaged, and made up.
namespace sinew::runtime {
namespace {

using test::for_random_cases;
using test::Random;
using Bytes = std::vector<std::uint8_t>;

struct Written {
  std::uint16_t channel = 0;
  std::uint64_t time = 0;
  std::string data;
};

struct Example {
  Bytes file;
  std::vector<Written> messages;
  std::size_t channels = 0;
};

std::string random_text(Random& random, std::int64_t size_max) {
  std::string text;
  const auto size = random.integer(0, size_max);
  for (std::int64_t k = 0; k < size; ++k) {
    text += static_cast<char>(random.integer(-128, 127));
  }
  return text;
}

Example make_example(Random& random, std::int64_t messages_max, std::int64_t size_max) {
  Example example;
  McapWriter writer(
      [&](std::span<const std::uint8_t> bytes) {
        example.file.insert(example.file.end(), bytes.begin(), bytes.end());
      },
      "test");
  const auto channels = random.integer(1, 5);
  for (std::int64_t k = 0; k < channels; ++k) {
    const std::uint16_t schema =
        random.chance(0.2)
            ? std::uint16_t{0}
            : writer.add_schema("s" + std::to_string(k), "jsonschema", random_text(random, 40));
    writer.add_channel(schema, "/c" + std::to_string(k), "json",
                       {{"a", random_text(random, 5)}, {"b", ""}});
  }
  example.channels = static_cast<std::size_t>(channels);
  std::uint64_t time = 1'700'000'000'000'000'000;
  const auto count = random.integer(0, messages_max);
  for (std::int64_t k = 0; k < count; ++k) {
    time += static_cast<std::uint64_t>(random.integer(0, 400'000'000));
    const auto channel = static_cast<std::uint16_t>(random.integer(0, channels - 1));
    example.messages.push_back({channel, time, random_text(random, size_max)});
    EXPECT_TRUE(writer.add_message(channel, time, example.messages.back().data));
    if (random.chance(0.05)) writer.end_chunk();
  }
  if (random.chance(0.5)) writer.add_metadata("run", {{"robot", "x"}});
  writer.finish();
  return example;
}

void expect_same(const McapMessage& read, const Written& written) {
  EXPECT_EQ(read.channel, written.channel);
  EXPECT_EQ(read.time, written.time);
  EXPECT_EQ(read.data, written.data);
}

TEST(Mcap, checksum_is_that_of_ethernet_and_may_be_taken_in_pieces) {
  const std::string digits = "123456789";
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size());
  EXPECT_EQ(mcap::crc32(bytes), 0xCBF43926U);
  EXPECT_EQ(mcap::crc32(bytes.subspan(4), mcap::crc32(bytes.first(4))), 0xCBF43926U);
}

TEST(Mcap, what_was_written_is_read_back) {
  for_random_cases(300, [](Random& random) {
    const Example example = make_example(random, 60, 50);
    const McapContent content = read_mcap(example.file);
    ASSERT_FALSE(content.trouble) << content.trouble->sentence;
    EXPECT_EQ(content.library, "test");
    EXPECT_EQ(content.channels.size(), example.channels);
    ASSERT_EQ(content.messages.size(), example.messages.size());
    std::vector<std::uint32_t> next(example.channels);
    for (std::size_t k = 0; k < example.messages.size(); ++k) {
      expect_same(content.messages[k], example.messages[k]);
      EXPECT_EQ(content.messages[k].sequence, next[content.messages[k].channel]++);
    }
  });
}

TEST(Mcap, chunks_end_by_size_so_that_memory_stays_bounded) {
  std::size_t largest = 0;
  McapWriter writer(
      [&](std::span<const std::uint8_t> bytes) { largest = std::max(largest, bytes.size()); },
      "test");
  const std::uint16_t channel = writer.add_channel(0, "/c", "json");
  const std::string data(1000, 'x');
  for (int k = 0; k < 5000; ++k) ASSERT_TRUE(writer.add_message(channel, 1, data));
  EXPECT_GT(largest, McapWriter::kChunkBytes / 2);
  EXPECT_LT(largest, McapWriter::kChunkBytes + 2000);
}

/// Every message in front of the cut is there, and none that is not; also inside of a chunk.
TEST(Mcap, file_that_is_cut_anywhere_is_read_up_to_the_cut) {
  for_random_cases(6, [](Random& random) {
    const Example example = make_example(random, 25, 20);
    std::size_t before = 0;
    for (std::size_t size = 0; size < example.file.size(); ++size) {
      const Bytes part(example.file.begin(),
                       example.file.begin() + static_cast<std::ptrdiff_t>(size));
      const McapContent content = read_mcap(part);
      ASSERT_TRUE(content.trouble) << size;
      ASSERT_TRUE(content.trouble->cut) << size << ": " << content.trouble->sentence;
      ASSERT_LE(content.messages.size(), example.messages.size());
      ASSERT_GE(content.messages.size(), before);
      before = content.messages.size();
      for (std::size_t k = 0; k < content.messages.size(); ++k) {
        expect_same(content.messages[k], example.messages[k]);
      }
    }
    EXPECT_EQ(before, example.messages.size());
  });
}

TEST(Mcap, every_bit_that_turns_is_found) {
  for_random_cases(4, [](Random& random) {
    const Example example = make_example(random, 12, 12);
    for (std::size_t bit = 0; bit < 8 * example.file.size(); ++bit) {
      Bytes damaged = example.file;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      ASSERT_TRUE(read_mcap(damaged).trouble) << "bit " << bit;
    }
  });
}

/// Whatever it is, the reader says what is wrong or that all is well, and reads nothing outside.
TEST(Mcap, hostile_bytes_end_in_a_sentence) {
  for_random_cases(3000, [](Random& random) {
    Example example = make_example(random, 10, 20);
    Bytes& file = example.file;
    const auto changes = random.integer(1, 12);
    for (std::int64_t k = 0; k < changes && !file.empty(); ++k) {
      const auto at = random.integer(0, static_cast<std::int64_t>(file.size()) - 1);
      if (random.chance(0.2)) {
        file.erase(file.begin() + at);
      } else if (random.chance(0.2)) {
        file.insert(file.begin() + at, static_cast<std::uint8_t>(random.integer(0, 255)));
      } else {
        file[static_cast<std::size_t>(at)] =
            random.chance(0.5) ? 0xFF : static_cast<std::uint8_t>(random.integer(0, 255));
      }
    }
    const McapContent content = read_mcap(file);
    if (content.trouble) {
      EXPECT_FALSE(content.trouble->sentence.empty());
      EXPECT_LE(content.trouble->offset, file.size());
    }
    for (const McapMessage& message : content.messages) {
      EXPECT_TRUE(content.channels.contains(message.channel));
      const auto* data = reinterpret_cast<const std::uint8_t*>(message.data.data());
      EXPECT_TRUE(data >= file.data() && data + message.data.size() <= file.data() + file.size());
    }
  });
}

}  // namespace
}  // namespace sinew::runtime

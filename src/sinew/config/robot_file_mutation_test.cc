// Every built-in file, spoiled in every place: the reader never crashes, and what changes the
// meaning is refused on the line where it was changed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"
#include "support/property.h"
#include "support/robot_promises.h"

namespace sinew {
namespace {

using test::broken_promise;
using test::Random;

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string trimmed(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(' ');
  return begin == std::string::npos ? "" : line.substr(begin);
}

bool is_blank(const std::string& line) {
  return trimmed(line).empty() || trimmed(line)[0] == '#';
}
bool is_header(const std::string& line) {
  return trimmed(line).starts_with('[');
}
bool is_source(const std::string& line) {
  return trimmed(line).starts_with("source");
}
bool is_number_line(const std::string& line) {
  if (is_blank(line) || is_header(line) || is_source(line)) return false;
  return line[line.find("= ") + 2] != '"';
}

/// A number of a line: first byte and length.
struct Token {
  std::size_t begin = 0;
  std::size_t size = 0;
};

std::vector<Token> numbers_of(const std::string& line) {
  std::vector<Token> tokens;
  std::size_t at = line.find("= ") + 2;
  const std::size_t end = std::min(line.find('#'), line.size());
  while (at < end) {
    const std::size_t begin = line.find_first_of("-0123456789", at);
    if (begin >= end) break;
    const std::size_t after = std::min(line.find_first_not_of("-.0123456789", begin), end);
    tokens.push_back({begin, after - begin});
    at = after;
  }
  return tokens;
}

bool complains_at(const std::vector<Complaint>& complaints, std::size_t line, std::size_t column) {
  return std::ranges::any_of(complaints, [&](const Complaint& complaint) {
    return complaint.line == static_cast<int>(line) &&
           (column == 0 || complaint.column == static_cast<int>(column));
  });
}

/// @param column  0: any
void expect_refused_at(const std::vector<std::string>& lines, std::size_t line,
                       std::size_t column) {
  const auto model = read_robot(joined(lines), "r");
  ASSERT_FALSE(model.has_value()) << lines[line - 1];
  std::string all;
  for (const Complaint& complaint : model.error()) all += to_text(complaint) + "\n";
  EXPECT_TRUE(complains_at(model.error(), line, column))
      << lines[line - 1] << "\nwas changed at " << line << ":" << column << "\n"
      << all;
}

/// Reading takes ten times as long with sanitizers, which look for other faults than these tests:
/// there one change of so many is tried.
#ifdef __SANITIZE_ADDRESS__
constexpr std::size_t kOneOf = 8;
#else
constexpr std::size_t kOneOf = 1;
#endif

/// Calls `body(lines, i)` for every line i of every built-in file that is `wanted`, of which there
/// must be more than `least`, so that no sweep passes because it found nothing to do.
template <class Wanted, class Body>
void for_lines(int least, Wanted wanted, Body body) {
  int found = 0;
  for (const BuiltinRobot& builtin : builtin_robots()) {
    SCOPED_TRACE(builtin.id);
    const std::vector<std::string> lines = lines_of(builtin.text);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!wanted(lines[i])) continue;
      if (++found % static_cast<int>(kOneOf) == 0) body(lines, i);
      if (::testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(found, least);
}

/// What a file may leave out, as robots/README.md says.
bool may_be_missing(const std::string& line) {
  constexpr std::string_view kKeys[] = {"acceleration_", "jerk_", "home_"};
  return std::ranges::any_of(kKeys, [&](auto key) { return trimmed(line).starts_with(key); });
}

TEST(SpoiledRobotFile, without_any_one_line_of_meaning_it_is_refused) {
  for_lines(
      400,
      [](const std::string& line) {
        return !is_blank(line) && !is_source(line) && !may_be_missing(line);
      },
      [](std::vector<std::string> lines, std::size_t i) {
        const std::string dropped = lines[i];
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
        EXPECT_FALSE(read_robot(joined(lines), "r").has_value()) << dropped;
      });
}

TEST(SpoiledRobotFile, without_the_source_of_a_table_it_is_refused) {
  for_lines(
      60,
      [](const std::string& line) {
        return trimmed(line).starts_with("source =") || trimmed(line).starts_with("source.rest");
      },
      [](std::vector<std::string> lines, std::size_t i) {
        const std::string dropped = lines[i];
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
        const auto model = read_robot(joined(lines), "r");
        ASSERT_FALSE(model.has_value()) << dropped;
        EXPECT_TRUE(model.error()[0].key.ends_with("source")) << to_text(model.error()[0]);
      });
}

TEST(SpoiledRobotFile, comments_and_empty_lines_mean_nothing) {
  for_lines(100, is_blank, [](std::vector<std::string> lines, std::size_t i) {
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_TRUE(read_robot(joined(lines), "r").has_value());
  });
}

TEST(SpoiledRobotFile, with_any_key_misspelt_it_is_refused_there) {
  for_lines(
      500, [](const std::string& line) { return !is_blank(line) && !is_header(line); },
      [](const std::vector<std::string>& lines, std::size_t i) {
        const std::size_t begin = lines[i].find_first_not_of(' ');
        const std::size_t end = lines[i].find(" =");
        for (std::size_t at = begin; at < end; ++at) {
          if (lines[i][at] == '.') continue;
          std::vector<std::string> spoiled = lines;
          spoiled[i][at] = spoiled[i][at] == 'q' ? 'w' : 'q';
          expect_refused_at(spoiled, i + 1, 0);
        }
      });
}

TEST(SpoiledRobotFile, with_any_header_misspelt_it_is_refused) {
  for_lines(80, is_header, [](const std::vector<std::string>& lines, std::size_t i) {
    for (std::size_t at = 0; at < lines[i].size(); ++at) {
      if (lines[i][at] < 'a' || lines[i][at] > 'z') continue;
      std::vector<std::string> spoiled = lines;
      spoiled[i][at] = 'q';
      EXPECT_FALSE(read_robot(joined(spoiled), "r").has_value()) << spoiled[i];
    }
  });
}

TEST(SpoiledRobotFile, with_any_unit_left_out_it_is_refused_there) {
  constexpr std::string_view kUnits[] = {"_deg_s3", "_deg_s2", "_deg_s", "_mm_s3", "_mm_s2",
                                         "_mm_s",   "_deg",    "_mm",    "_turn"};
  int ran = 0;
  for_lines(300, is_number_line, [&](const std::vector<std::string>& lines, std::size_t i) {
    for (const std::string_view unit : kUnits) {
      const std::size_t at = lines[i].find(unit);
      if (at == std::string::npos) continue;
      std::vector<std::string> spoiled = lines;
      spoiled[i].erase(at, unit.size());
      const auto model = read_robot(joined(spoiled), "r");
      ASSERT_FALSE(model.has_value()) << spoiled[i];
      EXPECT_EQ(model.error()[0].line, static_cast<int>(i + 1)) << to_text(model.error()[0]);
      EXPECT_TRUE(model.error()[0].message.starts_with("missing unit: write "))
          << to_text(model.error()[0]);
      ++ran;
      break;
    }
  });
  EXPECT_GT(ran * static_cast<int>(kOneOf), 200);
}

TEST(SpoiledRobotFile, with_any_number_absurd_it_is_refused_at_the_number) {
  int ran = 0;
  for_lines(300, is_number_line, [&](const std::vector<std::string>& lines, std::size_t i) {
    const std::vector<Token> numbers = numbers_of(lines[i]);
    EXPECT_FALSE(numbers.empty()) << lines[i];
    for (const Token& number : numbers) {
      for (const char* absurd : {"nan", "-nan", "inf", "-inf", "\"5\"", "1e300", "-1e300", "true",
                                 "[1]", "{}", "9223372036854775807", "2026-11-21"}) {
        std::vector<std::string> spoiled = lines;
        spoiled[i].replace(number.begin, number.size, absurd);
        // In a direction 1e300 and its like are refused too: components are bounded.
        expect_refused_at(spoiled, i + 1, number.begin + 1);
        ++ran;
      }
    }
  });
  EXPECT_GT(ran * static_cast<int>(kOneOf), 3000);
}

TEST(SpoiledRobotFile, with_swapped_limits_it_is_refused_at_the_upper_one) {
  for_lines(
      30, [](const std::string& line) { return line.starts_with("name = "); },
      [](std::vector<std::string> lines, std::size_t i) {
        std::string& lower = lines[i + 1];
        std::string& upper = lines[i + 2];
        ASSERT_TRUE(lower.starts_with("lower_") && upper.starts_with("upper_")) << lower;
        const std::string lower_value = lower.substr(lower.find("= "));
        lower.replace(lower.find("= "), std::string::npos, upper.substr(upper.find("= ")));
        upper.replace(upper.find("= "), std::string::npos, lower_value);
        expect_refused_at(lines, i + 3, upper.find("= ") + 3);
      });
}

TEST(SpoiledRobotFile, cut_short_at_any_byte_it_is_refused) {
  for (const BuiltinRobot& builtin : builtin_robots()) {
    const std::size_t last = builtin.text.find_last_not_of(" \n");
    for (std::size_t size = 0; size <= last; size += kOneOf) {
      // A comment may lose its end without anybody noticing; all built-in files end in a value.
      const std::string_view rest = builtin.text.substr(0, size);
      const bool read = read_robot(rest, "r").has_value();
      ASSERT_TRUE(!read || !rest.contains("[device]")) << builtin.id << " cut at byte " << size;
    }
    EXPECT_TRUE(read_robot(builtin.text.substr(0, last + 1), "r").has_value());
  }
}

std::string spoiled_at_random(Random& random) {
  const auto builtins = builtin_robots();
  const auto pick = [&](std::size_t size) {
    return static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(size) - 1));
  };
  std::string text(builtins[pick(builtins.size())].text);
  constexpr std::string_view kPieces[] = {"[",  "]",   "{",  "}", "\"", "'''",  "=",   "\n",
                                          ".",  "nan", "-",  "0", "9",  "e9",   "\\u", "#",
                                          "[[", "]]",  "\r", ",", "_",  "\xc3", "\0",  "joint"};
  for (std::int64_t i = random.integer(1, 6); i > 0; --i) {
    const std::size_t at = pick(text.size());
    const std::string_view piece = kPieces[pick(std::size(kPieces))];
    switch (random.integer(0, 3)) {
      case 0:
        text[at] = static_cast<char>(random.integer(-128, 127));
        break;
      case 1:
        text.insert(at, piece);
        break;
      case 2:
        text.replace(at, piece.size(), piece);
        break;
      default: {
        const std::string copy = text.substr(at, pick(200));
        text.insert(pick(text.size()), copy);
      }
    }
  }
  return text;
}

/// Some spoiled files are still files ("d_mm = 95" may become "d_mm = 9"); those give sound models.
TEST(SpoiledRobotFile, whatever_is_accepted_keeps_the_promises_of_the_model) {
  int accepted = 0;
  test::for_random_cases(5000, [&](Random& random) {
    const auto model = read_robot(spoiled_at_random(random), "r");
    if (!model) {
      EXPECT_FALSE(model.error().empty());
      for (const Complaint& complaint : model.error()) {
        EXPECT_GE(complaint.line, 1);
        EXPECT_GE(complaint.column, 1);
        EXPECT_FALSE(complaint.message.empty());
      }
      return;
    }
    ++accepted;
    EXPECT_EQ(broken_promise(*model), "");
  });
  EXPECT_GT(accepted, 100) << "the generator spoils too much to tell anything";
}

}  // namespace
}  // namespace sinew

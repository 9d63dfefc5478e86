#include "sinew/devices/ideal/ideal_wire.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <concepts>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/wire/crc32c.h"

namespace sinew::ideal {
namespace {

constexpr std::size_t kSumDigits = 8;
constexpr std::array<std::string_view, 4> kPhases{"rest", "moving", "stopping", "held"};
constexpr std::array<std::string_view, 5> kHelds{"-", "started", "silent", "starved", "blocked"};
constexpr std::array<std::string_view, 5> kWhys{"busy", "number", "limit", "form", "tool"};

std::uint32_t sum_of(std::string_view words) {
  return crc32c({reinterpret_cast<const std::uint8_t*>(words.data()), words.size()});
}

/// One line under way.
class Writer {
 public:
  Writer& word(std::string_view text) {
    if (!line_.empty()) line_.push_back(' ');
    for (const char c : text) line_.push_back(static_cast<std::uint8_t>(c));
    return *this;
  }
  Writer& number(std::int64_t value) {
    std::array<char, 24> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    return word({digits.data(), end});
  }
  Writer& numbers(const Numbers& q, const Numbers& qd) {
    SINEW_ASSERT(q.size() == qd.size());
    for (std::size_t i = 0; i < q.size(); ++i) number(q[i]).number(qd[i]);
    return *this;
  }
  Line end() {
    const std::uint32_t sum = sum_of({reinterpret_cast<const char*>(line_.data()), line_.size()});
    line_.push_back('*');
    for (std::size_t i = 0; i < kSumDigits; ++i) {
      constexpr std::string_view kHex = "0123456789ABCDEF";
      line_.push_back(static_cast<std::uint8_t>(kHex[sum >> (28 - 4 * i) & 15U]));
    }
    line_.push_back('\n');
    return line_;
  }

 private:
  Line line_;
};

/// Words one after the other; remembers whether one was missing or wrong.
class Reader {
 public:
  explicit Reader(std::string_view words) : rest_(words) {}

  std::string_view word() {
    const std::size_t end = std::min(rest_.find(' '), rest_.size());
    const std::string_view own = rest_.substr(0, end);
    const bool blank_at_end = end + 1 == rest_.size();
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    fine_ = fine_ && !own.empty() && !blank_at_end;
    return own;
  }
  /// Takes the next word where it is this one.
  bool next_is(std::string_view name) {
    const bool is = rest_.substr(0, rest_.find(' ')) == name;
    if (is) word();
    return is;
  }
  template <std::integral Number>
  Number number() {
    const std::string_view own = word();
    Number value{};
    const auto [end, error] = std::from_chars(own.data(), own.data() + own.size(), value);
    fine_ = fine_ && error == std::errc{} && end == own.data() + own.size();
    return value;
  }
  template <class Enum, std::size_t N>
  Enum one_of(const std::array<std::string_view, N>& names) {
    const auto found = std::ranges::find(names, word());
    fine_ = fine_ && found != names.end();
    return static_cast<Enum>(found == names.end() ? 0 : found - names.begin());
  }
  void numbers(Numbers& q, Numbers& qd) {
    while (fine_ && !rest_.empty() && !q.full()) {
      q.push_back(number<std::int32_t>());
      qd.push_back(number<std::int32_t>());
    }
    fine_ = fine_ && !q.empty();
  }
  /// All of it was read, and all of it was right.
  bool fine() const { return fine_ && rest_.empty(); }

 private:
  std::string_view rest_;
  bool fine_ = true;
};

struct RequestWriter {
  std::uint16_t own;
  Writer line() const { return Writer().number(own); }
  Line operator()(const Hello& /*hello*/) const { return line().word("hello").end(); }
  Line operator()(const Ask& /*ask*/) const { return line().word("ask").end(); }
  Line operator()(const Stop& /*stop*/) const { return line().word("stop").end(); }
  Line operator()(const Clear& /*clear*/) const { return line().word("clear").end(); }
  Line operator()(const Jaws& jaws) const {
    return line().word("jaws").number(jaws.width_um).end();
  }
  Line operator()(const Move& move) const {
    Writer words = line();
    words.word("move").number(move.number).number(move.duration_us).numbers(move.q, move.qd);
    return words.end();
  }
};

struct ReplyWriter {
  std::uint16_t own;
  Writer line() const { return Writer().number(own); }
  Line operator()(const Identity& one) const {
    return line().word("ideal").number(one.version).number(one.joints).number(one.taken).end();
  }
  Line operator()(const State& one) const {
    Writer words = line();
    words.word(word_of(one.phase));
    words.word(word_of(one.held)).number(one.joint);
    words.number(one.taken).number(one.done).number(one.jaws_um).numbers(one.q, one.qd);
    return words.end();
  }
  Line operator()(const Refusal& one) const {
    return line().word("no").word(word_of(one.why)).number(one.joint).end();
  }
};

std::optional<Request> read_request(Reader& reader) {
  const std::string_view name = reader.word();
  if (name == "hello") return Hello{};
  if (name == "ask") return Ask{};
  if (name == "stop") return Stop{};
  if (name == "clear") return Clear{};
  if (name == "jaws") return Jaws{reader.number<std::int32_t>()};
  if (name != "move") return std::nullopt;
  Move move;
  move.number = reader.number<std::uint16_t>();
  move.duration_us = reader.number<std::uint32_t>();
  reader.numbers(move.q, move.qd);
  return move;
}

/// Whether it is one, the reader knows.
Reply read_reply(Reader& reader) {
  if (reader.next_is("ideal")) {
    Identity one;
    one.version = reader.number<std::uint8_t>();
    one.joints = reader.number<std::uint8_t>();
    one.taken = reader.number<std::uint16_t>();
    return one;
  }
  if (reader.next_is("no")) {
    Refusal one;
    one.why = reader.one_of<Why>(kWhys);
    one.joint = reader.number<std::uint8_t>();
    return one;
  }
  State one;
  one.phase = reader.one_of<Phase>(kPhases);
  one.held = reader.one_of<Held>(kHelds);
  one.joint = reader.number<std::uint8_t>();
  one.taken = reader.number<std::uint16_t>();
  one.done = reader.number<std::uint16_t>();
  one.jaws_um = reader.number<std::int32_t>();
  reader.numbers(one.q, one.qd);
  return one;
}

}  // namespace

std::int32_t micro(double value) {
  return static_cast<std::int32_t>(std::lround(value / kMicro));
}

std::string_view word_of(Phase phase) {
  return kPhases[static_cast<std::size_t>(phase)];
}
std::string_view word_of(Held held) {
  return kHelds[static_cast<std::size_t>(held)];
}
std::string_view word_of(Why why) {
  return kWhys[static_cast<std::size_t>(why)];
}

Line encode(const Numbered<Request>& request) {
  return std::visit(RequestWriter{request.number}, request.what);
}
Line encode(const Numbered<Reply>& reply) {
  return std::visit(ReplyWriter{reply.number}, reply.what);
}

std::optional<Numbered<Request>> decode_request(std::string_view words) {
  Reader reader(words);
  const auto number = reader.number<std::uint16_t>();
  const auto request = read_request(reader);
  if (!request || !reader.fine()) return std::nullopt;
  return Numbered<Request>{number, *request};
}

std::optional<Numbered<Reply>> decode_reply(std::string_view words) {
  Reader reader(words);
  const auto number = reader.number<std::uint16_t>();
  const Reply reply = read_reply(reader);
  if (!reader.fine()) return std::nullopt;
  return Numbered<Reply>{number, reply};
}

LineDecoder::Result LineDecoder::push(std::uint8_t byte) {
  if (complete_) reset();
  if (byte != '\n') {
    if (text_.full()) too_long_ = true;
    if (!too_long_) text_.push_back(static_cast<char>(byte));
    return Result::kMore;
  }
  complete_ = true;
  if (!text_.empty() && text_.back() == '\r') text_.pop_back();  // as Serial.println ends lines
  if (text_.empty() && !too_long_) return Result::kMore;
  const std::string_view all{text_.data(), text_.size()};
  const bool long_enough = all.size() > kSumDigits + 1;
  if (too_long_ || !long_enough || all[all.size() - kSumDigits - 1] != '*') {
    return Result::kDamaged;
  }
  words_ = all.size() - kSumDigits - 1;
  const std::string_view digits = all.substr(words_ + 1);
  std::uint32_t sum = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), sum, 16);
  const bool whole = error == std::errc{} && end == digits.data() + digits.size();
  return whole && sum == sum_of(words()) ? Result::kLine : Result::kDamaged;
}

}  // namespace sinew::ideal

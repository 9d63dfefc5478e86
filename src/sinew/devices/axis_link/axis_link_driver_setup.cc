#include "sinew/devices/axis_link/axis_link_driver_setup.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/wire/little_words.h"

namespace sinew::axis_link {
namespace {

constexpr int kTries = 40;                                      // of one frame
constexpr Duration kPause = std::chrono::milliseconds(2);       // between two frames
constexpr Duration kWriting = std::chrono::milliseconds(3500);  // two sectors of the slowest flash
constexpr Duration kStarting = std::chrono::milliseconds(500);

/// One board, and frames to it of which each is repeated until an answer names it.
class Talk {
 public:
  Talk(const SetupLine& line, std::int8_t index) : line_(line), index_(index) {}

  /// Which axis it says that it is.
  std::expected<std::uint8_t, Error> find() {
    for (int i = 0; i < kTries; ++i) {
      if (const auto reply = exchange({.mode = Mode::kRead, .sequence = ++sequence_})) {
        axis_ = reply->axis;
        return axis_;
      }
    }
    return std::unexpected(
        error(other_version_ ? ErrorCode::kVersionMismatch : ErrorCode::kDeviceSilent));
  }
  /// A session, as whatever axis it is.
  std::expected<Identity, Error> open() {
    std::uint32_t hash = 0;
    for (int i = 0; i < kTries; ++i) {
      // Another host may have counted on: a window ahead is news to any session.
      sequence_ = static_cast<std::uint16_t>(sequence_ + kSequenceWindow);
      exchange(hello(axis_, sequence_, hash, kDeadlineMax));
      const auto reply = exchange(hello(axis_, sequence_, hash, kDeadlineMax));
      const auto* identity = reply ? std::get_if<Identity>(&reply->body) : nullptr;
      if (identity == nullptr) continue;
      if (identity->model_hash == hash && reply->session != 0 && reply->sequence == sequence_) {
        session_ = reply->session;
        return *identity;
      }
      hash = identity->model_hash;
    }
    return std::unexpected(error(ErrorCode::kDeviceSilent));
  }
  /// Carried out once; the answer that names it.
  std::expected<Reply, Error> ask(Mode mode, std::size_t index = 0, std::uint32_t value = 0) {
    const Request request{.axis = axis_,
                          .mode = mode,
                          .sequence = ++sequence_,
                          .target = std::bit_cast<std::int32_t>(value),
                          .velocity = static_cast<std::int32_t>(index),
                          .session = session_};
    for (int i = 0; i < kTries; ++i) {
      const auto reply = exchange(request);
      if (!reply || reply->session != session_ || reply->sequence != request.sequence) continue;
      const auto* state = std::get_if<State>(&reply->body);
      if (state != nullptr && state->verdict != Verdict::kAccepted) {
        const bool latched = state->verdict == Verdict::kEmergencyStopped;
        return std::unexpected(error(latched ? ErrorCode::kEmergencyStop : ErrorCode::kBusy));
      }
      return *reply;
    }
    return std::unexpected(error(ErrorCode::kDeviceSilent));
  }
  std::expected<std::uint32_t, Error> read_word(std::size_t index) {
    const auto reply = ask(Mode::kReadSetup, index);
    if (!reply) return std::unexpected(reply.error());
    const auto* word = std::get_if<SetupWord>(&reply->body);
    if (word == nullptr || word->index != index) {
      return std::unexpected(error(ErrorCode::kUnexpectedReply));
    }
    return word->value;
  }
  /// Words from `first` on, to fill `bytes`.
  std::expected<void, Error> read_words(std::size_t first, std::span<std::uint8_t> bytes) {
    for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
      const auto word = read_word(first + i);
      if (!word) return std::unexpected(word.error());
      put_little_word(bytes, i, *word);
    }
    return {};
  }
  Error error(ErrorCode code) const { return {code, index_, 0, 0}; }

 private:
  std::optional<Reply> exchange(const Request& request) {
    std::array<std::uint8_t, kFrameSize> miso{};
    const bool done = line_.exchange(encode(request), miso);
    line_.wait(kPause);
    if (!done) return std::nullopt;
    const auto reply = decode_reply(miso);
    other_version_ = other_version_ || (!reply && reply.error() == Reject::kOtherVersion);
    return reply ? std::optional(*reply) : std::nullopt;
  }

  const SetupLine& line_;
  std::int8_t index_;
  std::uint8_t axis_ = 0;
  std::uint8_t session_ = 0;
  std::uint16_t sequence_ = 0;
  bool other_version_ = false;
};

/// What a board keeps, and the count of its starts.
struct Kept {
  SetupBytes bytes;
  std::uint16_t boot = 0;
};

std::expected<Kept, Error> read_all(Talk& talk) {
  if (const auto found = talk.find(); !found) return std::unexpected(found.error());
  const auto opened = talk.open();
  if (!opened) return std::unexpected(opened.error());
  Kept kept{{}, opened->boot};
  if (const auto read = talk.read_words(0, kept.bytes); !read) {
    return std::unexpected(read.error());
  }
  return kept;
}

}  // namespace

std::expected<std::optional<BoardImage>, Error> read_board_image(std::int8_t joint,
                                                                 const SetupLine& line) {
  Talk talk(line, joint);
  if (const auto found = talk.find(); !found) return std::unexpected(found.error());
  if (const auto opened = talk.open(); !opened) return std::unexpected(opened.error());
  // A board without an identity refuses its words.
  const auto first = talk.read_word(kImageWord);
  if (!first && first.error().code == ErrorCode::kBusy) return std::nullopt;
  ImageIdentity identity{};
  if (const auto read = talk.read_words(kImageWord, identity); !read) {
    return std::unexpected(read.error());
  }
  const auto image = decode_identity(identity);
  if (!image) return std::unexpected(talk.error(ErrorCode::kUnexpectedReply));
  return image;
}

std::expected<SetupReport, Error> write_setup(const SetupBytes& wanted, std::int8_t joint,
                                              const SetupLine& line) {
  Talk talk(line, joint);
  const auto before = read_all(talk);
  if (!before) return std::unexpected(before.error());
  if (before->bytes == wanted) return SetupReport{before->bytes, false};
  for (std::size_t i = 0; i < kSetupWords; ++i) {
    const auto reply = talk.ask(Mode::kWriteSetup, i, little_word(wanted, i));
    if (!reply) return std::unexpected(reply.error());
  }
  // The processor stands while its flash is written: the answer comes late, or is lost with the
  // start behind it.
  const auto stored = talk.ask(Mode::kStoreSetup);
  if (!stored && stored.error().code != ErrorCode::kDeviceSilent) {
    return std::unexpected(stored.error());
  }
  line.wait(stored ? kStarting : kWriting);
  const auto after = read_all(talk);
  if (!after) return std::unexpected(after.error());
  // Nothing counts but what it keeps, and that it has started with it.
  if (after->bytes != wanted || after->boot == before->boot) {
    return std::unexpected(talk.error(ErrorCode::kUnexpectedReply));
  }
  return SetupReport{before->bytes, true};
}

}  // namespace sinew::axis_link

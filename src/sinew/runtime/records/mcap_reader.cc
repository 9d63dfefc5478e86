#include "sinew/runtime/records/mcap_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <utility>

#include "sinew/runtime/records/mcap_record.h"

namespace sinew::runtime {
namespace {

using mcap::Opcode;
using ByteView = std::span<const std::uint8_t>;

/// Numbers and texts from the front of a record's content; behind its end everything is zero and
/// `ok` is false.
class Cursor {
 public:
  explicit Cursor(ByteView bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const ByteView bytes = take(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < bytes.size(); ++k) value |= std::uint64_t{bytes[k]} << (8 * k);
    return static_cast<T>(value);
  }
  ByteView take(std::uint64_t size) {
    if (size > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const ByteView taken = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(static_cast<std::size_t>(size));
    return taken;
  }
  std::string_view view(std::uint64_t size) {
    const ByteView bytes = take(size);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::string text() { return std::string(view(number<std::uint32_t>())); }
  McapPairs pairs() {
    Cursor map(take(number<std::uint32_t>()));
    McapPairs pairs;
    while (ok_ && !map.rest_.empty()) {
      std::string key = map.text();
      std::string value = map.text();
      ok_ = map.ok_ && pairs.emplace(std::move(key), std::move(value)).second;
    }
    return pairs;
  }
  std::size_t left() const { return rest_.size(); }
  bool ok() const { return ok_; }
  /// All of it was read, and nothing more was asked for.
  bool ended() const { return ok_ && rest_.empty(); }

 private:
  ByteView rest_;
  bool ok_ = true;
};

using IndexEntry = std::pair<std::uint64_t, std::uint64_t>;  // time or channel, offset

struct SeenChunk {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t size = 0;
  std::vector<IndexEntry> message_indexes;
  std::uint64_t message_index_length = 0;
  friend bool operator==(const SeenChunk&, const SeenChunk&) = default;
};

class Reader {
 public:
  Reader(ByteView file, McapContent& content) : file_(file), content_(content) {}
  void read();

 private:
  struct Record {
    std::uint8_t opcode = 0;
    ByteView content;
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  bool wrong(std::size_t offset, std::string sentence, bool cut = false) {
    if (!content_.trouble) content_.trouble = {offset, std::move(sentence), cut};
    return false;
  }
  bool magic(std::size_t at, const char* where);
  std::optional<Record> next();
  bool header(const Record& record);
  bool data(const Record& record);
  bool schema(const Record& record, bool again);
  bool channel(const Record& record, bool again);
  bool chunk(const Record& record);
  void cut_chunk(ByteView content);
  bool messages(ByteView records, std::size_t begin, bool whole);
  bool message_index(const Record& record);
  bool no_index_missing(std::size_t at);
  bool metadata(const Record& record);
  bool data_end(const Record& record);
  bool summary(const Record& record);
  bool statistics(const Record& record);
  bool chunk_index(const Record& record);
  bool metadata_index(const Record& record);
  bool summary_offset(const Record& record);
  bool footer(const Record& record);

  ByteView file_;
  McapContent& content_;
  std::size_t at_ = 0;
  std::vector<SeenChunk> chunks_;
  std::map<std::uint16_t, std::vector<IndexEntry>> pending_;  ///< of the last chunk: no index yet
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::map<std::uint64_t, std::pair<std::uint64_t, std::string>> metadata_;
  std::size_t summary_begin_ = 0;
  std::optional<std::size_t> offsets_begin_;
  std::map<std::uint8_t, IndexEntry> groups_;  ///< of the summary: begin, end
  std::size_t groups_told_ = 0;
  std::size_t chunk_indexes_ = 0;
  std::size_t metadata_indexes_ = 0;
  std::size_t schemas_again_ = 0;
  std::size_t channels_again_ = 0;
  bool statistics_ = false;
};

bool Reader::magic(std::size_t at, const char* where) {
  const ByteView rest = file_.subspan(at);
  const std::size_t size = std::min(rest.size(), mcap::kMagic.size());
  if (!std::ranges::equal(rest.first(size), std::span(mcap::kMagic).first(size))) {
    return wrong(at, fmt::format("the {} of the file is not that of MCAP, version 0", where));
  }
  at_ = at + size;
  return size == mcap::kMagic.size() || wrong(at, "the file ends in its magic bytes", true);
}

std::optional<Reader::Record> Reader::next() {
  Cursor cursor(file_.subspan(at_));
  Record record;
  record.begin = at_;
  record.opcode = cursor.number<std::uint8_t>();
  const auto length = cursor.number<std::uint64_t>();
  if (!cursor.ok()) {
    wrong(at_, "the file ends between two records, and has no footer", true);
    return std::nullopt;
  }
  if (length > cursor.left()) {
    wrong(at_, fmt::format("a record of {} bytes has {}", length, cursor.left()), true);
    if (record.opcode == static_cast<std::uint8_t>(Opcode::kChunk) && summary_begin_ == 0) {
      cut_chunk(cursor.take(cursor.left()));
    }
    return std::nullopt;
  }
  record.content = cursor.take(length);
  record.end = at_ + mcap::kRecordHead + record.content.size();
  at_ = record.end;
  return record;
}

void Reader::read() {
  if (!magic(0, "begin")) return;
  auto record = next();
  if (!record || !header(*record)) return;
  while (summary_begin_ == 0) {
    record = next();
    if (!record || !data(*record)) return;
  }
  while (true) {
    record = next();
    if (!record) return;
    if (record->opcode == static_cast<std::uint8_t>(Opcode::kFooter)) break;
    if (!summary(*record)) return;
  }
  if (!footer(*record) || !magic(at_, "end")) return;
  if (at_ != file_.size()) wrong(at_, "there are bytes behind the end of the file");
}

bool Reader::header(const Record& record) {
  Cursor cursor(record.content);
  if (record.opcode != static_cast<std::uint8_t>(Opcode::kHeader)) {
    return wrong(record.begin, "the first record is no header");
  }
  static_cast<void>(cursor.text());  // the profile: none that Sinew knows
  content_.library = cursor.text();
  return cursor.ended() || wrong(record.begin, "the header is not readable");
}

bool Reader::data(const Record& record) {
  const auto opcode = static_cast<Opcode>(record.opcode);
  if (opcode == Opcode::kMessageIndex) return message_index(record);
  if (!no_index_missing(record.begin)) return false;
  switch (opcode) {
    case Opcode::kSchema:
      return schema(record, false);
    case Opcode::kChannel:
      return channel(record, false);
    case Opcode::kChunk:
      return chunk(record);
    case Opcode::kMetadata:
      return metadata(record);
    case Opcode::kDataEnd:
      return data_end(record);
    default:
      return wrong(record.begin,
                   fmt::format("a record of kind {:#04x} has no place here", record.opcode));
  }
}

bool Reader::schema(const Record& record, bool again) {
  Cursor cursor(record.content);
  const auto id = cursor.number<std::uint16_t>();
  McapSchema schema{cursor.text(), cursor.text(), cursor.text()};
  if (!cursor.ended() || id == 0) return wrong(record.begin, "a schema is not readable");
  const auto found = content_.schemas.find(id);
  const bool known = found != content_.schemas.end();
  if (again) {
    ++schemas_again_;
    const bool same = known && found->second.name == schema.name &&
                      found->second.encoding == schema.encoding &&
                      found->second.data == schema.data;
    return same || wrong(record.begin, "the summary has a schema that the data has not");
  }
  if (known) return wrong(record.begin, fmt::format("there are two schemas {}", id));
  content_.schemas.emplace(id, std::move(schema));
  return true;
}

bool Reader::channel(const Record& record, bool again) {
  Cursor cursor(record.content);
  const auto id = cursor.number<std::uint16_t>();
  McapChannel channel{cursor.number<std::uint16_t>(), cursor.text(), cursor.text(), cursor.pairs()};
  if (!cursor.ended()) return wrong(record.begin, "a channel is not readable");
  const auto found = content_.channels.find(id);
  const bool known = found != content_.channels.end();
  if (again) {
    ++channels_again_;
    const bool same =
        known && found->second.schema == channel.schema && found->second.topic == channel.topic &&
        found->second.encoding == channel.encoding && found->second.metadata == channel.metadata;
    return same || wrong(record.begin, "the summary has a channel that the data has not");
  }
  if (known) return wrong(record.begin, fmt::format("there are two channels {}", id));
  if (channel.schema != 0 && !content_.schemas.contains(channel.schema)) {
    return wrong(record.begin, fmt::format("channel {} has a schema that is not there", id));
  }
  content_.channels.emplace(id, std::move(channel));
  return true;
}

bool Reader::chunk(const Record& record) {
  Cursor cursor(record.content);
  SeenChunk seen;
  seen.first = cursor.number<std::uint64_t>();
  seen.last = cursor.number<std::uint64_t>();
  seen.size = cursor.number<std::uint64_t>();
  const auto crc = cursor.number<std::uint32_t>();
  const std::string compression = cursor.text();
  const auto size = cursor.number<std::uint64_t>();
  const std::size_t begin = record.end - cursor.left();
  const ByteView records = cursor.take(size);
  if (cursor.ok() && !compression.empty()) {
    return wrong(record.begin, "a chunk is compressed, which Sinew's files are not");
  }
  if (!cursor.ended() || size != seen.size) return wrong(record.begin, "a chunk is not readable");
  if (crc != 0 && crc != mcap::crc32(records)) {
    return wrong(record.begin, "a chunk is damaged: its checksum is another one");
  }
  seen.offset = record.begin;
  seen.length = record.end - record.begin;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  const std::size_t before = content_.messages.size();
  if (!messages(records, begin, true)) return false;
  for (std::size_t k = before; k < content_.messages.size(); ++k) {
    const std::uint64_t time = content_.messages[k].time;
    first = k == before ? time : std::min(first, time);
    last = std::max(last, time);
  }
  if (first != seen.first || last != seen.last) {
    return wrong(record.begin, "a chunk's times are not those of its messages");
  }
  chunks_.push_back(std::move(seen));
  return true;
}

/// What is there of a chunk whose end is missing, and with it what its checksum counts.
void Reader::cut_chunk(ByteView content) {
  Cursor cursor(content);
  cursor.take(3 * sizeof(std::uint64_t) + sizeof(std::uint32_t));
  const std::string compression = cursor.text();
  cursor.number<std::uint64_t>();
  if (!cursor.ok() || !compression.empty()) return;
  const std::size_t begin = file_.size() - cursor.left();
  messages(cursor.take(cursor.left()), begin, false);
}

bool Reader::messages(ByteView records, std::size_t begin, bool whole) {
  std::size_t at = 0;
  while (at < records.size()) {
    Cursor cursor(records.subspan(at));
    const auto opcode = cursor.number<std::uint8_t>();
    const auto length = cursor.number<std::uint64_t>();
    const ByteView bytes = cursor.take(length);
    if (!cursor.ok()) return !whole || wrong(begin + at, "a record goes beyond its chunk");
    if (opcode != static_cast<std::uint8_t>(Opcode::kMessage)) {
      return wrong(begin + at, "a chunk holds something else than messages");
    }
    Cursor inner(bytes);
    McapMessage message;
    message.channel = inner.number<std::uint16_t>();
    message.sequence = inner.number<std::uint32_t>();
    message.time = inner.number<std::uint64_t>();
    inner.number<std::uint64_t>();
    message.data = inner.view(inner.left());
    if (!inner.ok()) return wrong(begin + at, "a message is not readable");
    if (!content_.channels.contains(message.channel)) {
      return wrong(begin + at, "a message is of a channel that is not there");
    }
    pending_[message.channel].emplace_back(message.time, at);
    ++counts_[message.channel];
    content_.messages.push_back(message);
    at += mcap::kRecordHead + bytes.size();
  }
  return true;
}

bool Reader::message_index(const Record& record) {
  Cursor cursor(record.content);
  const auto channel = cursor.number<std::uint16_t>();
  Cursor entries(cursor.take(cursor.number<std::uint32_t>()));
  std::vector<IndexEntry> index;
  while (entries.ok() && entries.left() > 0) {
    const auto time = entries.number<std::uint64_t>();
    index.emplace_back(time, entries.number<std::uint64_t>());
  }
  const auto found = pending_.find(channel);
  const bool same = cursor.ended() && entries.ok() && found != pending_.end() &&
                    found->second == index && !chunks_.empty();
  if (!same) return wrong(record.begin, "a chunk's index does not fit what is in it");
  pending_.erase(found);
  chunks_.back().message_indexes.emplace_back(channel, record.begin);
  chunks_.back().message_index_length += record.end - record.begin;
  return true;
}

bool Reader::no_index_missing(std::size_t at) {
  return pending_.empty() || wrong(at, "a chunk's index is missing");
}

bool Reader::metadata(const Record& record) {
  Cursor cursor(record.content);
  std::string name = cursor.text();
  McapPairs pairs = cursor.pairs();
  if (!cursor.ended()) return wrong(record.begin, "metadata is not readable");
  metadata_[record.begin] = {record.end - record.begin, name};
  return content_.metadata.emplace(std::move(name), std::move(pairs)).second ||
         wrong(record.begin, "there is metadata of the same name twice");
}

bool Reader::data_end(const Record& record) {
  Cursor cursor(record.content);
  const auto crc = cursor.number<std::uint32_t>();
  if (!cursor.ended()) return wrong(record.begin, "the end of the data is not readable");
  if (crc != 0 && crc != mcap::crc32(file_.first(record.begin))) {
    return wrong(record.begin, "the data is damaged: its checksum is another one");
  }
  summary_begin_ = record.end;
  return true;
}

bool Reader::summary(const Record& record) {
  const auto opcode = static_cast<Opcode>(record.opcode);
  if (opcode == Opcode::kSummaryOffset) return summary_offset(record);
  if (offsets_begin_) return wrong(record.begin, "a record stands between the summary's offsets");
  const auto [group, fresh] = groups_.try_emplace(record.opcode, record.begin, record.begin);
  if (group->second.second != record.begin) {
    return wrong(record.begin, "records of one kind do not stand together in the summary");
  }
  group->second.second = record.end;
  switch (opcode) {
    case Opcode::kSchema:
      return schema(record, true);
    case Opcode::kChannel:
      return channel(record, true);
    case Opcode::kStatistics:
      return statistics(record);
    case Opcode::kChunkIndex:
      return chunk_index(record);
    case Opcode::kMetadataIndex:
      return metadata_index(record);
    default:
      return wrong(record.begin, fmt::format("a record of kind {:#04x} has no place in the summary",
                                             record.opcode));
  }
}

bool Reader::statistics(const Record& record) {
  Cursor cursor(record.content);
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  for (const McapMessage& message : content_.messages) {
    first = &message == content_.messages.data() ? message.time : std::min(first, message.time);
    last = std::max(last, message.time);
  }
  bool same = !std::exchange(statistics_, true);
  same &= cursor.number<std::uint64_t>() == content_.messages.size();
  same &= cursor.number<std::uint16_t>() == content_.schemas.size();
  same &= cursor.number<std::uint32_t>() == content_.channels.size();
  same &= cursor.number<std::uint32_t>() == 0;
  same &= cursor.number<std::uint32_t>() == metadata_.size();
  same &= cursor.number<std::uint32_t>() == chunks_.size();
  same &= cursor.number<std::uint64_t>() == first;
  same &= cursor.number<std::uint64_t>() == last;
  Cursor counts(cursor.take(cursor.number<std::uint32_t>()));
  std::map<std::uint16_t, std::uint64_t> told;
  while (counts.ok() && counts.left() > 0) {
    const auto channel = counts.number<std::uint16_t>();
    const auto count = counts.number<std::uint64_t>();
    if (count > 0) told[channel] = count;
  }
  same &= counts.ok() && cursor.ended() && told == counts_;
  return same || wrong(record.begin, "the statistics do not fit the data");
}

bool Reader::chunk_index(const Record& record) {
  Cursor cursor(record.content);
  SeenChunk told;
  told.first = cursor.number<std::uint64_t>();
  told.last = cursor.number<std::uint64_t>();
  told.offset = cursor.number<std::uint64_t>();
  told.length = cursor.number<std::uint64_t>();
  Cursor indexes(cursor.take(cursor.number<std::uint32_t>()));
  while (indexes.ok() && indexes.left() > 0) {
    const auto channel = indexes.number<std::uint16_t>();
    told.message_indexes.emplace_back(channel, indexes.number<std::uint64_t>());
  }
  told.message_index_length = cursor.number<std::uint64_t>();
  const std::string compression = cursor.text();
  told.size = cursor.number<std::uint64_t>();
  const bool same = cursor.number<std::uint64_t>() == told.size && compression.empty() &&
                    indexes.ok() && cursor.ended() && chunk_indexes_ < chunks_.size() &&
                    told == chunks_[chunk_indexes_];
  ++chunk_indexes_;
  return same || wrong(record.begin, "an index of a chunk does not fit the chunk");
}

bool Reader::metadata_index(const Record& record) {
  Cursor cursor(record.content);
  const auto offset = cursor.number<std::uint64_t>();
  const auto length = cursor.number<std::uint64_t>();
  const std::string name = cursor.text();
  const auto found = metadata_.find(offset);
  ++metadata_indexes_;
  const bool same = cursor.ended() && found != metadata_.end() && found->second.first == length &&
                    found->second.second == name;
  return same || wrong(record.begin, "an index of metadata does not fit it");
}

bool Reader::summary_offset(const Record& record) {
  if (!offsets_begin_) offsets_begin_ = record.begin;
  Cursor cursor(record.content);
  const auto found = groups_.find(cursor.number<std::uint8_t>());
  const auto begin = cursor.number<std::uint64_t>();
  const auto length = cursor.number<std::uint64_t>();
  ++groups_told_;
  const bool same = cursor.ended() && found != groups_.end() && found->second.first == begin &&
                    found->second.second - begin == length;
  return same || wrong(record.begin, "an offset of the summary does not fit it");
}

bool Reader::footer(const Record& record) {
  const bool whole = statistics_ && chunk_indexes_ == chunks_.size() &&
                     metadata_indexes_ == metadata_.size() && groups_told_ == groups_.size() &&
                     schemas_again_ == content_.schemas.size() &&
                     channels_again_ == content_.channels.size();
  if (!whole) return wrong(record.begin, "the summary leaves out a part of the data");
  Cursor cursor(record.content);
  const bool same = cursor.number<std::uint64_t>() == summary_begin_ &&
                    cursor.number<std::uint64_t>() == offsets_begin_.value_or(0);
  const auto crc = cursor.number<std::uint32_t>();
  if (!same || !cursor.ended()) return wrong(record.begin, "the footer does not fit the file");
  const ByteView covered = file_.subspan(summary_begin_, record.end - 4 - summary_begin_);
  return crc == 0 || crc == mcap::crc32(covered) ||
         wrong(record.begin, "the summary is damaged: its checksum is another one");
}

}  // namespace

McapContent read_mcap(std::span<const std::uint8_t> file) {
  McapContent content;
  Reader(file, content).read();
  return content;
}

std::optional<double> mcap_length(
    std::uint64_t file_size,
    const std::function<std::string(std::uint64_t offset, std::size_t size)>& part) {
  constexpr std::size_t kFooter = mcap::kRecordHead + 20;
  constexpr std::size_t kTail = kFooter + mcap::kMagic.size();
  // The indexes of all chunks that a file may have are less.
  constexpr std::uint64_t kSummaryMax = std::uint64_t{32} << 20;
  if (file_size < kTail) return std::nullopt;
  const auto bytes_of = [](const std::string& text) {
    return ByteView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  };
  const std::string end = part(file_size - kTail, kTail);
  if (end.size() != kTail || !std::ranges::equal(bytes_of(end).last(8), mcap::kMagic)) {
    return std::nullopt;
  }
  Cursor footer(bytes_of(end));
  if (footer.number<std::uint8_t>() != static_cast<std::uint8_t>(Opcode::kFooter)) {
    return std::nullopt;
  }
  footer.number<std::uint64_t>();
  const auto begin = footer.number<std::uint64_t>();
  if (begin == 0 || begin >= file_size - kTail || file_size - begin > kSummaryMax) {
    return std::nullopt;
  }
  const std::string text = part(begin, static_cast<std::size_t>(file_size - kTail - begin));
  Cursor summary(bytes_of(text));
  while (summary.ok() && summary.left() > 0) {
    const auto opcode = summary.number<std::uint8_t>();
    Cursor record(summary.take(summary.number<std::uint64_t>()));
    if (opcode != static_cast<std::uint8_t>(Opcode::kStatistics)) continue;
    const auto messages = record.number<std::uint64_t>();
    record.take(2 + 4 + 4 + 4 + 4);  // how many of what else there are
    const auto first = record.number<std::uint64_t>();
    const auto last = record.number<std::uint64_t>();
    if (!record.ok() || messages == 0) return std::nullopt;
    return seconds_between(first, last);
  }
  return std::nullopt;
}

}  // namespace sinew::runtime

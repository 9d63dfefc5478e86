#include "sinew/runtime/records/mcap_writer.h"

#include <algorithm>
#include <concepts>

#include "sinew/core/assert.h"
#include "sinew/runtime/records/mcap_record.h"

namespace sinew::runtime {
namespace {

using mcap::Opcode;
using Bytes = std::vector<std::uint8_t>;

template <std::unsigned_integral T>
void add(Bytes& out, T value) {
  for (std::size_t k = 0; k < sizeof(T); ++k) {
    out.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * k)));
  }
}

void add_raw(Bytes& out, std::string_view text) {
  out.insert(out.end(), text.begin(), text.end());
}

void add(Bytes& out, std::string_view text) {
  add(out, static_cast<std::uint32_t>(text.size()));
  add_raw(out, text);
}

void add(Bytes& out, const McapPairs& pairs) {
  Bytes map;
  for (const auto& [key, value] : pairs) {
    add(map, std::string_view(key));
    add(map, std::string_view(value));
  }
  add(out, static_cast<std::uint32_t>(map.size()));
  out.insert(out.end(), map.begin(), map.end());
}

/// A record whose content `fill` appends; its length is known behind that.
template <class Fill>
void add_record(Bytes& out, Opcode opcode, const Fill& fill) {
  out.push_back(static_cast<std::uint8_t>(opcode));
  const std::size_t place = out.size();
  add(out, std::uint64_t{0});
  fill();
  const std::uint64_t length = out.size() - place - 8;
  for (std::size_t k = 0; k < 8; ++k) out[place + k] = static_cast<std::uint8_t>(length >> (8 * k));
}

}  // namespace

McapWriter::McapWriter(Sink sink, std::string_view library) : sink_(std::move(sink)) {
  put(mcap::kMagic);
  Bytes out;
  add_record(out, Opcode::kHeader, [&] {
    add(out, std::string_view());
    add(out, library);
  });
  put(out);
}

void McapWriter::put(std::span<const std::uint8_t> bytes) {
  crc_ = mcap::crc32(bytes, crc_);
  written_ += bytes.size();
  sink_(bytes);
}

void McapWriter::encode(Bytes& out, std::uint16_t id, const Schema& schema) {
  add_record(out, Opcode::kSchema, [&] {
    add(out, id);
    add(out, std::string_view(schema.name));
    add(out, std::string_view(schema.encoding));
    add(out, std::string_view(schema.data));
  });
}

void McapWriter::encode(Bytes& out, std::uint16_t id, const Channel& channel) {
  add_record(out, Opcode::kChannel, [&] {
    add(out, id);
    add(out, channel.schema);
    add(out, std::string_view(channel.topic));
    add(out, std::string_view(channel.encoding));
    add(out, channel.metadata);
  });
}

void McapWriter::encode(Bytes& out, const ChunkIndex& chunk) {
  add_record(out, Opcode::kChunkIndex, [&] {
    for (const std::uint64_t number : {chunk.first, chunk.last, chunk.offset, chunk.length}) {
      add(out, number);
    }
    add(out, static_cast<std::uint32_t>(chunk.message_indexes.size() * 10));
    for (const auto& [channel, offset] : chunk.message_indexes) {
      add(out, channel);
      add(out, offset);
    }
    add(out, chunk.message_index_length);
    add(out, std::string_view());  // not compressed
    add(out, chunk.size);
    add(out, chunk.size);
  });
}

std::uint16_t McapWriter::add_schema(std::string_view name, std::string_view encoding,
                                     std::string_view data) {
  schemas_.push_back({std::string(name), std::string(encoding), std::string(data)});
  const auto id = static_cast<std::uint16_t>(schemas_.size());
  Bytes out;
  encode(out, id, schemas_.back());
  put(out);
  return id;
}

std::uint16_t McapWriter::add_channel(std::uint16_t schema, std::string_view topic,
                                      std::string_view encoding, const McapPairs& metadata) {
  SINEW_ASSERT(schema <= schemas_.size());
  Channel channel;
  channel.schema = schema;
  channel.topic = topic;
  channel.encoding = encoding;
  channel.metadata = metadata;
  const auto id = static_cast<std::uint16_t>(channels_.size());
  Bytes out;
  encode(out, id, channel);
  put(out);
  channels_.push_back(std::move(channel));
  return id;
}

bool McapWriter::add_message(std::uint16_t id, std::uint64_t time, std::string_view data) {
  SINEW_ASSERT(id < channels_.size());
  const bool ends = !chunk_.empty() && (chunk_.size() + data.size() > kChunkBytes ||
                                        time >= chunk_first_ + kChunkTime || time < chunk_first_);
  if (ends) end_chunk();
  if (chunk_.empty() && chunks_.size() >= kChunksMax) return false;
  Channel& channel = channels_[id];
  if (chunk_.empty()) chunk_first_ = chunk_last_ = time;
  chunk_first_ = std::min(chunk_first_, time);
  chunk_last_ = std::max(chunk_last_, time);
  channel.index.emplace_back(time, chunk_.size());
  add_record(chunk_, Opcode::kMessage, [&] {
    add(chunk_, id);
    add(chunk_, channel.sequence++);
    add(chunk_, time);
    add(chunk_, time);
    add_raw(chunk_, data);
  });
  ++channel.messages;
  first_ = messages_ == 0 ? time : std::min(first_, time);
  last_ = messages_ == 0 ? time : std::max(last_, time);
  ++messages_;
  return true;
}

void McapWriter::add_metadata(std::string_view name, const McapPairs& pairs) {
  end_chunk();
  Bytes out;
  add_record(out, Opcode::kMetadata, [&] {
    add(out, name);
    add(out, pairs);
  });
  metadata_.push_back({written_, out.size(), std::string(name)});
  put(out);
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex chunk;
  chunk.first = chunk_first_;
  chunk.last = chunk_last_;
  chunk.offset = written_;
  chunk.size = chunk_.size();
  Bytes out;
  add_record(out, Opcode::kChunk, [&] {
    add(out, chunk.first);
    add(out, chunk.last);
    add(out, chunk.size);
    add(out, mcap::crc32(chunk_));
    add(out, std::string_view());  // not compressed
    add(out, chunk.size);
    out.insert(out.end(), chunk_.begin(), chunk_.end());
  });
  chunk.length = out.size();
  put(out);
  chunk_.clear();
  write_message_indexes(chunk);
  chunks_.push_back(std::move(chunk));
}

void McapWriter::write_message_indexes(ChunkIndex& chunk) {
  const std::uint64_t begin = written_;
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    auto& index = channels_[id].index;
    if (index.empty()) continue;
    chunk.message_indexes.emplace_back(static_cast<std::uint16_t>(id), written_);
    Bytes out;
    add_record(out, Opcode::kMessageIndex, [&] {
      add(out, static_cast<std::uint16_t>(id));
      add(out, static_cast<std::uint32_t>(index.size() * 16));
      for (const auto& [time, offset] : index) {
        add(out, time);
        add(out, offset);
      }
    });
    put(out);
    index.clear();
  }
  chunk.message_index_length = written_ - begin;
}

void McapWriter::encode_statistics(Bytes& out) const {
  add_record(out, Opcode::kStatistics, [&] {
    add(out, messages_);
    add(out, static_cast<std::uint16_t>(schemas_.size()));
    add(out, static_cast<std::uint32_t>(channels_.size()));
    add(out, std::uint32_t{0});  // attachments
    add(out, static_cast<std::uint32_t>(metadata_.size()));
    add(out, static_cast<std::uint32_t>(chunks_.size()));
    add(out, first_);
    add(out, last_);
    add(out, static_cast<std::uint32_t>(channels_.size() * 10));
    for (std::size_t id = 0; id < channels_.size(); ++id) {
      add(out, static_cast<std::uint16_t>(id));
      add(out, channels_[id].messages);
    }
  });
}

void McapWriter::finish() {
  end_chunk();
  Bytes out;
  add_record(out, Opcode::kDataEnd, [&] { add(out, crc_); });
  put(out);
  const std::uint64_t begin = written_;
  Bytes summary;
  Bytes offsets;
  const auto group = [&](Opcode opcode, std::size_t count, const auto& encode_one) {
    const std::size_t from = summary.size();
    for (std::size_t k = 0; k < count; ++k) encode_one(k);
    if (count == 0) return;
    add_record(offsets, Opcode::kSummaryOffset, [&] {
      add(offsets, static_cast<std::uint8_t>(opcode));
      add(offsets, std::uint64_t{begin + from});
      add(offsets, std::uint64_t{summary.size() - from});
    });
  };
  group(Opcode::kSchema, schemas_.size(),
        [&](std::size_t k) { encode(summary, static_cast<std::uint16_t>(k + 1), schemas_[k]); });
  group(Opcode::kChannel, channels_.size(),
        [&](std::size_t k) { encode(summary, static_cast<std::uint16_t>(k), channels_[k]); });
  group(Opcode::kStatistics, 1, [&](std::size_t) { encode_statistics(summary); });
  group(Opcode::kChunkIndex, chunks_.size(), [&](std::size_t k) { encode(summary, chunks_[k]); });
  group(Opcode::kMetadataIndex, metadata_.size(), [&](std::size_t k) {
    add_record(summary, Opcode::kMetadataIndex, [&] {
      add(summary, metadata_[k].offset);
      add(summary, metadata_[k].length);
      add(summary, std::string_view(metadata_[k].name));
    });
  });
  const std::uint64_t offsets_begin = begin + summary.size();
  summary.insert(summary.end(), offsets.begin(), offsets.end());
  add_record(summary, Opcode::kFooter, [&] {
    add(summary, begin);
    add(summary, offsets_begin);
    add(summary, std::uint32_t{0});
  });
  // The checksum stands last in the footer, and covers all in front of it.
  const std::size_t covered = summary.size() - sizeof(std::uint32_t);
  const std::uint32_t crc = mcap::crc32(std::span(summary).first(covered));
  for (std::size_t k = 0; k < sizeof(crc); ++k) {
    summary[covered + k] = static_cast<std::uint8_t>(crc >> (8 * k));
  }
  put(summary);
  put(mcap::kMagic);
}

}  // namespace sinew::runtime

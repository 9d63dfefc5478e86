#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew::runtime {

using McapPairs = std::map<std::string, std::string>;

/// Encodes an MCAP file (https://mcap.dev/spec) into a sink of bytes; it knows no file. Messages
/// stand in uncompressed chunks with their indexes, since viewers seek by these; a chunk ends after
/// kChunkTime or kChunkBytes, so that a process that dies takes no more than that with it. Schemas
/// and channels stand outside of chunks: whoever reads a file that was cut knows them.
class McapWriter {
 public:
  using Sink = std::function<void(std::span<const std::uint8_t>)>;

  static constexpr std::uint64_t kChunkTime = 1'000'000'000;  ///< ns of log time
  static constexpr std::size_t kChunkBytes = std::size_t{256} << 10;
  /// The indexes of all chunks wait for the end of the file: some 120 bytes each. At one a second
  /// it is a day and a half.
  static constexpr std::size_t kChunksMax = 131'072;

  /// @param sink  gets the file's bytes in order. @param library  what wrote it
  McapWriter(Sink sink, std::string_view library);

  /// @return  its id, from 1
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);
  /// @param schema  of add_schema(); 0: none. @return  its id, from 0
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                            const McapPairs& metadata = {});
  /// Numbered within its channel from 0.
  /// @param time  ns since 1970, of log and publication
  /// @return  false where the file holds as many chunks as it may; the message is not in it
  bool add_message(std::uint16_t channel, std::uint64_t time, std::string_view data);
  void add_metadata(std::string_view name, const McapPairs& pairs);
  /// What has been added so far leaves for the sink.
  void end_chunk();
  /// Index and footer; nothing may be added behind it.
  void finish();

  std::uint64_t messages() const { return messages_; }

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Schema {
    std::string name;
    std::string encoding;
    std::string data;
  };
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic;
    std::string encoding;
    McapPairs metadata;
    std::uint32_t sequence = 0;  ///< of its next message
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  ///< of the chunk: time, offset
  };
  struct ChunkIndex {
    std::uint64_t first = 0;  ///< ns
    std::uint64_t last = 0;   ///< ns
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
    std::vector<std::pair<std::uint16_t, std::uint64_t>> message_indexes;
    std::uint64_t message_index_length = 0;
    std::uint64_t size = 0;
  };
  struct MetadataIndex {
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
    std::string name;
  };

  void put(std::span<const std::uint8_t> bytes);
  static void encode(Bytes& out, std::uint16_t id, const Schema& schema);
  static void encode(Bytes& out, std::uint16_t id, const Channel& channel);
  static void encode(Bytes& out, const ChunkIndex& chunk);
  void encode_statistics(Bytes& out) const;
  void write_message_indexes(ChunkIndex& chunk);

  Sink sink_;
  std::uint64_t written_ = 0;
  std::uint32_t crc_ = 0;  ///< of all that was written
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<ChunkIndex> chunks_;
  std::vector<MetadataIndex> metadata_;
  Bytes chunk_;
  std::uint64_t chunk_first_ = 0;
  std::uint64_t chunk_last_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t first_ = 0;
  std::uint64_t last_ = 0;
};

}  // namespace sinew::runtime

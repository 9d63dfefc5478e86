#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/runtime/records/mcap_writer.h"

namespace sinew::runtime {

struct McapSchema {
  std::string name;
  std::string encoding;
  std::string data;
};

struct McapChannel {
  std::uint16_t schema = 0;
  std::string topic;
  std::string encoding;
  McapPairs metadata;
};

struct McapMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t time = 0;  ///< ns since 1970, of the log
  std::string_view data;   ///< in the file's bytes
};

/// Why a file is not whole.
struct McapTrouble {
  std::size_t offset = 0;  ///< of the record that is wrong
  std::string sentence;
  bool cut = false;  ///< the file ends too early; else something in it is wrong
};

/// What is in a file, up to the first trouble.
struct McapContent {
  std::string library;
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;
  std::vector<McapMessage> messages;
  std::map<std::string, McapPairs> metadata;
  std::optional<McapTrouble> trouble;
};

/// Reads files as McapWriter makes them, whatever bytes it is given: magic, order, lengths, ids,
/// every checksum and index, and the summary against the data. Of a file that was cut, everything
/// in front of the cut is there, also of a chunk that is not whole. Compressed chunks and
/// attachments are refused: Sinew writes none.
/// @param file  outlives the content
McapContent read_mcap(std::span<const std::uint8_t> file);

/// s from the first message of a whole file to its last, by the end of the file alone; nothing
/// where it was cut, or has no message.
/// @param part  of the file: `size` bytes from `offset` on, or fewer
std::optional<double> mcap_length(
    std::uint64_t file_size,
    const std::function<std::string(std::uint64_t offset, std::size_t size)>& part);

/// s; times of a file are ns without a sign.
inline double seconds_between(std::uint64_t from, std::uint64_t to) {
  return to >= from ? static_cast<double>(to - from) * 1e-9
                    : -static_cast<double>(from - to) * 1e-9;
}

}  // namespace sinew::runtime

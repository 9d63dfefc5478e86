#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// What a cell's event log keeps beyond its process: a line of JSON each. What a fault was is still
/// told to whoever comes in the morning, also behind a pulled plug.
class EventFile {
 public:
  /// It is cut back to the last EventLog::kMax events where it is larger.
  static constexpr std::uint64_t kSizeMax = std::uint64_t{4} << 20;

  struct Opened;
  /// What is there is read; lines that are no events (half of one, behind a pulled plug) are left
  /// out. The folder is made where it is missing.
  /// @error  a sentence: it cannot be read or written, or another process has it
  static io::IoResult<Opened> open(const std::string& path);

  /// Each without its line feed. What a full disk does not take is missing there, no more; it is
  /// tried again with the next ones.
  void add(const std::vector<std::string>& lines);

 private:
  EventFile(io::DiskFolder folder, std::string path, io::LineFile file, std::uint64_t size)
      : folder_(std::move(folder)), path_(std::move(path)), file_(std::move(file)), size_(size) {}
  io::DiskFolder folder_;  ///< has its lock
  std::string path_;
  io::LineFile file_;
  std::uint64_t size_;
};

struct EventFile::Opened {
  EventFile file;
  std::vector<Json> events;  ///< the last ones, oldest first
};

}  // namespace sinew::server

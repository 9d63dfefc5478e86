#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/io/io_error.h"

namespace sinew::runtime {

/// A record in a cell's folder, by its name and its end: nothing between is read.
struct KeptRecord {
  std::string name;   ///< "learm_pick_20261122T004512.345Z.mcap"
  std::string robot;  ///< in the cell
  std::string title;  ///< what stands between robot and time
  bool fault = false;
  std::optional<std::int64_t> began_ms;  ///< since 1970, as the name says
  std::optional<double> length;          ///< s; nothing where it has no end (yet)
  std::uint64_t size = 0;                ///< bytes
};

/// The records of a cell: those of faults, and those that somebody wanted. For one thread.
class KeptRecords {
 public:
  /// One that somebody wants ends there: some seventeen minutes of a five-joint arm.
  static constexpr std::uint64_t kSizeMax = std::uint64_t{128} << 20;
  /// Of all records together; no other one is begun then.
  static constexpr std::uint64_t kAllMax = std::uint64_t{1} << 30;
  static constexpr std::size_t kFilesMax = 200;

  explicit KeptRecords(std::string folder) : folder_(std::move(folder)) {}

  /// The newest first.
  io::IoResult<std::vector<KeptRecord>> list();
  /// @error  a sentence: so many, or such large ones, are there that another one may not begin
  io::IoResult<void> check_room();
  /// @param name  is_record_name() holds
  io::IoResult<void> remove(const std::string& name);
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  const std::string& folder() const { return folder_; }

 private:
  struct Known {
    std::int64_t changed_ns = 0;
    std::optional<double> length;
  };
  std::string folder_;
  std::map<std::string, Known> known_;
};

/// "NAME.mcap" of letters, digits, -, _ and . only, no dot first: never a way out of its folder.
bool is_record_name(std::string_view name);

}  // namespace sinew::runtime

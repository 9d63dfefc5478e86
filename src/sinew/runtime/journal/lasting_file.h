#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>

#include "sinew/io/locked_file.h"
#include "sinew/sim/machine.h"

namespace sinew::runtime {

/// What a simulated machine keeps over a loss of power, in a file: `sinew sim --state FILE`.
///
/// Two slots are written in turn, each a line of text with its checksum, so a process that is
/// killed while it writes leaves the slot before. Killed processes lose nothing that was written;
/// a computer that crashes may, and the file is then an older one or refused as damaged.
class LastingFile {
 public:
  /// @param seed  of the machine that begins with this file; the file's own counts afterwards
  /// @error  a sentence: in use, damaged, another robot's, another seed's, or what the disk refused
  static std::expected<LastingFile, std::string> open(const std::string& path,
                                                      const std::string& robot,
                                                      std::optional<std::uint64_t> seed);

  /// As the process before left the machine; nothing in a new file.
  const std::optional<sim::LastingState>& before() const { return before_; }
  std::uint64_t seed() const { return seed_; }

  /// Writes what has changed since the last call.
  /// @error  the disk's; the file is older than the machine from then on
  io::IoResult<void> keep(const sim::Machine& machine);
  /// The same, and waits for the disk.
  io::IoResult<void> finish(const sim::Machine& machine);

 private:
  LastingFile(io::LockedFile file, std::string robot)
      : file_(std::move(file)), robot_(std::move(robot)) {}

  io::LockedFile file_;
  std::string robot_;
  std::uint64_t seed_ = 1;
  std::uint64_t number_ = 0;  ///< of the line written last; its last bit is its slot
  std::optional<sim::LastingState> before_;
  std::optional<sim::LastingState> kept_;
};

}  // namespace sinew::runtime

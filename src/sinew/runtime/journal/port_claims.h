#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/disk.h"

namespace sinew::runtime {

/// Which position journal followed the machine behind a port last: a small file beside the journals
/// for each name that the port has (io::port_identities) and each robot. One machine that is known
/// by two journals would be described by the older one as it was once.
class PortClaims {
 public:
  /// @param disk  the folder of the journals; outlives this. @param robot  its id
  PortClaims(Disk& disk, std::vector<std::string> names, std::string robot)
      : disk_(disk), names_(std::move(names)), robot_(std::move(robot)) {}

  /// The journals on record for any of the names, each once, sorted; "" stands for a run without a
  /// journal that moved the machine, and for a file that cannot be read.
  std::vector<std::string> owners();
  /// On disk when this returns. Where none of the names was this journal's it follows another
  /// machine from now on, and says nothing any more of those that it followed before.
  DiskResult<void> claim(std::string_view journal);
  /// A run without a journal begins to move the machine. Where no journal is on record nothing is
  /// written. On disk when this returns.
  DiskResult<void> release();

 private:
  std::string file_of(const std::string& name) const;
  /// Nothing where no journal is on record.
  std::vector<std::string> owner_of(const std::string& name);
  DiskResult<void> write(const std::string& name, std::string_view journal);
  DiskResult<void> let_go_of_others(std::string_view journal);

  Disk& disk_;
  std::vector<std::string> names_;
  std::string robot_;
};

}  // namespace sinew::runtime

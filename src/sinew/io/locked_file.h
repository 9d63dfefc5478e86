#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "sinew/io/io_error.h"

namespace sinew::io {

/// A plain file of fixed size that one process at a time writes in place. The system releases the
/// lock when the process dies, and keeps what was written until then.
class LockedFile {
 public:
  /// Makes the file, filled with zeros, where it is not there or empty; its room on the disk is
  /// taken at once, so that later writes do not run into a full disk.
  /// @error  in use by another process, no plain file, of another size, no permission, a full disk
  static IoResult<LockedFile> open(const std::string& path, std::size_t size);
  LockedFile(LockedFile&& other) noexcept
      : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}
  LockedFile& operator=(LockedFile&&) = delete;
  ~LockedFile();

  /// @error  fewer bytes are there, or the disk's
  IoResult<void> read(std::size_t offset, std::span<char> out) const;
  IoResult<void> write(std::size_t offset, std::string_view text);
  /// Waits until the disk has it.
  IoResult<void> sync();
  const std::string& path() const { return path_; }

 private:
  LockedFile(std::string path, int file) : path_(std::move(path)), file_(file) {}
  std::string path_;
  int file_;
};

}  // namespace sinew::io

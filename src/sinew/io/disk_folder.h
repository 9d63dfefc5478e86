#pragma once

#include <string>

#include "sinew/core/disk.h"
#include "sinew/io/io_error.h"

namespace sinew::io {

/// A real folder. Files are synced with fdatasync(); the lock is
/// flock(), which the system lets go of when the process dies, on a file that holds the process's
/// number for people and stays behind without meaning.
class DiskFolder final : public Disk {
 public:
  /// Makes the folder, and those above it, where they are not there; they are synced.
  /// @error a file of that name, no permission
  static IoResult<DiskFolder> open_folder(const std::string& path);
  DiskFolder(DiskFolder&& other) noexcept;
  DiskFolder& operator=(DiskFolder&&) = delete;
  ~DiskFolder() override;

  DiskResult<DiskFile> create(std::string_view name) override;
  DiskResult<DiskFile> open(std::string_view name) override;
  void close(DiskFile file) override;
  DiskResult<void> write(DiskFile file, std::uint64_t at,
                         std::span<const std::uint8_t> bytes) override;
  DiskResult<void> append(DiskFile file, std::span<const std::uint8_t> bytes) override;
  DiskResult<void> sync(DiskFile file) override;
  DiskResult<std::size_t> read(std::string_view name, std::span<std::uint8_t> out) override;
  DiskResult<DiskStamp> stamp(std::string_view name) override;
  DiskResult<void> rename(std::string_view from, std::string_view to) override;
  DiskResult<void> remove(std::string_view name) override;
  DiskResult<std::vector<std::string>> list() override;
  DiskResult<void> sync_folder() override;
  DiskResult<void> lock(std::string_view name) override;

  const std::string& path() const { return path_; }

 private:
  DiskFolder(std::string path, int folder) : path_(std::move(path)), folder_(folder) {}
  DiskResult<DiskFile> open_with(std::string_view name, int flags) const;

  std::string path_;
  int folder_ = -1;
  int lock_ = -1;
};

/// "PATH/NAME: no space left on device", "...: in use by process 4711".
IoError disk_error(const std::string& subject, const DiskError& error);

}  // namespace sinew::io

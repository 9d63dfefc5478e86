#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew {

/// Why a disk did not do what it was asked.
enum class DiskErrorCode : std::uint8_t {
  kFull,      ///< no room; part of the bytes may stand there
  kDenied,    ///< no permission, or a disk that can only be read
  kMissing,   ///< no such file or folder
  kLocked,    ///< number: the process that holds the lock, 0 where it does not say
  kTooLarge,  ///< more bytes, files or letters than this interface carries
  kFailed,    ///< number: the system's error number
};

struct DiskError {
  DiskErrorCode code = DiskErrorCode::kFailed;
  std::int32_t number = 0;
  friend bool operator==(const DiskError&, const DiskError&) = default;
};

template <class T>
using DiskResult = std::expected<T, DiskError>;

/// What a file system tells of a file beside its bytes.
struct DiskStamp {
  std::uint64_t identity = 0;   ///< another file of the same name has another one; 0: nobody knows
  std::int64_t changed_ns = 0;  ///< wall time of the last change of any kind, since 1970
  std::uint64_t size = 0;       ///< bytes
};

/// An open file. It does not close itself: Disk::close() does.
struct DiskFile {
  std::int32_t id = -1;
};

/// One folder of files, as much as a journal needs of it: the real one is io::DiskFolder, the one
/// that loses power sim::Disk. Calls may block as long as a disk takes; nothing throws. What was
/// written is safe once sync() of the file succeeded, a name once sync_folder() did. After a sync
/// that failed nobody knows which bytes are safe. Used by one thread.
class Disk {
 public:
  static constexpr std::size_t kNameMax = 100;    ///< bytes of a name; no '/' in it
  static constexpr std::size_t kFilesMax = 1000;  ///< of list()

  virtual ~Disk() = default;

  /// An empty file of this name, instead of one that stands there.
  virtual DiskResult<DiskFile> create(std::string_view name) = 0;
  /// @error kMissing
  virtual DiskResult<DiskFile> open(std::string_view name) = 0;
  virtual void close(DiskFile file) = 0;
  /// From byte `at` on, also over what stands there; zeros between the end and `at`. All bytes, or
  /// an error and any number of them.
  virtual DiskResult<void> write(DiskFile file, std::uint64_t at,
                                 std::span<const std::uint8_t> bytes) = 0;
  /// The same at the end of the file.
  virtual DiskResult<void> append(DiskFile file, std::span<const std::uint8_t> bytes) = 0;
  virtual DiskResult<void> sync(DiskFile file) = 0;

  /// The whole file; how many bytes it has. @error kMissing, kTooLarge (than `out`)
  virtual DiskResult<std::size_t> read(std::string_view name, std::span<std::uint8_t> out) = 0;
  virtual DiskResult<DiskStamp> stamp(std::string_view name) = 0;
  /// Replaces `to`, at once and whole.
  virtual DiskResult<void> rename(std::string_view from, std::string_view to) = 0;
  virtual DiskResult<void> remove(std::string_view name) = 0;
  /// Sorted. @error kTooLarge
  virtual DiskResult<std::vector<std::string>> list() = 0;
  virtual DiskResult<void> sync_folder() = 0;

  /// Only one process, and one Disk in it, has this lock; it ends with the Disk and with the
  /// process, however that dies. @error kLocked
  virtual DiskResult<void> lock(std::string_view name) = 0;
};

}  // namespace sinew

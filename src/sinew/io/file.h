#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"
#include "sinew/io/locked_file.h"

namespace sinew::io {

/// A whole file as text; a pipe is read to its end.
/// @error not there, no permission, a folder or a device, an empty pipe, over `size_max` bytes
IoResult<std::string> read_file(const std::string& path, std::size_t size_max = 1U << 20);

/// As much of a file as there is from this byte on, `size` bytes at most; nothing behind its end.
/// @error  not there, no permission, no plain file
IoResult<std::string> read_part(const std::string& path, std::uint64_t offset, std::size_t size);

/// Writes the file beside its place, syncs it, and moves it there: whoever reads sees the old or
/// the new text, never half of one. A link's target is replaced, not the link. What is no file (a
/// pipe, /dev/null) is written to as it stands.
IoResult<void> replace_file(const std::string& path, std::string_view text);

/// Whether a file could be written there, without doing it: what would be a pity to learn at the
/// end of a long run. @error a folder, no permission, no such folder above it
IoResult<void> check_place(const std::string& path);

/// One at a time: while it lives nobody else has the turn at the files of that folder, in this
/// process or another. For what reads a file, changes it and puts it back. It ends with the
/// process.
class FolderTurn {
 public:
  /// @param path  of a file in the folder; it need not be there
  /// @error  no such folder, or somebody had the turn for all of `patience`
  static IoResult<FolderTurn> take(const std::string& path, Duration patience);
  FolderTurn(FolderTurn&& other) noexcept : folder_(std::exchange(other.folder_, -1)) {}
  FolderTurn& operator=(FolderTurn&&) = delete;
  ~FolderTurn();

 private:
  explicit FolderTurn(int folder) : folder_(folder) {}
  int folder_;
};

/// Bytes of a plain file. @error  as read_part
IoResult<std::uint64_t> file_size(const std::string& path);
/// Whether anything has this name; also what cannot be read.
bool exists(const std::string& path);
/// A file that would be gone if another were put in its place: no pipe, no device.
bool is_file(const std::string& path);

/// Both names lead to one file or device, through links too; also where it is not there yet.
bool same_file(const std::string& a, const std::string& b);

/// Where this user's programs put their sockets: $XDG_RUNTIME_DIR, else /tmp.
std::string runtime_folder();
/// A number that no other process has now.
int process_id();

/// A text file that grows line by line; each line is out as soon as it is added.
class LineFile {
 public:
  static IoResult<LineFile> create(const std::string& path);
  /// Behind what is there.
  static IoResult<LineFile> append(const std::string& path);
  void add(std::string_view line);
  /// Why a line could not be written (a full disk); those behind it are missing too.
  const std::optional<IoError>& failure() const { return failure_; }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  static IoResult<LineFile> open(const std::string& path, const char* mode);
  LineFile(std::FILE* file, std::string path) : file_(file), path_(std::move(path)) {}
  std::unique_ptr<std::FILE, Closer> file_;
  std::string path_;
  std::optional<IoError> failure_;
};

/// A symbolic link that lives as long as this object, with PATH.lock beside it: the link of a run
/// that was killed may point at a port that another program has by now, and only the lock tells.
class ScopedLink {
 public:
  /// Replaces an existing link that dangles, says the same already or was left by a run that
  /// was killed, but nothing else.
  static IoResult<ScopedLink> create(const std::string& target, const std::string& path);
  ScopedLink(ScopedLink&&) noexcept;
  ScopedLink& operator=(ScopedLink&&) = delete;
  ~ScopedLink();

 private:
  ScopedLink(std::string target, std::string path, LockedFile lock)
      : target_(std::move(target)), path_(std::move(path)), lock_(std::move(lock)) {}
  std::string target_;
  std::string path_;
  LockedFile lock_;
};

}  // namespace sinew::io

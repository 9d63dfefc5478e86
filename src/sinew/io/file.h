#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "sinew/io/io_error.h"

namespace sinew::io {

/// A whole file as text. @error not there, no permission, a folder, over `size_max` bytes
IoResult<std::string> read_file(const std::string& path, std::size_t size_max = 1U << 20);

/// Writes the file beside its place, syncs it, and moves it there: whoever reads sees the old or
/// the new text, never half of one.
IoResult<void> replace_file(const std::string& path, std::string_view text);

/// A text file that grows line by line; each line is out as soon as it is added.
class LineFile {
 public:
  static IoResult<LineFile> create(const std::string& path);
  void add(std::string_view line);

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  explicit LineFile(std::FILE* file) : file_(file) {}
  std::unique_ptr<std::FILE, Closer> file_;
};

/// A symbolic link that lives as long as this object.
class ScopedLink {
 public:
  /// Replaces a dangling link that stands there (a run before this one may have been killed), but
  /// nothing else.
  static IoResult<ScopedLink> create(const std::string& target, const std::string& path);
  ScopedLink(ScopedLink&&) noexcept;
  ScopedLink& operator=(ScopedLink&&) = delete;
  ~ScopedLink();

 private:
  ScopedLink(std::string target, std::string path)
      : target_(std::move(target)), path_(std::move(path)) {}
  std::string target_;
  std::string path_;
};

}  // namespace sinew::io

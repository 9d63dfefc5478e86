#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::house {

/// One file of the house; `path` is relative to the repository's root, with '/'.
struct SourceFile {
  std::string path;
  std::string text;
};

/// Every .h, .cc and .c below the named folders of `root`, sorted by path. A folder that does not
/// exist yet holds no files.
std::vector<SourceFile> read_tree(const std::filesystem::path& root,
                                  std::span<const std::string_view> folders);

/// `text` with comments blanked out: same length, same lines.
std::string without_comments(std::string_view text);

/// As above, with string and character literals blanked out too.
std::string code_only(std::string_view text);

/// One #include, with the line it stands on, counted from 1.
struct Include {
  std::size_t line = 0;
  std::string name;
  bool quoted = false;
};

/// Those that stand in comments do not count.
std::vector<Include> includes_of(std::string_view text);

/// `text` cut at every newline.
std::vector<std::string_view> lines_of(std::string_view text);

}  // namespace sinew::house

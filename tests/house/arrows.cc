#include "house/arrows.h"

#include <algorithm>
#include <regex>
#include <set>

namespace sinew::house {
namespace {

constexpr std::string_view kRoot = "src/sinew/";

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (end > 0) words.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

bool lists(std::string_view words, std::string_view word) {
  const std::vector<std::string_view> all = words_of(words);
  return std::ranges::find(all, word) != all.end();
}

/// A folder is as pure as the area that it belongs to.
bool is_pure(std::string_view folder) {
  return lists(kPureFolders, folder.substr(0, folder.find('/')));
}

const FolderArrows* row_of(std::string_view folder) {
  const auto* row = std::ranges::find(kArrows, folder, &FolderArrows::folder);
  return row == kArrows.end() ? nullptr : row;
}

/// The folder whose arrows a file has; "devices" for one of a device that has no role.
/// @param path  below src/sinew
std::string_view arrows_of(std::string_view path) {
  constexpr std::string_view kDevices = "devices";
  const std::size_t slash = path.rfind('/');
  if (slash == std::string_view::npos) return {};
  const std::string_view folder = path.substr(0, slash);
  if (folder.substr(0, folder.find('/')) != kDevices) return folder;
  std::string_view name = path.substr(slash + 1);
  name = name.substr(0, name.rfind('.'));
  while (!name.empty()) {
    const std::size_t end = std::min(name.find('_'), name.size());
    const auto* role = std::ranges::find(kFileRoles, name.substr(0, end), &FileRole::word);
    if (role != kFileRoles.end()) return role->folder;
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return kDevices;
}

/// The folder of src/sinew whose arrows `path` has; empty outside of it.
std::string_view folder_of(std::string_view path) {
  if (!path.starts_with(kRoot)) return {};
  return arrows_of(path.substr(kRoot.size()));
}

/// Unit tests and the headers that only they may include: x_test.cc, x_test_robot.h.
bool is_for_tests(std::string_view path) {
  path.remove_prefix(path.rfind('/') + 1);
  return path.ends_with("_test.cc") || (path.ends_with(".h") && path.contains("_test"));
}

std::string at(const SourceFile& file, std::size_t line) {
  return file.path + ":" + std::to_string(line) + ": ";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "nothing" : text;
}

bool matches(std::string_view header, std::string_view pattern) {
  return pattern.ends_with('/') ? header.starts_with(pattern) : header == pattern;
}

/// What is wrong with this include as an arrow; empty where nothing is.
std::string arrow_fault(std::string_view folder, const Include& include) {
  constexpr std::string_view kPrefix = "sinew/";
  if (!include.name.starts_with(kPrefix)) {
    return include.quoted ? R"(: in quotes only "sinew/..." may stand here)" : "";
  }
  const std::string_view rest = std::string_view(include.name).substr(kPrefix.size());
  const std::string_view target = arrows_of(rest);
  if (is_for_tests(include.name)) return ": that header is for tests only";
  if (row_of(target) == nullptr) return ": no folder of that name has arrows";
  if (target == folder) return {};
  const std::vector<std::string> allowed = reachable_from(folder);
  if (std::ranges::find(allowed, target) != allowed.end()) return {};
  return "; " + std::string(folder) + " may include " + joined(allowed);
}

}  // namespace

std::vector<std::string> reachable_from(std::string_view folder) {
  std::set<std::string> reached;
  std::vector<std::string_view> to_visit{folder};
  while (!to_visit.empty()) {
    const FolderArrows* row = row_of(to_visit.back());
    to_visit.pop_back();
    if (row == nullptr) continue;
    for (const std::string_view next : words_of(row->points_at)) {
      if (reached.emplace(next).second) to_visit.push_back(next);
    }
  }
  if (row_of(folder) != nullptr) reached.emplace("core");
  reached.erase(std::string(folder));
  return {reached.begin(), reached.end()};
}

std::vector<std::string> check_arrows(std::span<const SourceFile> files) {
  std::vector<std::string> complaints;
  for (const SourceFile& file : files) {
    const std::string_view folder = folder_of(file.path);
    if (folder.empty() || is_for_tests(file.path)) continue;
    if (row_of(folder) == nullptr) {
      complaints.push_back(at(file, 1) + "folder " + std::string(folder) + " has no arrows");
      continue;
    }
    for (const Include& include : includes_of(file.text)) {
      const std::string fault = arrow_fault(folder, include);
      if (fault.empty()) continue;
      complaints.push_back(at(file, include.line) + "includes " + include.name + fault);
    }
  }
  return complaints;
}

std::vector<std::string> check_guarded_headers(std::span<const SourceFile> files) {
  std::vector<std::string> complaints;
  for (const SourceFile& file : files) {
    const std::string_view folder = folder_of(file.path);
    if (folder.empty() || is_for_tests(file.path)) continue;
    for (const Include& include : includes_of(file.text)) {
      const std::string where = at(file, include.line) + "includes " + include.name;
      for (const GuardedHeaders& guarded : kGuardedHeaders) {
        const bool is_guarded = std::ranges::any_of(
            words_of(guarded.headers),
            [&](std::string_view header) { return matches(include.name, header); });
        if (is_guarded && !lists(guarded.folders, folder)) {
          complaints.push_back(where + "; only " + std::string(guarded.folders) + " may");
        }
      }
      if (is_pure(folder) && lists(kNotInPureFolders, include.name)) {
        complaints.push_back(where + "; " + std::string(folder) +
                             " sees no clock, file, stream or thread");
      }
    }
  }
  return complaints;
}

std::vector<std::string> check_clocks_and_sleeps(std::span<const SourceFile> files) {
  static const std::regex kSleep(R"(\b(sleep|usleep|nanosleep|sleep_for|sleep_until)\s*\()");
  static const std::regex kClock(
      R"((\w+_clock\s*::\s*now\b)|(\b(clock_gettime|gettimeofday)\s*\()|(\bstd::time\s*\())");
  static const std::regex kSeedless(R"(\brandom_device\b|\bstd::rand\b|\bsrand\s*\()");
  std::vector<std::string> complaints;
  for (const SourceFile& file : files) {
    const bool pure = is_pure(folder_of(file.path));
    const bool test = is_for_tests(file.path) || file.path.starts_with("tests/");
    const std::string code = code_only(file.text);
    std::size_t number = 0;
    for (const std::string_view line : lines_of(code)) {
      ++number;
      const auto complain_if = [&](bool applies, const std::regex& token, const char* why) {
        std::cmatch match;
        if (!applies || !std::regex_search(line.begin(), line.end(), match, token)) return;
        complaints.push_back(at(file, number) + "uses " + match.str() + why);
      };
      complain_if(pure, kClock, ": time is handed in as an Instant");
      complain_if(pure || test, kSleep, ": nothing waits here, time is virtual");
      complain_if(true, kSeedless, ": randomness has a printed seed");
    }
  }
  return complaints;
}

}  // namespace sinew::house

#pragma once

#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sinew/core/vec3.h"
#include "sinew/toml/dimension.h"
#include "sinew/toml/findings.h"
#include "sinew/toml/toml_tree.h"

namespace sinew {

enum class Presence : bool { kRequired, kOptional };

/// One spelling of an enumeration.
template <class T>
struct Named {
  std::string_view name;
  T value;
};

/// Reads one table of a file strictly: every key must be asked for, every value must have its type
/// and range, every table with numbers must say where they come from.
///
/// A `pattern` is a key with '*' where its unit stands: "d_*", "velocity_*_max". Every reading
/// function returns whether it has written its last argument; what was wrong has been complained
/// about by then. Keys that were not asked for come to light in `finish`, which closes a table.
class TableReader {
 public:
  /// @param path  dotted path for complaints, empty for the root
  TableReader(const TomlTable& table, Place place, std::string path, Findings& findings)
      : table_(&table), place_(place), path_(std::move(path)), findings_(&findings) {}

  /// What is asked for next may be left out.
  TableReader& optional() {
    next_ = Presence::kOptional;
    return *this;
  }
  /// Numbers that whoever wrote the file chose come from nowhere else.
  void needs_no_source() { source_excused_ = true; }
  /// Tells where a number comes from that this table leaves out. @param key  as it is called
  void note_assumed(std::string_view key, std::string source);
  /// A `source` of this table counts for every table of the file that has none of its own.
  void source_of_all();

  /// A number with a unit; integers are numbers too. `out` and `range` in SI.
  bool quantity(std::string_view pattern, Dimension dimension, const Range& range, double& out);
  /// Three of them in a list.
  bool vector(std::string_view pattern, Dimension dimension, const Range& range, Vec3& out);
  /// A direction; `out` has length 1.
  bool direction(std::string_view key, Vec3& out);
  /// A number that has no unit.
  bool number(std::string_view key, const Range& range, double& out);
  template <class Integer>
  bool integer(std::string_view key, std::int64_t lower, std::int64_t upper, Integer& out) {
    std::int64_t value = 0;
    if (!whole_number(key, lower, upper, value)) return false;
    out = static_cast<Integer>(value);
    return true;
  }
  bool boolean(std::string_view key, bool& out);
  /// Not blank, no control characters, at most `max_bytes` long.
  bool text(std::string_view key, std::size_t max_bytes, std::string& out);
  /// A list of such texts, at least one.
  bool texts(std::string_view key, std::size_t max_bytes, std::vector<std::string>& out);
  /// @param names  Named<T>, as many as there are
  template <class T, class Names>
  bool choice(std::string_view key, const Names& names, T& out) {
    std::vector<std::string_view> words;
    for (const Named<T>& one : names) words.push_back(one.name);
    std::size_t index = 0;
    if (!one_of(key, words, index)) return false;
    out = names[index].value;
    return true;
  }

  std::optional<TableReader> table(std::string_view key, Presence presence = Presence::kRequired);
  /// An array of tables, all of them; their paths are key[1], key[2] ...
  std::vector<TableReader> tables(std::string_view key, Presence presence = Presence::kRequired);

  /// One table, or an array of them; none where the key is not there.
  std::vector<TableReader> table_or_tables(std::string_view key);

  /// Complains at the value of a key that was asked for, or at the table if it is not there.
  void complain(std::string_view pattern, std::string message);
  /// Complains at the table itself.
  void complain(std::string message);

  /// No complaint about keys that were not asked for, unless they are misspelt ones that were:
  /// something is wrong that decides which keys belong here.
  void ignore_rest() { ignore_rest_ = true; }
  /// Nothing in the whole file has been complained about so far.
  bool clean() const { return findings_->clean(); }

  /// Gives the table a name that people know, "joint.elbow" for "joint[3]".
  void rename(std::string path) { path_ = std::move(path); }
  /// Complains about keys nobody asked for, keys that are missing and constants without a source.
  void finish();

 private:
  struct Asked {
    std::string pattern;
    std::vector<std::string> spellings;
    const TomlEntry* entry = nullptr;
    bool required = true;
    bool constant = false;
    bool excused = false;  ///< missing, but a complaint tells why already
  };

  const TomlEntry* ask(std::string_view pattern, Dimension dimension, Presence presence,
                       bool constant);
  bool real(const TomlNode& node, const std::string& key, const Unit& unit, const Range& range,
            double& out);
  bool three(std::string_view pattern, const TomlEntry* entry, const Unit& unit, const Range& range,
             Vec3& out);
  bool whole_number(std::string_view key, std::int64_t lower, std::int64_t upper,
                    std::int64_t& out);
  bool one_of(std::string_view key, std::span<const std::string_view> words, std::size_t& index);
  /// What a key holds that has no unit; null where it holds something else.
  template <class T>
  const T* value_of(std::string_view key, std::string_view wanted);
  void wrong_type(const TomlNode& node, const std::string& key, std::string_view wanted);
  void check_unknown(const TomlEntry& entry);
  bool is_missing(std::string_view spelling) const;
  void check_sources();
  void note_source(const TomlEntry& entry, const std::string& source);
  void check_source_table(const TomlEntry& source, const TomlTable& sources);
  std::string dotted(std::string_view key) const;
  std::vector<const TomlEntry*> constants() const;

  const TomlTable* table_;
  Place place_;
  std::string path_;
  Findings* findings_;
  std::vector<Asked> asked_;
  bool ignore_rest_ = false;
  Presence next_ = Presence::kRequired;
  bool source_excused_ = false;  ///< `source` is missing and that has a reason
};

/// "`d_mm`, `d_m` or `d_in`"
std::string any_of_text(std::span<const std::string_view> words);

/// What `read` makes of the root table of a file.
/// @error  all complaints, with line and column
template <class Read>
std::expected<std::invoke_result_t<const Read&, TableReader&>, std::vector<Complaint>>
read_toml_file(std::string_view toml, std::string_view file_name, const Read& read) {
  const auto tree = parse_toml_file(toml, file_name);
  if (!tree) return std::unexpected(tree.error());
  Findings findings{std::string(file_name)};
  TableReader root(*tree, Place{}, "", findings);
  auto value = read(root);
  if (!findings.clean()) return std::unexpected(findings.take_complaints());
  return value;
}

}  // namespace sinew

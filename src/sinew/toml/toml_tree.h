#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/toml/findings.h"

namespace sinew {

struct TomlNode;
struct TomlEntry;
using TomlArray = std::vector<TomlNode>;
using TomlTable = std::vector<TomlEntry>;  ///< in the order of the file, keys unique

/// A date or a time: valid TOML that no file of Sinew has a use for.
struct TomlDate {};

struct TomlNode {
  Place place;
  std::variant<TomlDate, bool, std::int64_t, double, std::string, TomlArray, TomlTable> value;
};

struct TomlEntry {
  std::string key;
  Place place;  ///< of the key; the value's stands in the node
  TomlNode node;
};

/// Text -> tree; the only door to the TOML library.
///
/// @error  a Complaint without file and key: unfit for the parser (toml_guard.h), not TOML 1.0, or
///         values nested deeper than 8.
std::expected<TomlTable, Complaint> parse_toml(std::string_view text);

/// The same of a file. @error  with the file's name, as complaints shall show it
std::expected<TomlTable, std::vector<Complaint>> parse_toml_file(std::string_view text,
                                                                 std::string_view file_name);

/// "a string", "a table": for sentences.
std::string_view type_name(const TomlNode& node);

}  // namespace sinew

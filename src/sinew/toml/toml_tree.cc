#include "sinew/toml/toml_tree.h"

#include <algorithm>
#include <utility>

#include "sinew/toml/toml_guard.h"

// No other file may include the library, so these settings hold for the whole program.
//
// The parser asserts things about its input that are not so ("[.a]" ends the program; with NDEBUG
// the compiler is even promised that they are), and then checks them and reports an error. Without
// the assertions only the reports are left.
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#define TOML_MAX_NESTED_VALUES 8
#include <toml++/toml.h>

namespace sinew {
namespace {

Place place_of(const toml::source_region& region) {
  return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

TomlNode convert(const toml::node& node);

TomlTable convert(const toml::table& table) {
  TomlTable entries;
  for (const auto& [key, node] : table) {
    entries.push_back({std::string(key.str()), place_of(key.source()), convert(node)});
  }
  std::ranges::sort(entries, {}, &TomlEntry::place);  // the library sorts by name
  return entries;
}

TomlNode convert(const toml::node& node) {
  TomlNode result{place_of(node.source()), TomlDate{}};
  if (const auto* table = node.as_table()) {
    result.value = convert(*table);
  } else if (const auto* array = node.as_array()) {
    TomlArray items;
    for (const toml::node& item : *array) items.push_back(convert(item));
    result.value = std::move(items);
  } else if (const auto* text = node.as_string()) {
    result.value = text->get();
  } else if (const auto* whole = node.as_integer()) {
    result.value = whole->get();
  } else if (const auto* real = node.as_floating_point()) {
    result.value = real->get();
  } else if (const auto* flag = node.as_boolean()) {
    result.value = flag->get();
  }
  return result;
}

}  // namespace

std::expected<TomlTable, Complaint> parse_toml(std::string_view text) {
  if (auto complaint = unfit_for_parser(text)) return std::unexpected(std::move(*complaint));
  const toml::parse_result result = toml::parse(text);
  if (!result) {
    const toml::parse_error& error = result.error();
    const Place place = place_of(error.source());
    return std::unexpected(
        Complaint{{}, place.line, place.column, {}, std::string(error.description())});
  }
  return convert(result.table());
}

std::expected<TomlTable, std::vector<Complaint>> parse_toml_file(std::string_view text,
                                                                 std::string_view file_name) {
  auto tree = parse_toml(text);
  if (tree) return std::move(*tree);
  tree.error().file = file_name;
  return std::unexpected(std::vector{std::move(tree.error())});
}

std::string_view type_name(const TomlNode& node) {
  constexpr std::string_view kNames[] = {"a date or time", "true or false", "a whole number",
                                         "a real number",  "a string",      "a list",
                                         "a table"};
  return kNames[node.value.index()];
}

}  // namespace sinew

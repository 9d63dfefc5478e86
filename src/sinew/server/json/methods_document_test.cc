#include <gtest/gtest.h>

#include "sinew/io/file.h"
#include "sinew/server/json/methods.h"

namespace sinew::server {
namespace {

/// A row of the page's table, as the code has it.
std::string row_of(const Method& method) {
  std::string params;
  for (const Param& param : method.params) {
    params += (params.empty() ? "`" : "; `") + std::string(param.name) +
              (param.required ? "` " : "`? ") + std::string(type_name(param.type)) + ": " +
              std::string(param.meaning);
  }
  return "| `" + std::string(method.name) + "` | " + (method.moves ? "yes" : "") + " | " + params +
         " | " + std::string(method.meaning) + " | " + std::string(method.result) + " |\n";
}

TEST(Methods, the_page_says_what_the_code_does) {
  const auto page = io::read_file(SINEW_API_PAGE);
  ASSERT_TRUE(page) << page.error().sentence;
  std::string table;
  for (const Method& method : methods()) table += row_of(method);
  const std::size_t head = page->find("|---|---|---|---|---|\n");
  ASSERT_NE(head, std::string::npos);
  EXPECT_NE(page->find(table, head), std::string::npos)
      << "docs/api.md should have under its last head:\n"
      << table;
}

}  // namespace
}  // namespace sinew::server

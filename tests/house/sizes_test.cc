#include "house/sizes.h"

#include <gtest/gtest.h>

#include <array>
#include <iostream>

namespace sinew::house {
namespace {

using Complaints = std::vector<std::string>;

constexpr std::array<std::string_view, 5> kSourceFolders{"src", "tests", "fuzz", "bench",
                                                         "firmware"};

std::string repeated(std::size_t times, const std::string& text) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

std::vector<std::string> heads(std::string_view text) {
  std::vector<std::string> found;
  for (const FunctionSize& function : functions_of(text)) found.push_back(function.head);
  return found;
}

TEST(House, files_functions_and_lines_stay_small) {
  const auto files = read_tree(SINEW_SOURCE_DIR, kSourceFolders);
  std::string text;
  for (const std::string& complaint : check_sizes(files)) text += complaint + "\n";
  for (const std::string& complaint : check_modules(files)) text += complaint + "\n";
  EXPECT_EQ(text, "");
  std::cout << "  " << files.size() << " files, median " << median_lines(files) << " lines\n";
}

TEST(Sizes, a_file_may_have_800_lines_and_not_801) {
  EXPECT_EQ(check_sizes(std::vector<SourceFile>{{"a.h", repeated(800, "int x;\n")}}), Complaints{});
  EXPECT_EQ(check_sizes(std::vector<SourceFile>{{"a.h", repeated(801, "int x;\n")}}),
            (Complaints{"a.h:1: lines: the file has 801, limit 800"}));
}

TEST(Sizes, a_module_may_have_6000_lines_without_its_tests_and_not_6001) {
  std::vector<SourceFile> files;
  for (const char* name : {"a.h", "a.cc", "b.cc", "a_test.cc", "a_test_robot.h"}) {
    files.push_back({std::string("src/sinew/room/") + name, repeated(2000, "int x;\n")});
  }
  files.push_back({"src/sinew/room/part/c.cc", repeated(2000, "int x;\n")});
  EXPECT_EQ(check_modules(files), Complaints{});
  files[0].text += "int y;\n";
  EXPECT_EQ(check_modules(files),
            (Complaints{"src/sinew/room: the module has 6001 lines, limit 6000"}));
}

TEST(Sizes, a_line_may_have_100_columns_however_many_bytes) {
  const std::string wide = "// " + repeated(97, "\xC3\xA4") + "\n";
  EXPECT_EQ(check_sizes(std::vector<SourceFile>{{"a.h", wide}}), Complaints{});
  EXPECT_EQ(check_sizes(std::vector<SourceFile>{{"a.h", "\n/" + wide}}),
            (Complaints{"a.h:2: columns: the line has 101, limit 100"}));
}

TEST(Sizes, a_function_may_have_69_lines_and_not_70) {
  const auto function = [](std::size_t lines) {
    return "#define X {\n\nint f(int a,\n      int b) {\n" + repeated(lines - 3, "  ++a;\n") +
           "}\n";
  };
  EXPECT_EQ(check_sizes(std::vector<SourceFile>{{"a.cc", function(69)}}), Complaints{});
  EXPECT_EQ(check_sizes(std::vector<SourceFile>{{"a.cc", function(70)}}),
            (Complaints{"a.cc:3: lines: `int f(int a,       int b) ` has 70, limit 69"}));
}

TEST(Sizes, tables_and_classes_are_no_functions_and_their_methods_are) {
  EXPECT_EQ(heads("constexpr std::array kTable = std::to_array<Row>({\n{1, f(2)},\n});\n"
                  "struct A : B<int> {\n public:\n  int f() const { return 1; }\n"
                  "  std::array<int, 2> x{1, 2};\n};\nenum class E : int { kA, kB };\n"),
            (std::vector<std::string>{"int f() const "}));
}

TEST(Sizes, constructors_operators_templates_and_lambdas_are_found) {
  EXPECT_EQ(heads("namespace a {\nA::A(int x) : x_{x}, y_{f(x)} {\n  g();\n}\n}\n"),
            (std::vector<std::string>{"A::A(int x) : x_{}, y_{} "}));
  EXPECT_EQ(
      heads("bool operator==(A a, A b) { return true; }\n"
            "A& A::operator=(const A& a) { return *this; }\n"),
      (std::vector<std::string>{"bool operator==(A a, A b) ", "A& A::operator=(const A& a) "}));
  EXPECT_EQ(heads("template <class T, int N = 3>\nvoid f(T t) {\n}\n"
                  "const auto g = [](int x) {\n  return x;\n};\n"),
            (std::vector<std::string>{"template <class T, int N = 3> void f(T t) ",
                                      "const auto g = [](int x) "}));
}

TEST(Sizes, braces_in_comments_literals_and_macros_do_not_count) {
  EXPECT_EQ(heads("#define BEGIN {\\\n  {\n// {\n/* { */\nint f() {\n  char c = '{';\n"
                  "  int n = 100'000;\n  auto s = R\"x({)\")x\";\n  return g(\"{\\\"{\");\n}\n"
                  "int h() { return 2; }\n"),
            (std::vector<std::string>{"int f() ", "int h() "}));
}

TEST(Sizes, median_is_the_middle_file) {
  const std::vector<SourceFile> files{{"a", "1\n"}, {"b", "1\n2\n3\n"}, {"c", "1\n2\n"}};
  EXPECT_EQ(median_lines(files), 2U);
  EXPECT_EQ(median_lines({}), 0U);
}

}  // namespace
}  // namespace sinew::house

#include "sinew/server/json/json_rpc.h"

#include <gtest/gtest.h>

#include "sinew/server/json/methods.h"
#include "support/property.h"

namespace sinew::server {
namespace {

int code_of(std::string_view text) {
  const auto request = read_request(text);
  return request ? 0 : static_cast<int>(request.error().error.code);
}

TEST(JsonRpc, a_request_has_its_id_method_and_params) {
  const auto request =
      read_request(R"({"jsonrpc":"2.0","id":7,"method":"robot.stop","params":{"robot":"a"}})");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->id, 7);
  EXPECT_TRUE(request->answered);
  EXPECT_EQ(request->method, "robot.stop");
  EXPECT_EQ(request->params["robot"], "a");
}

TEST(JsonRpc, a_request_without_an_id_wants_no_answer) {
  const auto request = read_request(R"({"jsonrpc":"2.0","method":"lease.renew"})");
  ASSERT_TRUE(request);
  EXPECT_FALSE(request->answered);
  EXPECT_TRUE(request->params.is_object());
}

TEST(JsonRpc, what_is_none_is_refused_with_the_specifications_code) {
  EXPECT_EQ(code_of(""), -32700);
  EXPECT_EQ(code_of("{"), -32700);
  EXPECT_EQ(code_of("nonsense"), -32700);
  EXPECT_EQ(code_of("\xff\xfe{}"), -32700);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"x","params":{"share":1e999}})"), -32700);
  EXPECT_EQ(code_of("[]"), -32600);
  EXPECT_EQ(code_of("3"), -32600);
  EXPECT_EQ(code_of("{}"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"1.0","id":1,"method":"x"})"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":{},"method":"x"})"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":3})"), -32600);
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"x","params":[1]})"), -32602);
  EXPECT_EQ(code_of(std::string(100, '[') + std::string(100, ']')), -32700);
  EXPECT_EQ(code_of("\"" + std::string(kMessageMax, 'x') + "\""), -32700);
}

TEST(JsonRpc, a_refusal_keeps_the_id_that_could_be_read) {
  const auto request = read_request(R"({"jsonrpc":"2.0","id":"k","method":"x","params":7})");
  ASSERT_FALSE(request);
  EXPECT_EQ(request.error().id, "k");
}

TEST(JsonRpc, texts_are_one_line_and_valid_whatever_they_carry) {
  const std::string text = error_text(1, {RpcCode::kRefused, "a\nb\xff", {{"x", "\n"}}});
  EXPECT_EQ(text.find('\n'), std::string::npos);
  EXPECT_FALSE(Json::parse(text, nullptr, false).is_discarded());
}

TEST(Methods, params_that_do_not_fit_are_refused_by_name) {
  const auto sentence = [](const char* method, const char* params) {
    RpcRequest request;
    request.method = method;
    request.params = Json::parse(params);
    const auto checked = check(request);
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_EQ(sentence("robot.stop", "{}"), "");
  EXPECT_EQ(sentence("robot.stop", R"({"robot":"a"})"), "");
  EXPECT_NE(sentence("robot.stopp", "{}").find("did you mean 'robot.stop'?"), std::string::npos);
  EXPECT_NE(sentence("robot.stop", R"({"rowbot":"a"})").find("did you mean 'robot'?"),
            std::string::npos);
  EXPECT_NE(sentence("robot.stop", R"({"robot":3})").find("robot has to be a robot's name"),
            std::string::npos);
  EXPECT_NE(sentence("robot.feed", R"({"robot":"a"})").find("needs 'share'"), std::string::npos);
  EXPECT_NE(sentence("robot.feed", R"({"robot":"a","share":null})").find("has to be a number"),
            std::string::npos);
  EXPECT_NE(
      sentence("robot.jog", R"({"robot":"a","frame":"base","velocity":[1,"x"]})").find("list"),
      std::string::npos);
}

/// One line of a session as an attacker would write it.
std::string hostile(sinew::test::Random& random) {
  std::string text =
      R"({"jsonrpc":"2.0","id":1,"method":"robot.jog","params":{"robot":"a","velocity":[0.1]}})";
  const std::int64_t edits = random.integer(1, 8);
  for (std::int64_t k = 0; k < edits && !text.empty(); ++k) {
    const auto at =
        static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(text.size()) - 1));
    constexpr std::string_view kWords[] = {"null", "1e999", "{",       "[",
                                           "\"",   "-0",    "\\u0000", "true"};
    if (random.chance(0.5)) {
      text.insert(at, kWords[static_cast<std::size_t>(random.integer(0, 7))]);
    } else {
      text[at] = static_cast<char>(random.integer(0, 255));
    }
  }
  return text;
}

TEST(Methods, whatever_comes_is_checked_or_refused_with_a_sentence) {
  sinew::test::for_random_cases(20'000, [](sinew::test::Random& random) {
    const auto request = read_request(hostile(random));
    if (!request) {
      EXPECT_FALSE(request.error().error.message.empty());
      return;
    }
    const auto method = check(*request);
    if (!method) {
      EXPECT_FALSE(method.error().message.empty());
    }
  });
}

}  // namespace
}  // namespace sinew::server

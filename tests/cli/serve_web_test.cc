#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// What `sinew serve` says of its network door, and when it does without one.
namespace sinew::test {
namespace {

constexpr std::string_view kOneRobot = R"(title = "One for a test"
[[robot]]
name = "left"
robot = "learm"
profile = "bus"
)";

/// A state folder of its own: tokens are made there.
class ServeWeb : public ::testing::Test {
 protected:
  void SetUp() override { setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1); }
  void TearDown() override { unsetenv("XDG_STATE_HOME"); }

  Arguments serve(const std::string& socket, const Arguments& more) const {
    Arguments arguments{"serve", folder_.file("cell.toml", kOneRobot), "--socket",
                        folder_.at(socket)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  /// One that ends by itself, with this exit code.
  std::string refused(const Arguments& more, int exit) const {
    const Ended ended = sinew(serve("refused.sock", more));
    EXPECT_EQ(ended.exit, exit) << ended.err;
    return ended.err;
  }
  /// Where a server with --json listens.
  static Json begun(Process& process) { return Json::parse(process.line_after(0)); }

  ScratchFolder folder_;
};

TEST_F(ServeWeb, a_link_with_the_token_is_printed_at_the_start) {
  Process process(serve("cell.sock", {"--listen", "127.0.0.1:0"}));
  process.wait_for_err("answers on");
  process.signal(SIGTERM);
  const Ended ended = process.end();
  EXPECT_EQ(ended.exit, 0);
  const std::string token = text_of(folder_.at("state/sinew/web/operator.token"));
  EXPECT_NE(ended.err.find("http://127.0.0.1:"), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("/#token=" + token), std::string::npos) << ended.err;
}

TEST_F(ServeWeb, a_port_that_is_taken_is_fatal_where_it_was_asked_for) {
  Process first(serve("first.sock", {"--listen", "127.0.0.1:0", "--json"}));
  const std::string url = begun(first)["web"]["url"];
  const std::string place = url.substr(7, url.size() - 8);
  const std::string err = refused({"--listen", place}, 1);
  EXPECT_NE(err.find(place + ": another program listens there"), std::string::npos) << err;
}

/// What `make run` plays where no terminal is.
TEST_F(ServeWeb, the_usual_port_that_is_taken_is_no_end_where_none_was_asked_for) {
  Process first(serve("first.sock", {"--json"}));
  const std::string url = begun(first)["web"]["url"];
  Process second(serve("second.sock", {}));
  second.wait_for_err("answers on");
  second.signal(SIGTERM);
  const Ended ended = second.end();
  EXPECT_NE(ended.err.find("127.0.0.1:8700: another program listens there"), std::string::npos)
      << ended.err;
  EXPECT_NE(ended.err.find("panel: http://127.0.0.1:"), std::string::npos) << ended.err;
  EXPECT_EQ(ended.err.find("panel: " + url), std::string::npos) << "the first one's";
}

TEST_F(ServeWeb, without_a_door_the_cell_goes_on) {
  Process none(serve("none.sock", {"--listen", "none", "--json"}));
  EXPECT_FALSE(begun(none).contains("web"));
  // Nothing was asked for, and the folder of the tokens cannot be had.
  std::filesystem::create_directories(folder_.at("state/sinew"));
  folder_.file("state/sinew/web", "");
  Process process(serve("cell.sock", {"--json"}));
  const Json json = begun(process);
  EXPECT_TRUE(json["web"].contains("error")) << json.dump();
  EXPECT_EQ(sinew({"status", "--socket", folder_.at("cell.sock")}).exit, 0);
}

TEST_F(ServeWeb, beyond_this_machine_needs_tls_or_a_clear_word) {
  const std::string err = refused({"--listen", "0.0.0.0:0"}, 1);
  EXPECT_NE(err.find("--tls-cert"), std::string::npos) << err;
  EXPECT_NE(err.find("--insecure-network"), std::string::npos) << err;
  Process process(serve("open.sock", {"--listen", "0.0.0.0:0", "--insecure-network"}));
  process.wait_for_err("without TLS on a network");
}

TEST_F(ServeWeb, what_cannot_be_is_told) {
  EXPECT_NE(refused({"--listen", "8700"}, 1).find("write HOST:PORT"), std::string::npos);
  EXPECT_NE(refused({"--listen", "127.0.0.1:70000"}, 1).find("write HOST:PORT"), std::string::npos);
  EXPECT_NE(refused({"--listen", "::1:8700"}, 1).find("[::1]:8700"), std::string::npos);
  EXPECT_NE(refused({"--tls-cert", "a.pem"}, 2).find("both --tls-cert and --tls-key"),
            std::string::npos);
  const std::string missing = folder_.at("missing.pem");
  EXPECT_NE(refused({"--listen", "127.0.0.1:0", "--tls-cert", missing, "--tls-key", missing}, 1)
                .find("missing.pem: no certificate"),
            std::string::npos);
}

TEST_F(ServeWeb, a_token_that_others_may_read_is_none) {
  Process first(serve("first.sock", {"--listen", "127.0.0.1:0", "--json"}));
  const std::string file = begun(first)["web"]["viewer_token_file"];
  std::filesystem::permissions(file, std::filesystem::perms::group_read,
                               std::filesystem::perm_options::add);
  const std::string err = refused({"--listen", "127.0.0.1:0"}, 1);
  EXPECT_NE(err.find("others may read it"), std::string::npos) << err;
}

TEST_F(ServeWeb, listens_on_the_loopback_of_ipv6) {
  Process process(serve("six.sock", {"--listen", "[::1]:0", "--json"}));
  const std::string url = begun(process)["web"]["url"];
  EXPECT_TRUE(url.starts_with("http://[::1]:")) << url;
}

}  // namespace
}  // namespace sinew::test

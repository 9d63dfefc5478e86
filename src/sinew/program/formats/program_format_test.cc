#include "sinew/program/formats/program_format.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "sinew/program/language/program_file.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

std::string laid_out(std::string_view text) {
  const auto out = program::format(text, "p.sinew");
  if (out) return *out;
  return "refused: " + to_text(out.error().front());
}

TEST(Format, blocks_are_indented_words_set_apart_and_remarks_lined_up) {
  EXPECT_EQ(laid_out("\xEF\xBB\xBF\r\n\r\n#  first\r\n"
                     "joint\tspeed=50%   base=30deg  d.J2=-20.0deg to=a # one\r\n"
                     "loop 3 #two \t\r\n"
                     "if z < 100 mm\r\n"
                     "# inside\r\n"
                     "line blend=2mm speed=80mm/s dz=1mm frame=tool speed=50% z=3mm x=2mm\r\n"
                     "else\n\n\n\n"
                     "wait   until  base >3deg  for 5s\n"
                     "end\nend\n\n"
                     "nozzle 45deg time=1s   #a\n\n\n"),
            "#  first\n"
            "joint to=a base=30deg d.J2=-20.0deg speed=50%  # one\n"
            "loop 3                                         #two\n"
            "  if z<100mm\n"
            "    # inside\n"
            "    line x=2mm z=3mm dz=1mm frame=tool speed=50% speed=80mm/s blend=2mm\n"
            "  else\n\n"
            "    wait until base>3deg for 5s\n"
            "  end\n"
            "end\n\n"
            "nozzle 45deg time=1s  #a\n");
  EXPECT_EQ(laid_out(""), "");
  EXPECT_EQ(laid_out("\n\n"), "");
  EXPECT_EQ(laid_out("spline 1mm,2mm,3mm speed=3% here there"),
            "spline 1mm,2mm,3mm here there speed=3%\n");
}

TEST(Format, remarks_are_lined_up_by_characters_and_not_with_very_long_rows) {
  EXPECT_EQ(laid_out("call \xC3\xA4\xC3\xA4  # a\nhome # b\n"),
            "call \xC3\xA4\xC3\xA4  # a\nhome     # b\n");
  const std::string row = "spline" + std::string(20, ' ') + "100mm,100mm,100mm 200mm,200mm,200mm " +
                          "300mm,300mm,300mm 1mm,1mm,1mm";
  EXPECT_EQ(laid_out(row + "  # far\nhome # near\n"),
            "spline 100mm,100mm,100mm 200mm,200mm,200mm 300mm,300mm,300mm 1mm,1mm,1mm  # far\n"
            "home  # near\n");
}

TEST(Format, text_without_a_layout_is_refused_at_its_place) {
  EXPECT_EQ(laid_out("home\n jont base=1deg"),
            "refused: p.sinew:2:2: unknown step 'jont'; did you mean joint?");
  EXPECT_EQ(laid_out("end"), "refused: p.sinew:1:1: end without loop or if");
  EXPECT_EQ(laid_out("loop 3\nelse\nend"), "refused: p.sinew:2:1: else without if");
  EXPECT_EQ(laid_out("wait 1s\nif z<1mm"),
            "refused: p.sinew:2:1: if without end: write end behind its last step");
  EXPECT_EQ(laid_out("wait 1s\r\r\n"),
            "refused: p.sinew:1:6: '1s\\x0d' has a control character in it");
}

/// All that parse() makes of a text but its lines, so that two programs can be compared.
std::string told(const Program& program) {
  std::string out;
  const auto put = [&](const auto& value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    out.append(bytes, sizeof value);
  };
  const auto put_how = [&](const MotionOptions& how) {
    put(how.joint_share), put(how.tool_speed), put(how.tool_acceleration);
    put(how.blend_radius), put(how.blend_joints);
  };
  const auto put_some = [&](const std::optional<double>& value) {
    out += value ? '+' : '-';
    put(value.value_or(0));
  };
  const auto put_vec = [&](const Vec3& v) { put(v.x), put(v.y), put(v.z); };
  for (const Step& step : program.steps) {
    put(step.what.index());
    if (const auto* joint = std::get_if<JointStep>(&step.what)) {
      put(joint->given), put(joint->relative), put_how(joint->how);
      for (const double q : joint->q) put(q);
    } else if (const auto* tool = std::get_if<ToolMoveStep>(&step.what)) {
      put(tool->way), put_vec(tool->p_via_BT), put_how(tool->how);
      for (const auto& value : tool->to.p_BT) put_some(value);
      put_some(tool->to.pitch), put_some(tool->to.roll);
      const Rotation R = tool->to.R_BT.value_or(Rotation{});
      put_vec(R.x), put_vec(R.y), put_vec(R.z);
      const GoalOffset offset = tool->to.offset.value_or(GoalOffset{});
      put_vec(offset.dp), put_vec(offset.turn), put(offset.pitch), put(offset.roll);
      out += offset.in_tool ? 't' : 'b';
    } else if (const auto* spline = std::get_if<SplineStep>(&step.what)) {
      for (const Vec3& p : *spline->through) put_vec(p);
      put_how(spline->how);
    } else if (const auto* wait = std::get_if<WaitStep>(&step.what)) {
      put(wait->duration), put(wait->what), put(wait->until.value);
      put(wait->until.subject), put(wait->until.test), put(wait->until.joint);
    } else if (const auto* loop = std::get_if<LoopStep>(&step.what)) {
      put(loop->rounds), put(loop->end);
    } else if (const auto* branch = std::get_if<IfStep>(&step.what)) {
      put(branch->otherwise), put(branch->end), put(branch->condition.value);
      put(branch->condition.subject), put(branch->condition.test), put(branch->condition.joint);
    }
  }
  return out;
}

/// A program by chance, laid out by chance too.
class RandomText {
 public:
  explicit RandomText(test::Random& random) : random_(random) {}

  std::string program() {
    for (auto rows = random_.integer(0, 15); rows > 0; --rows) {
      if (random_.chance(0.3)) text_ += gap();
      const auto kind = random_.integer(0, 9);
      text_ += kind <= 5 ? plain_row(kind) : kind <= 8 ? block_row(kind) : "home";
      if (random_.chance(0.3)) text_ += gap() + "# why\t\xC3\xA4 # so" + gap();
      text_ += random_.chance(0.5) ? "\r\n" : "\n";
      if (random_.chance(0.2)) text_ += "\n \n";
    }
    for (; !open_.empty(); open_.pop_back()) text_ += "end\n";
    return text_;
  }

 private:
  using Words = std::vector<std::string>;

  std::string gap() {
    constexpr const char* kGaps[] = {" ", "  ", "\t", " \t "};
    return kGaps[random_.integer(0, 3)];
  }
  std::string perhaps_gap() { return random_.chance(0.5) ? gap() : ""; }
  std::string number(const char* unit) {
    return std::to_string(random_.integer(-200, 200)) + (random_.chance(0.3) ? ".50" : "") + unit;
  }
  std::string shuffled(Words words) {
    std::string row;
    while (!words.empty()) {
      const auto at = random_.integer(0, std::ssize(words) - 1);
      row += gap() + words[static_cast<std::size_t>(at)];
      words.erase(words.begin() + at);
    }
    return row;
  }
  Words some(Words words, std::size_t least) {
    while (words.size() > least && random_.chance(0.6)) {
      words.erase(words.begin() + random_.integer(0, std::ssize(words) - 1));
    }
    return words;
  }
  std::string with_options(Words words) {
    for (const std::string& option :
         some({"speed=50%", "speed=80mm/s", "accel=1m/s2", "blend=2mm"}, 0)) {
      words.push_back(option);
    }
    return shuffled(words);
  }

  std::string plain_row(std::int64_t kind) {
    if (kind == 0) {
      return "joint" + with_options(some({"base=" + number("deg"), "J2=" + number("deg"),
                                          "d.elbow=" + number("deg"), "roll=" + number("deg")},
                                         1));
    }
    if (kind <= 2) {
      Words words = some({"x=" + number("mm"), "dy=" + number("mm"), "z=" + number("cm"),
                          "pitch=" + number("deg"), "dz=0.5in", "droll=" + number("deg")},
                         1);
      const bool moved = std::ranges::any_of(words, [](const auto& w) { return w[0] == 'd'; });
      if (moved && random_.chance(0.5)) words.emplace_back("frame=tool");
      return (kind == 1 ? "line" : "move") + with_options(words);
    }
    if (kind == 3) return "arc" + shuffled({"via=1mm,2mm,3mm", "x=" + number("mm"), "speed=10%"});
    if (kind == 4) {
      return "spline" + gap() + "1mm,2mm,3mm" + gap() + "speed=3%" + gap() + "4mm,5mm,6mm";
    }
    return "wait" + gap() + "until" + gap() + "z" + perhaps_gap() + "<" + number("mm") + gap() +
           "for" + gap() + "2s";
  }

  std::string block_row(std::int64_t kind) {
    if (kind == 6) {
      open_.emplace_back("loop");
      return "loop" + gap() + "3";
    }
    if (kind == 7) {
      open_.emplace_back("if");
      return "if" + gap() + "base" + perhaps_gap() + ">=" + number("deg");
    }
    if (open_.empty()) return "";
    if (open_.back() == "if" && random_.chance(0.5)) {
      open_.back() = "else";
      return "else";
    }
    open_.pop_back();
    return "end";
  }

  test::Random& random_;
  Words open_;
  std::string text_;
};

TEST(Format, program_stays_the_same_and_its_layout_too) {
  int read = 0;
  test::for_random_cases(4'000, [&](test::Random& random) {
    const std::string text = RandomText(random).program();
    const auto once = program::format(text, "p");
    ASSERT_TRUE(once) << to_text(once.error().front()) << "\n" << text;
    const auto twice = program::format(*once, "p");
    ASSERT_TRUE(twice);
    ASSERT_EQ(*twice, *once) << text;
    const RobotModel& robot = test::robot("learm");
    const auto before = parse(text, "p", robot);
    const auto behind = parse(*once, "p", robot);
    ASSERT_EQ(before.has_value(), behind.has_value()) << text << "\n--\n" << *once;
    if (!before) return;
    ++read;
    ASSERT_EQ(told(*before), told(*behind)) << text << "\n--\n" << *once;
  });
  std::cout << "  " << read << " programs were read\n";
  EXPECT_GT(read, 2'000);
}

TEST(Format, any_bytes_are_laid_out_once_and_for_all_or_refused) {
  int accepted = 0;
  test::for_random_cases(10'000, [&](test::Random& random) {
    const char* const kParts[] = {"loop 3\n",
                                  "end\n",
                                  "else\n",
                                  "if z<1mm\n",
                                  "home",
                                  " ",
                                  "\t",
                                  "# \r",
                                  "#",
                                  "\n",
                                  "\r\n",
                                  "\xEF\xBB\xBF",
                                  "joint b=1 a=2 speed=3",
                                  "\xC3",
                                  "\r",
                                  "wait until a for b\n"};
    std::string text;
    for (auto parts = random.integer(0, 12); parts > 0; --parts) {
      text += kParts[random.integer(0, std::ssize(kParts) - 1)];
      if (random.chance(0.02)) text += '\0';
    }
    const auto once = program::format(text, "p");
    if (!once) {
      ASSERT_FALSE(once.error().empty());
      return;
    }
    ++accepted;
    const auto twice = program::format(*once, "p");
    ASSERT_TRUE(twice) << testing::PrintToString(text);
    ASSERT_EQ(*twice, *once) << testing::PrintToString(text);
  });
  EXPECT_GT(accepted, 500);
}

}  // namespace
}  // namespace sinew::program

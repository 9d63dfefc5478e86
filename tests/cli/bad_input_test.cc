#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// Whatever people type: a sentence that names the thing and the remedy, the right exit code, JSON
/// where JSON was asked for, and never a crash.
namespace sinew::test {
namespace {

constexpr int kCouldNot = 1;
constexpr int kBadInput = 2;

struct Refused {
  int exit = 0;
  std::string call;      ///< words; '' is an empty one, F/ the scratch folder
  std::string sentence;  ///< what stderr must contain
};

Arguments words_of(const std::string& call, const std::string& folder) {
  Arguments words;
  std::string word;
  const auto add = [&] {
    if (word.empty()) return;
    if (word == "''") word.clear();
    if (word.starts_with("F/")) word = folder + word.substr(1);
    words.push_back(word);
    word.clear();
  };
  for (const char character : call) {
    if (character == ' ') {
      add();
    } else {
      word += character;
    }
  }
  add();
  return words;
}

void expect_refused(const Refused& wanted, const std::string& folder) {
  SCOPED_TRACE("sinew " + wanted.call);
  const Arguments words = words_of(wanted.call, folder);
  const Ended plain = sinew(words);
  EXPECT_EQ(plain.exit, wanted.exit) << plain.err;
  EXPECT_EQ(plain.out, "");
  EXPECT_NE(plain.err.find(wanted.sentence), std::string::npos) << plain.err;
  EXPECT_TRUE(plain.err.starts_with("sinew: ")) << plain.err;
  EXPECT_TRUE(plain.err.ends_with("\n")) << plain.err;
  // Nothing of C++ and nothing that a terminal would obey.
  for (const char* never :
       {"what()", "terminate", "std::", "exception", "basic_string", "assert"}) {
    EXPECT_EQ(plain.err.find(never), std::string::npos) << plain.err;
  }
  for (const char character : plain.err) {
    EXPECT_TRUE(character == '\n' || static_cast<unsigned char>(character) >= 0x20) << plain.err;
  }

  Arguments with_json = words;
  with_json.insert(with_json.begin(), "--json");
  const Ended json = sinew(with_json);
  EXPECT_EQ(json.exit, wanted.exit);
  EXPECT_EQ(json.err, plain.err);
  const Json document = json.json();
  ASSERT_TRUE(document.is_object());
  EXPECT_TRUE(document.contains("error") || document.contains("refusal")) << json.out;
}

/// Files that are no good, in all the ways that files can be.
class BadInput : public ::testing::Test {
 protected:
  BadInput() {
    folder.file("p.txt", "G0 B100 S200 E300 WR400 W300\n");
    folder.file("empty.txt", "");
    folder.file("comment.txt", "# nothing\n");
    folder.file("typo.txt", "G0 B1\nGO B2\n");
    folder.file("limit.txt", "G0 B1\n\nG0 B7000\n");
    folder.file("unsendable.txt", "G0 B3400\n");
    folder.file("gripper.txt", "G1 E1 P13\n");
    folder.file("binary.txt", std::string("\x7f"
                                          "ELF\0\x1b[31m\xff\xfe",
                                          12));
    folder.file("big.txt", std::string(2 << 20, '#'));
    folder.file("bad.toml", "id = 3\n");
    folder.file("binary.toml", std::string("\0\xff\x1b", 3));
    folder.file("empty.toml", "");
    folder.file("file", "kept");
    mkdir(folder.at("folder.toml").c_str(), 0700);
    mkfifo(folder.at("pipe").c_str(), 0600);
    mkfifo(folder.at("pipe.toml").c_str(), 0600);
    static_cast<void>(symlink("loop", folder.at("loop").c_str()));
  }
  void expect_all_refused(const std::vector<Refused>& cases) const {
    for (const Refused& wanted : cases) expect_refused(wanted, folder.at());
  }
  ScratchFolder folder;
};

TEST_F(BadInput, words_that_are_no_call) {
  expect_all_refused({
      {kBadInput, "", "a verb is missing; the verbs are robots, fk, ik, sim, run"},
      {kBadInput, "dance", "there is no verb 'dance'"},
      {kBadInput, "fks", "there is no verb 'fks', did you mean 'fk'?"},
      {kBadInput, "runn F/p.txt", "did you mean 'run'?"},
      {kBadInput, "''", "a verb is missing"},
      {kBadInput, "\x1b[31m\xff", "there is no verb '\\x1b[31m\\xff'"},
      {kBadInput, "fk", "ROBOT is required; sinew fk --help shows the way"},
      {kBadInput, "ik", "ROBOT is required"},
      {kBadInput, "sim", "ROBOT is required"},
      {kBadInput, "run", "FILE is required"},
      {kBadInput, "run F/p.txt", "--robot is required"},
      {kBadInput, "fk learm --joint-deg 1,2,3,4,5", "--joint-deg"},
      {kBadInput, "fk learm --joints-deg", "--joints-deg: takes one value, once"},
      {kBadInput, "fk learm --joints-deg 0,0,0,0,0 --joints-deg 0,0,0,0,1",
       "--joints-deg: takes one value, once"},
      {kBadInput, "fk learm 0,90,0,0,0", "not expected: 0,90,0,0,0"},
      {kBadInput, "fk learm maxarm", "not expected: maxarm"},
      {kBadInput, "robots learm maxarm", "not expected: maxarm"},
      {kBadInput, "fk learm -x", "not expected: -x"},
      {kBadInput, "fk learm --joints-deg 0,0,0,0,0 -- --x", "--x"},
  });
}

TEST_F(BadInput, robots_that_are_none) {
  expect_all_refused({
      {kBadInput, "fk lern --joints-deg 0,0,0,0,0", "did you mean 'learm'?"},
      {kBadInput, "fk ''", "there is no robot ''"},
      {kBadInput, "fk \xff\xfe", "there is no robot '\\xff\\xfe'"},
      {kBadInput, "robots LEARM", "there is no robot 'LEARM'"},
      {kBadInput, "robots F/no.toml", "no.toml: no such file or directory"},
      {kBadInput, "robots F/folder.toml", "folder.toml: is a folder, not a file"},
      {kBadInput, "robots F/pipe.toml", "pipe.toml: nobody writes to this pipe"},
      {kBadInput, "robots F/bad.toml", "bad.toml:1:6: id: "},
      {kBadInput, "robots F/empty.toml", "empty.toml:"},
      {kBadInput, "robots F/binary.toml", "binary.toml:1:"},
      {kBadInput, "run F/p.txt --robot F/bad.toml", "bad.toml:1:6: id: "},
      {kBadInput, "run F/p.txt --robot nobody", "there is no robot 'nobody'"},
      {kBadInput, "sim nobody", "there is no robot 'nobody'"},
      {kBadInput, "run F/p.txt --robot learm", "sequences are the BigRobotArm's; learm is none"},
      {kBadInput, "run F/p.txt --robot puma560",
       "sequences are the BigRobotArm's; puma560 is none"},
      {kBadInput, "sim maxarm --profile pico", "'pico' is none of arduino, micropython"},
  });
}

TEST_F(BadInput, numbers_that_are_none) {
  expect_all_refused({
      {kBadInput, "fk learm", "--joints-deg is missing: 5 numbers"},
      {kBadInput, "fk learm --joints-deg ''", "--joints-deg: a number is missing (number 1, base)"},
      {kBadInput, "fk learm --joints-deg 1,2,3,4", "5 numbers are wanted"},
      {kBadInput, "fk learm --joints-deg 1,2,3,4,5,6", "6 were given"},
      {kBadInput, "fk learm --joints-deg 1,2,,4,5", "a number is missing (number 3"},
      {kBadInput, "fk learm --joints-deg ,,,,", "a number is missing (number 1"},
      {kBadInput, "fk learm --joints-deg nan,0,0,0,0", "'nan' is not a finite number"},
      {kBadInput, "fk learm --joints-deg -nan,0,0,0,0", "'-nan' is not a finite number"},
      {kBadInput, "fk learm --joints-deg -inf,0,0,0,0", "'-inf' is not a finite number"},
      {kBadInput, "fk learm --joints-deg infinity,0,0,0,0", "'infinity' is not a finite number"},
      {kBadInput, "fk learm --joints-deg 1e400,0,0,0,0", "'1e400' is not a finite number"},
      {kBadInput, "fk learm --joints-deg 1e300,0,0,0,0", "is beyond 100 turns"},
      {kBadInput, "fk learm --joints-deg 36001,0,0,0,0", "is beyond 100 turns"},
      {kBadInput, "fk learm --joints-deg 0x10,0,0,0,0", "ends in 'x10'"},
      {kBadInput, "fk learm --joints-deg 1mm,0,0,0,0", "ends in 'mm', which is none of deg, rad"},
      {kBadInput, "fk learm --joints-deg 1;2;3;4;5", "ends in ';2;3;4;5'"},
      {kBadInput, "fk learm --joints-deg 1..2,0,0,0,0", "ends in '.2'"},
      {kBadInput, "fk learm --joints-deg +-1,0,0,0,0", "'+-1' is not a finite number"},
      {kBadInput, "fk learm --joints-deg \xff\x01,0,0,0,0", "'\\xff\\x01' is not a finite number"},
      {kBadInput, "fk learm --joints-deg 0,0,0,0,0 --gripper-mm -1",
       "--gripper-mm: -1 mm is outside"},
      {kBadInput, "fk learm --joints-deg 0,0,0,0,0 --gripper-mm 5kg", "ends in 'kg'"},
      {kBadInput, "fk maxarm --joints-deg 0,0,0 --gripper-mm 5", "has no gripper with jaws"},
      {kBadInput, "fk learm --legs-mm 1,2,3,4,5,6", "learm has joints: give --joints-deg"},
      {kBadInput, "fk hexapod --joints-deg 1,2,3,4,5,6", "hexapod has legs: give --legs-mm"},
      {kBadInput, "fk hexapod --legs-mm 1,2,3,4,5,6 --near-pose-mm-deg 1,2", "--near-pose-mm-deg"},
      {kBadInput, "fk hexapod --legs-mm 1e9,1,1,1,1,1", "is beyond 100 m"},
      {kCouldNot, "fk hexapod --legs-mm 1,1,1,1,1,1000", ""},
      {kBadInput, "fk maxarm --joints-deg 0,0,0 --frames", "--frames: only serial arms"},
      {kBadInput, "ik learm", "give either --pose-mm-deg x,y,z,rx,ry,rz or --point-mm x,y,z"},
      {kBadInput, "ik learm --point-mm 1,2,3 --pose-mm-deg 1,2,3,4,5,6", "give either"},
      {kBadInput, "ik learm --point-mm 1,2", "3 numbers are wanted (x,y,z), 2 were given"},
      {kBadInput, "ik learm --point-mm 200,0,20 --pitch-deg level", "--pitch-deg: 'level'"},
      {kBadInput, "ik learm --point-mm 200,0,20 --pitch-deg 361",
       "--pitch-deg: is beyond one turn"},
      {kBadInput, "ik learm --pose-mm-deg 1,2,3,4,5,6 --pitch-deg 9",
       "a pose has its own direction"},
      {kBadInput, "ik bigrobotarm --point-mm 300,0,0 --approach 0,0,0",
       "a direction needs a length"},
      {kBadInput, "ik bigrobotarm --point-mm 300,0,0 --approach 0,0", "--approach: 3 numbers"},
      {kBadInput, "ik bigrobotarm --point-mm 300,0,0 --approach 1,0,0 --pitch-deg 9", "not both"},
      {kCouldNot, "ik learm --point-mm 200,0,50 --approach 0,0,-1", "cannot be asked for that"},
      {kBadInput, "ik learm --point-mm 200,0,20 --near-joints-deg 1", "--near-joints-deg"},
      {kBadInput, "ik learm --point-mm 200,0,20 --near-pose-mm-deg 1", "only a hexapod has it"},
      {kBadInput, "ik maxarm --point-mm 0,-163,212 --near-joints-deg x", "--near-joints-deg: 'x'"},
      {kBadInput, "ik maxarm --point-mm 0,-163,212 --pitch-deg 5", "keeps its tool level"},
      {kBadInput, "ik hexapod --point-mm 1,2,3", "give its pose with --pose-mm-deg"},
      {kBadInput, "ik hexapod --pose-mm-deg 0,0,250,0,0,0 --near-pose-mm-deg x", "'x' is not"},
      {kCouldNot, "ik learm --point-mm 99m,0,20", "out of reach"},
      {kBadInput, "ik learm --point-mm 101m,0,20", "is beyond 100 m"},
  });
}

TEST_F(BadInput, programs_that_are_none) {
  expect_all_refused({
      {kBadInput, "run F/no.txt --robot bigrobotarm", "no.txt: no such file or directory"},
      {kBadInput, "run '' --robot bigrobotarm", "'': no such file or directory"},
      {kBadInput, "run F/ --robot bigrobotarm", "is a folder, not a file"},
      {kBadInput, "run F/loop --robot bigrobotarm", "loop: too many levels of symbolic links"},
      {kBadInput, "run F/p.txt/x --robot bigrobotarm", "x: not a directory"},
      {kBadInput, "run F/pipe --robot bigrobotarm", "pipe: nobody writes to this pipe"},
      {kBadInput, "run /dev/zero --robot bigrobotarm", "/dev/zero: is a device, not a file"},
      {kBadInput, "run F/big.txt --robot bigrobotarm", "big.txt: larger than 1048576 bytes"},
      {kBadInput, "run F/empty.txt --robot bigrobotarm", "empty.txt: has no step"},
      {kBadInput, "run F/comment.txt --robot bigrobotarm", "could be: joint base=10deg"},
      {kBadInput, "run F/typo.txt --robot bigrobotarm",
       "typo.txt:2:1: unknown command 'GO': did you mean G0?"},
      {kBadInput, "run F/binary.txt --robot bigrobotarm", "binary.txt:1:1: unknown command"},
      {kCouldNot, "run F/limit.txt --robot bigrobotarm",
       "limit.txt:3, at 92.9 %: base would need 96.92"},
      {kCouldNot, "run F/unsendable.txt --robot bigrobotarm", "base at 3400 cannot be sent"},
      {kCouldNot, "run F/gripper.txt --robot bigrobotarm", "gripper.txt:1: "},
  });
}

TEST_F(BadInput, ports_scales_and_files_to_write) {
  const std::string run = "run F/p.txt --robot bigrobotarm ";
  expect_all_refused({
      {kCouldNot, run + "--port F/no", "no: no such file or directory; ls /dev/serial/by-id"},
      {kCouldNot, run + "--port ''", "'': no such file or directory"},
      {kCouldNot, run + "--port F/file", "file: not a serial port"},
      {kCouldNot, run + "--port /dev/null", "/dev/null: not a serial port"},
      {kCouldNot, run + "--port F/folder.toml", "folder.toml: is a directory"},
      {kBadInput, run + "--wire morse", "--wire: 'morse' is none of byte, text, text2026, probe"},
      {kBadInput, run + "--time-scale 0", "--time-scale: 0 is outside 0.01..100"},
      {kBadInput, run + "--time-scale -1", "--time-scale: -1 is outside"},
      {kBadInput, run + "--time-scale nan", "--time-scale: nan is outside"},
      {kBadInput, run + "--time-scale 1e9", "is outside 0.01..100"},
      {kBadInput, run + "--time-scale 1e999", "--time-scale: inf is outside"},
      {kBadInput, run + "--time-scale fast", "--time-scale: 'fast' is not a number"},
      {kBadInput, run + "--time-scale 2 --port F/file", "a real port keeps real time"},
      {kBadInput, run + "--record F/folder.toml", "--record: "},
      {kBadInput, run + "--plot F/no/p.svg", "p.svg: no such file or directory"},
      {kBadInput, run + "--log ''", "--log: '': no such file or directory"},
      {kBadInput, run + "--log F/p.txt", "p.txt is the program; choose another name"},
      {kBadInput, run + "--record F/./p.txt", "is the program; choose another name"},
      {kBadInput, run + "--record F/a --plot F/./a", "is the file of --record"},
      {kBadInput, run + "--log F/file --port F/file", "is the port; choose another name"},
      {kBadInput, "sim bigrobotarm --time-scale 0", "--time-scale: 0 is outside"},
      {kCouldNot, "sim bigrobotarm --link F/file", "exists and is not a link"},
      {kCouldNot, "sim bigrobotarm --link F/folder.toml", "exists and is not a link"},
      {kCouldNot, "sim bigrobotarm --link F/no/link", "no such file or directory"},
      {kCouldNot, "sim bigrobotarm --link ''", "--link: '': no such file or directory"},
      {kCouldNot, "sim bigrobotarm --log F/folder.toml", "--log: "},
  });
  EXPECT_EQ(text_of(folder.at("file")), "kept");
  EXPECT_EQ(text_of(folder.at("p.txt")), "G0 B100 S200 E300 WR400 W300\n");
}

TEST_F(BadInput, all_complaints_of_a_file_come_at_once_and_in_json) {
  folder.file("two.txt", "G0 X1\nfoo\n");
  const Ended ended = sinew({"run", folder.at("two.txt"), "--robot", "bigrobotarm", "--json"});
  EXPECT_EQ(ended.exit, kBadInput);
  const Json complaints = ended.json()["error"]["complaints"];
  ASSERT_EQ(complaints.size(), 2U);
  EXPECT_EQ(complaints[1]["line"], 2);
  EXPECT_EQ(complaints[1]["column"], 1);
  EXPECT_EQ(complaints[1]["file"], folder.at("two.txt"));
}

TEST_F(BadInput, very_long_words_are_answered_shortly) {
  const std::string word(100'000, 'x');
  for (const Arguments& arguments :
       {Arguments{word}, Arguments{"fk", word}, Arguments{"fk", "learm", word},
        Arguments{"fk", "learm", "--joints-deg", word}}) {
    const Ended ended = sinew(arguments);
    EXPECT_EQ(ended.exit, kBadInput);
    EXPECT_LT(ended.err.size(), 600U) << ended.err.substr(0, 200);
  }
  EXPECT_EQ(sinew({"run", word, "--robot", "bigrobotarm"}).exit, kBadInput);
  std::string numbers = "0";
  for (int i = 0; i < 30'000; ++i) numbers += ",0";
  const Ended many = sinew({"fk", "learm", "--joints-deg", numbers});
  EXPECT_NE(many.err.find("30001 were given"), std::string::npos) << many.err;
}

TEST_F(BadInput, value_that_was_forgotten_takes_no_json_away) {
  const Ended ended = sinew({"fk", "learm", "--joints-deg", "--json"});
  EXPECT_EQ(ended.exit, kBadInput);
  EXPECT_EQ(ended.json()["error"]["sentence"],
            "--joints-deg: '--json' is not a finite number (number 1, base)");
}

}  // namespace
}  // namespace sinew::test

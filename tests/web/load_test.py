#!/usr/bin/env python3
"""What five simulated robots cost, in processor time of the whole process: load_test.py SINEW-PROGRAM.

load_test.py --soak SINEW-PROGRAM [MINUTES]: the memory of a demonstration over MINUTES (30).
"""

import json
import os
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "clients/python"))

import sinew  # noqa: E402

# Of a core; docs/web.md has what was measured. Processors differ: the same program took 16 % on one
# and 34 % on another, and the simulated camera takes 15 to 40 % beside it.
DEMO_MAX, REST_MAX = 0.9, 0.1
GROWTH_MB = 16


def processor_s(process):
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(process):
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0


class Demonstration:
    """The built-in cell, playing."""

    def __init__(self, program, option="--demo"):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = self.folder.name + "/s"
        self.told = open(self.folder.name + "/told", "w+", encoding="utf-8")
        home = dict(os.environ, XDG_STATE_HOME=self.folder.name, XDG_RUNTIME_DIR=self.folder.name)
        self.server = subprocess.Popen(
            [program, "serve", option, "--socket", self.socket, "--listen", "127.0.0.1:0"],
            stdout=self.told, stderr=self.told, env=home)
        time.sleep(10)  # opened, homed where homing is short, and playing

    def end(self):
        self.server.terminate()
        self.server.wait(timeout=60)
        self.told.close()
        self.folder.cleanup()

    def share(self, seconds):
        """Of a core."""
        began, used = time.monotonic(), processor_s(self.server.pid)
        time.sleep(seconds)
        return (processor_s(self.server.pid) - used) / (time.monotonic() - began)

    def shares(self, seconds):
        """Sorted: the middle of three counts, as what moves differs."""
        shares = sorted(self.share(seconds) for _ in range(3))
        print("# " + ", ".join(f"{100 * share:.1f} %" for share in shares))
        return shares


class Load(unittest.TestCase):
    PROGRAM = ""

    def demonstration(self, *option):
        demo = Demonstration(self.PROGRAM, *option)
        self.addCleanup(demo.end)
        return demo

    def test_a_demonstration_that_is_played_once_leaves_the_processor_to_others_and_ends(self):
        demo = self.demonstration("--demo-once")
        playing = demo.shares(10)[1]
        self.assertEqual(demo.server.wait(timeout=120), 0)
        demo.told.seek(0)
        told = demo.told.read()
        for robot in ("arm", "learm", "big", "max", "platform"):
            self.assertIn(robot + ": shown", told)
        self.assertLess(playing, DEMO_MAX)
        self.assertGreater(playing, REST_MAX, "nothing played")

    def test_robots_at_rest_leave_the_processor_to_others(self):
        demo = self.demonstration()
        with sinew.connect(demo.socket) as cell:
            cell.call("robot.stop")
            time.sleep(3)
            resting = demo.shares(5)[1]
            states = [robot["state"] for robot in cell.statuses()]
        self.assertEqual(len(states), 5)
        self.assertNotIn("moving", states)
        self.assertLess(resting, REST_MAX)


def soak(program, minutes):
    demo = Demonstration(program)
    try:
        # The first fifth fills rings and records; then the most of each further fifth.
        most = [0.0] * 5
        begun = time.monotonic()
        while (passed := (time.monotonic() - begun) / (60 * minutes)) < 1:
            k = int(5 * passed)
            most[k] = max(most[k], memory_mb(demo.server.pid))
            time.sleep(1)
        used = processor_s(demo.server.pid) / (60 * minutes)
        alive = demo.server.poll() is None
    finally:
        demo.end()
    print("the most memory in each fifth: " + ", ".join(f"{one:.0f}" for one in most) +
          f" MB; {100 * used:.1f} % of a core")
    grown = most[4] - most[1]
    if grown > GROWTH_MB:
        print(f"the last fifth took {grown:.0f} MB more than the second (limit {GROWTH_MB})")
    return 0 if alive and grown <= GROWTH_MB else 1


if __name__ == "__main__":
    if len(sys.argv) > 2 and sys.argv[1] == "--soak":
        sys.exit(soak(sys.argv[2], float(sys.argv[3]) if len(sys.argv) > 3 else 30))
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    Load.PROGRAM = sys.argv.pop()
    unittest.main()

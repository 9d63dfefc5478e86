#!/usr/bin/env python3
"""What watchers get, and what they cost the server's thread: telemetry_test.py SINEW-PROGRAM."""

import os
import sys
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "clients/python"))

import sinew  # noqa: E402
from served_cell import ServedCell  # noqa: E402

SECONDS = 6
SHARE_MAX = 0.10  # of one core, for five robots at 100 Hz


def processor_s(process):
    """Of the thread that serves, the process's first."""
    fields = Path(f"/proc/{process}/task/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Telemetry(ServedCell):
    CELL = (ROOT / "cells/five.toml").read_text()

    def watched(self, cell, rate_hz, seconds):
        """Status messages in so many seconds, and the share of a core that the server took."""
        cell.call("watch", rate_hz=rate_hz)
        began, used, count = time.monotonic(), processor_s(self.server.pid), 0
        while time.monotonic() < began + seconds:
            message = cell.next_message(0.2)
            count += bool(message) and message["method"] == "status"
        took = time.monotonic() - began
        share = (processor_s(self.server.pid) - used) / took
        cell.call("watch", rate_hz=0)
        return count / took, share

    def test_five_robots_a_hundred_times_a_second_cost_less_than_a_tenth_of_a_core(self):
        with sinew.connect(self.url) as cell:
            self.assertEqual(len(cell.describe()["robots"]), 5)
            # The best of three: others work on this machine too.
            told = [self.watched(cell, 100, SECONDS) for _ in range(3)]
        for rate, share in told:
            print(f"# {rate:.0f} messages a second, {100 * share:.1f} % of a core")
        # Of a hundred messages a second, however many came.
        self.assertLess(min(share * 100 / rate for rate, share in told), SHARE_MAX)
        self.assertGreater(max(rate for rate, _ in told), 90)

    def test_a_rate_is_the_clients_own_and_has_its_bounds(self):
        with sinew.connect(self.url) as cell:
            for wish in (20, 60):
                rate = max(self.watched(cell, wish, 3)[0] for _ in range(2))
                self.assertGreater(rate, 0.9 * wish)
                self.assertLess(rate, 1.05 * wish)
            for wrong in (101, -1, 1e9):
                with self.assertRaises(sinew.Refused):
                    cell.call("watch", rate_hz=wrong)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    ServedCell.PROGRAM = sys.argv.pop()
    unittest.main()

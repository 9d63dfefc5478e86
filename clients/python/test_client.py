#!/usr/bin/env python3
"""Runs the client and its examples against a simulated cell: test_client.py SINEW-PROGRAM."""

import csv
import json
import socket
import ssl
import stat
import subprocess
import sys
import time
import unittest
import urllib.error
import urllib.request
from math import degrees
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import sinew  # noqa: E402
from served_cell import ServedCell  # noqa: E402

CELL = """title = "Two for a test"
time_scale = 1
[[robot]]
name = "learm"
robot = "learm"
profile = "bus"
[[robot]]
name = "maxarm"
robot = "maxarm"
x_mm = 3000
"""
STAND = "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg"


class ClientTest(ServedCell):
    CELL = CELL

    def test_tls_is_spoken_with_the_files_that_were_given(self):
        folder = Path(self.folder.name)
        key, certificate = str(folder / "key.pem"), str(folder / "cert.pem")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                        "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key, "-out",
                        certificate, "-days", "2", "-subj", "/CN=localhost", "-addext",
                        "subjectAltName=DNS:localhost,IP:127.0.0.1"],
                       check=True, capture_output=True)
        server = subprocess.Popen(
            [self.PROGRAM, "serve", str(folder / "cell.toml"), "--socket", str(folder / "tls.sock"),
             "--listen", "127.0.0.1:0", "--tls-cert", certificate, "--tls-key", key, "--json"],
            stdout=subprocess.PIPE, text=True)
        try:
            url = json.loads(server.stdout.readline())["web"]["url"]
            self.assertTrue(url.startswith("https://127.0.0.1:"))
            with sinew.connect(url, ca_file=certificate) as cell:
                self.assertEqual(cell.describe()["title"], "Two for a test")
            with self.assertRaises(ssl.SSLCertVerificationError):
                sinew.connect(url)
            # Plain words at a door that speaks TLS end the connection.
            port = int(url.split(":")[2].strip("/"))
            with socket.create_connection(("127.0.0.1", port), timeout=30) as plain:
                plain.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
                self.assertNotIn(b"HTTP/1.1 200", plain.recv(1000))
        finally:
            server.terminate()
            server.communicate(timeout=60)

    def example(self, name, *arguments):
        ended = subprocess.run([sys.executable, str(HERE / "examples" / name), *arguments],
                               capture_output=True, text=True, timeout=240,
                               cwd=self.folder.name)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return ended.stdout

    def truth_deg(self, joint=0):
        with sinew.connect(self.socket) as cell:
            return degrees(cell.robot("learm").truth()["joints"][joint]["position_rad"])

    def test_move_goes_where_it_says(self):
        self.assertIn("2 moves", self.example("move.py", "--cell", self.socket))
        self.assertAlmostEqual(self.truth_deg(), 30, delta=2)

    def test_move_over_the_network(self):
        with sinew.connect(self.socket) as cell:
            cell.robot("learm").run(STAND)
        self.example("move.py", "--cell", self.url)
        self.assertAlmostEqual(self.truth_deg(), 30, delta=2)

    def test_jog_turns_and_comes_back(self):
        with sinew.connect(self.socket) as cell:
            cell.robot("learm").run(STAND)
        token = Path(self.begun["web"]["operator_token_file"]).read_text().strip()
        said = self.example("jog.py", "--cell", f"{self.url}#token={token}").splitlines()
        self.assertEqual(len(said), 2)
        self.assertGreater(float(said[0].split()[2]), 5)

    def test_pick_and_place_moves_parts(self):
        said = self.example("pick_and_place.py", "--cell", self.url, "--parts", "1")
        self.assertIn("part 1: from x = -40 mm to x = 40 mm", said)
        with sinew.connect(self.socket) as cell:
            self.assertFalse(cell.robot("maxarm").truth()["suction"])

    def test_plot_has_the_whole_move(self):
        plot = str(Path(self.folder.name) / "plot")
        said = self.example("plot_move.py", "--cell", self.url, "--plot", plot)
        with open(plot + ".csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertGreater(len(rows), 10)
        self.assertAlmostEqual(float(rows[-1]["base_deg"]), 25, delta=2)
        times = [float(row["time_s"]) for row in rows]
        self.assertEqual(times, sorted(times))
        picture = said.split()[-1]
        self.assertGreater(Path(picture).stat().st_size, 1000)

    def test_plot_draws_without_any_library(self):
        sys.path.insert(0, str(HERE / "examples"))
        import plot_move
        svg = Path(self.folder.name) / "two.svg"
        plot_move.write_svg(str(svg), ["a", "b"], [[0, 1, 2], [1, 3, 4]])
        self.assertEqual(svg.read_text().count("<polyline"), 2)

    def test_what_is_refused_is_told_in_its_sentence(self):
        with sinew.connect(self.url) as cell:
            with self.assertRaisesRegex(sinew.Refused, "no robot of this cell has that name"):
                cell.robot("leram")
            arm = cell.robot("learm")
            with self.assertRaisesRegex(sinew.Refused, "did you mean|jiont"):
                arm.run("jiont base=3deg")
            with self.assertRaisesRegex(sinew.Refused, "robot.stop takes no"):
                cell.call("robot.stop", hard=True)

    def test_recovery_of_an_arm_that_knows_where_it_is_goes_home_all_the_same(self):
        with sinew.connect(self.socket) as cell:
            arm = cell.robot("learm")
            arm.run(STAND)
            for _ in range(2):  # the second time it stands there already
                now = cell.call("procedure.start", robot="learm", kind="recover")
                end = time.monotonic() + 60
                while not now["over"] and time.monotonic() < end:
                    if now.get("asks", {}).get("ready"):
                        self.assertFalse(now.get("trouble"), now)
                        cell.call("procedure.answer", robot="learm", answer=now["asks"]["kind"])
                    cell.next_message(0.1)
                    now = cell.call("procedure.status", robot="learm")
                self.assertEqual(now["phase"], "done", now)
            homes = [one["home_rad"] for one in arm.description()["joints"]]
            for joint, home in zip(arm.truth()["joints"], homes):
                self.assertAlmostEqual(joint["position_rad"], home, delta=0.05)

    def test_objects_tell_what_has_changed(self):
        with sinew.connect(self.url) as cell:
            names = cell.call("objects.list")["objects"]
            self.assertIn("robot/learm", names)
            known = cell.call("objects.subscribe", objects=["robot/learm"], rate_hz=50)["objects"]
            with sinew.connect(self.socket) as other:
                other.robot("learm").run("joint base=5deg")
            update = cell.next_message(10)["params"]["objects"]["robot/learm"]
            self.assertNotIn("robot", update)
            self.assertEqual(known["robot/learm"]["robot"], "learm")

    def test_a_wrong_token_is_told(self):
        with self.assertRaisesRegex(ConnectionError, "not the one of this server"):
            sinew.connect(self.url, token="0" * 32)

    def test_a_viewer_stops_and_does_not_move(self):
        token = Path(self.begun["web"]["viewer_token_file"]).read_text().strip()
        with sinew.connect(self.url, token=token) as cell:
            cell.stop()
            with self.assertRaisesRegex(sinew.Refused, "viewers watch and may stop"):
                cell.robot("learm").run(STAND)

    def test_tokens_are_this_users_alone(self):
        for role in ("operator", "viewer"):
            file = Path(self.begun["web"][f"{role}_token_file"])
            self.assertEqual(stat.S_IMODE(file.stat().st_mode), 0o600)
            self.assertRegex(file.read_text(), r"\A[0-9a-f]{32}\n\Z")

    def test_a_post_is_answered(self):
        token = Path(self.begun["web"]["operator_token_file"]).read_text().strip()
        request = urllib.request.Request(
            self.url + "rpc", b'{"jsonrpc":"2.0","id":1,"method":"cell.status"}',
            {"Content-Type": "application/json", "Authorization": "Bearer " + token})
        with urllib.request.urlopen(request, timeout=30) as answer:
            self.assertEqual(len(json.load(answer)["result"]["robots"]), 2)
        with self.assertRaises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(self.url + "openrpc.json", timeout=30)
        self.assertEqual(refused.exception.code, 401)
        refused.exception.close()


if __name__ == "__main__":
    ServedCell.PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main(verbosity=2)

#!/usr/bin/env python3
"""flood.py SINEW-PROGRAM [SECONDS]: what a flood of clients does to the control cycle and to a stop.

Runs a program on a simulated robot, once in peace and once under a flood: connections that ask for
the page, heads that never end, wrong tokens, viewers that ask for everything or for previews, that
never read, and messages of 1 MB.
From the records: the time between samples of the control thread. From the Unix socket: how long a
stop takes until it is answered. Ends with 1 where the flood has made the control thread late (its
median by half, one gap of a thousand by more than a cycle, or a hold), or stops slower than ANSWER_MS.
"""

import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "clients" / "python"))

import socket  # noqa: E402

import sinew  # noqa: E402

CELL = """title = "Flooded"
[[robot]]
name = "learm"
robot = "learm"
profile = "bus"
[[robot]]
name = "spare"
robot = "maxarm"
x_mm = 2000
"""
STAND = "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg"
SLOWER_MAX = 1.5  # median time between samples, flooded against in peace
ANSWER_MS = 50  # median, flooded
SWING = "loop {times}\n  joint base=40deg\n  joint base=-40deg\nend\n"


def far_away():
    """Clients of a flood run elsewhere: what they cost this machine is not the matter."""
    os.setsid()  # a scheduling group of their own, where the system has such
    os.nice(19)


def pages(port, _, end):
    far_away()
    while time.time() < end:
        with socket.create_connection(("127.0.0.1", port)) as one:
            one.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
            one.recv(4096)


def wrong(port, _, end):
    far_away()
    while time.time() < end:
        with socket.create_connection(("127.0.0.1", port)) as one:
            one.sendall(f"POST /rpc HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
                        f"Authorization: Bearer {'0' * 32}\r\n\r\n".encode())
            one.recv(4096)


def slow(port, _, end):
    far_away()
    held = []
    while time.time() < end:
        try:
            one = socket.create_connection(("127.0.0.1", port))
            one.sendall(b"GET / HTTP/1.1\r\nX: ")
            held.append(one)
        except OSError:
            pass
        held = held[-200:]
        time.sleep(0.002)


def asks(port, token, end):
    far_away()
    with sinew.connect(f"http://127.0.0.1:{port}/", token=token) as cell:
        while time.time() < end:
            cell.call("cell.status")


def large(port, token, end):
    far_away()
    with sinew.connect(f"http://127.0.0.1:{port}/", token=token) as cell:
        text = "x" * 1_000_000
        while time.time() < end:
            try:
                cell.call("robot.status", robot=text)
            except sinew.Refused:
                pass


def previews(port, token, end):
    far_away()
    with sinew.connect(f"http://127.0.0.1:{port}/", token=token) as cell:
        while time.time() < end:
            try:
                cell.call("robot.preview", robot="learm", text=SWING.format(times=20), samples=1000)
            except sinew.Refused:
                pass


def never_reads(port, token, end):
    """Asks for large answers and takes none, until it is cut off; then again."""
    far_away()
    ask = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "rpc.discover"})
    while time.time() < end:
        with sinew.connect(f"http://127.0.0.1:{port}/", token=token) as cell:
            try:
                cell._wire._reader.cancel()
                for _ in range(1000):
                    cell._wire.send(ask)
                    if time.time() > end:
                        break
            except ConnectionError:
                pass


def stops(path, end):
    """How long a stop takes until it is answered, each 100 ms; ms. Of another robot than the one that moves."""
    took = []
    with sinew.connect(path) as cell:
        while time.time() < end:
            begun = time.monotonic()
            cell.call("robot.stop", robot="spare")
            took.append((time.monotonic() - begun) * 1e3)
            time.sleep(0.1)
    return took


def measure(program, seconds, flooded):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "cell.toml").write_text(CELL)
        os.environ["XDG_STATE_HOME"] = name
        server = subprocess.Popen(
            [program, "serve", str(folder / "cell.toml"), "--socket", str(folder / "s"),
             "--listen", "127.0.0.1:0", "--record-folder", name, "--json"],
            stdout=subprocess.PIPE, text=True)
        web = json.loads(server.stdout.readline())["web"]
        port = int(web["url"].split(":")[2].strip("/"))
        token = Path(web["viewer_token_file"]).read_text().strip()
        with sinew.connect(str(folder / "s")) as cell:
            cell.robot("learm").run(STAND)
        end = time.time() + seconds
        crowd = [pages] * 2 + [wrong] + [slow] + [asks] * 6 + [large] * 2 + [previews] * 3 + [never_reads] * 2 if flooded else []
        flood = [multiprocessing.Process(target=one, args=(port, token, end)) for one in crowd]
        for one in flood:
            one.start()
        with multiprocessing.Pool(1) as pool:
            asked = pool.apply_async(stops, (str(folder / "s"), end))
            with sinew.connect(str(folder / "s")) as cell:
                failed = ""
                try:
                    while time.time() < end:
                        cell.robot("learm").run(SWING.format(times=1))
                except sinew.Refused as refused:
                    failed = str(refused)
            took = sorted(asked.get())
        for one in flood:
            one.join()
        with open(f"/proc/{server.pid}/stat") as file:
            busy = sum(int(x) for x in file.read().split()[13:15]) / os.sysconf("SC_CLK_TCK")
        server.terminate()
        server.communicate(timeout=60)
        gaps = []
        for record in sorted(folder.glob("*.mcap"), key=lambda one: one.stat().st_mtime)[1:]:
            subprocess.run([program, "record", str(record), "--csv", str(folder / "r.csv")],
                           check=True, capture_output=True)
            rows = (folder / "r.csv").read_text().splitlines()
            times = [float(row.split(",")[0]) for row in rows[1:]]
            gaps += [b - a for a, b in zip(times, times[1:])]
        gaps.sort()
    print(f"{'flooded' if flooded else 'in peace'}: {len(gaps)} samples, between them median "
          f"{gaps[len(gaps) // 2] * 1e3:.1f} ms, 99.9 % {gaps[int(len(gaps) * .999)] * 1e3:.1f} ms, "
          f"longest {gaps[-1] * 1e3:.1f} ms; a stop on the socket answered in median "
          f"{took[len(took) // 2]:.1f} ms, longest {took[-1]:.1f} ms; processor {busy:.1f} s"
          + (f"; ended: {failed}" if failed else ""))
    return gaps[len(gaps) // 2], gaps[int(len(gaps) * .999)], took[len(took) // 2], failed


def main():
    program = str(Path(sys.argv[1]).resolve())
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 15
    peace, rare_in_peace, _, _ = measure(program, seconds, False)
    flooded, rare, answer_ms, ended = measure(program, seconds, True)
    late = flooded > SLOWER_MAX * peace or rare > max(rare_in_peace, 2 * peace)
    disturbed = late or answer_ms > ANSWER_MS or ended
    if disturbed:
        print("the flood has disturbed the control thread")
    return 1 if disturbed else 0


if __name__ == "__main__":
    sys.exit(main())

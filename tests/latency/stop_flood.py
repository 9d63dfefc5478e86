#!/usr/bin/env python3
"""stop_flood.py SINEW-PROGRAM [VIEWERS [STOPS]]: stops and holds while many viewers ask without a pause.

Runs the built-in cell of five simulated robots until their wires' rings are full, then VIEWERS (60)
clients: most read the wires (the latest 2000 messages each time), the others ask for all that costs
the server something. 12 sit on the Unix socket, the others on WebSockets; all in one process that
reads no JSON. One robot moves: stops and holds end its ride, and it begins anew.
Measures how long a stop and a hold take until they are answered, and the memory of
the server before, during and behind. Ends with 1 where the median is above 10 ms, the longest above
50 ms, or more than 16 MB of memory stay.
"""

import base64
import json
import multiprocessing
import os
import selectors
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "clients" / "python"))

import sinew  # noqa: E402

MEDIAN_MS, WORST_MS, KEPT_MB = 10, 50, 16
LOCAL = 12  # viewers on the Unix socket
MOVING = "learm"
moved = []  # whether it did when its stop or hold was sent
ROBOTS = ["arm", "learm", "big", "max", "platform"]
OTHERS = [("cell.status", {}), ("objects.query", {}), ("events.list", {}), ("rpc.discover", {}),
          ("robot.model", {"robot": "arm"}), ("device.status", {"robot": "platform"})]


class Viewer:
    """Keeps one request under way, and throws its answers away."""

    def __init__(self, k, port, token, path):
        method, params = ("wire.read", {"robot": ROBOTS[k % 5], "limit": 2000})
        if k % 4 == 3:
            method, params = OTHERS[k // 4 % len(OTHERS)]
        text = json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}).encode()
        self.answers, self.size, self.left, self.head = 0, 0, 0, b""
        self.web = k >= LOCAL
        if not self.web:
            self.socket = socket.socket(socket.AF_UNIX)
            self.socket.connect(path)
            self.ask = text + b"\n"
        else:
            self.socket = socket.create_connection(("127.0.0.1", port))
            key = base64.b64encode(os.urandom(16)).decode()
            self.socket.sendall(
                (f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                 f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
                 f"Authorization: Bearer {token}\r\n\r\n").encode())
            answer = b""
            while b"\r\n\r\n" not in answer:
                answer += self.socket.recv(1)
            assert b" 101 " in answer, answer
            length = len(text)
            size = bytes([0x80 | length]) if length < 126 else bytes([0xFE]) + length.to_bytes(2, "big")
            self.ask = b"\x81" + size + b"\0\0\0\0" + text  # a mask of zeros changes nothing
        self.socket.sendall(self.ask)

    def take(self):
        data = self.socket.recv(1 << 18)
        if not data:
            raise SystemExit("a viewer was cut off")
        self.size += len(data)
        if not self.web:
            done = data.endswith(b"\n")
        else:
            done = self.take_frames(data)
        if done:
            self.answers += 1
            self.socket.sendall(self.ask)

    def take_frames(self, data):
        done = False
        while data:
            if self.left == 0:
                self.head += data[:1]
                data = data[1:]
                size = self.head[1] & 127 if len(self.head) > 1 else 0
                wanted = 2 if len(self.head) < 2 or size < 126 else 4 if size == 126 else 10
                if len(self.head) < wanted:
                    continue
                self.left = size if wanted == 2 else int.from_bytes(self.head[2:], "big")
                self.final = self.head[0] & 128
                self.head = b""
            taken = min(self.left, len(data))
            self.left -= taken
            data = data[taken:]
            done |= self.left == 0 and bool(self.final)
        return done


def crowd(count, port, token, path, end, told):
    os.nice(19)  # clients run elsewhere: what they cost this machine is not the matter
    viewers = [Viewer(k, port, token, path) for k in range(count)]
    ready = selectors.DefaultSelector()
    for one in viewers:
        ready.register(one.socket, selectors.EVENT_READ, one)
    while time.time() < end.value:
        for key, _ in ready.select(0.1):
            key.data.take()
    told.send((sum(one.answers for one in viewers), sum(one.size for one in viewers),
               min(one.answers for one in viewers)))


def memory_mb(pid):
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0


def ride(cell):
    """Until MOVING moves, 3 s at most: its last ride has to end first."""
    end = time.monotonic() + 3
    while time.monotonic() < end:
        if cell.call("robot.status", robot=MOVING)["state"] == "moving":
            return True
        try:
            cell.call("robot.bullride", robot=MOVING, duration_s=30, take_over=True)
        except sinew.Refused:
            pass
        time.sleep(0.05)
    return False


def asked(cell, method, count):
    took = []
    for k in range(count):
        if ROBOTS[k % 5] == MOVING:
            moved.append(ride(cell))
        begun = time.monotonic()
        try:
            cell.call(method, robot=ROBOTS[k % 5])
        except sinew.Refused:
            pass  # nothing moves: a hold has nothing to do, and says so
        took.append((time.monotonic() - begun) * 1e3)
        if ROBOTS[k % 5] == MOVING:
            cell.call("robot.stop", robot=MOVING)  # a ride that is held cannot begin anew
        time.sleep(0.05 + 0.013 * (k % 5))
    return sorted(took)


def words(name, took):
    return (f"{name} median {took[len(took) // 2]:.1f} ms, 90 % {took[len(took) * 9 // 10]:.1f} ms, "
            f"longest {took[-1]:.1f} ms")


def main():
    program = str(Path(sys.argv[1]).resolve())
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 60
    stops = int(sys.argv[3]) if len(sys.argv) > 3 else 100
    with tempfile.TemporaryDirectory() as folder:
        path = folder + "/s"
        server = subprocess.Popen(
            [program, "serve", "--demo", "--socket", path, "--listen", "127.0.0.1:0", "--json"],
            stdout=subprocess.PIPE, text=True, env=dict(os.environ, XDG_STATE_HOME=folder))
        try:
            web = json.loads(server.stdout.readline())["web"]
            port = int(web["url"].split(":")[2].strip("/"))
            token = Path(web["viewer_token_file"]).read_text().strip()
            time.sleep(12)  # the demonstration fills the rings
            with sinew.connect(path) as cell:
                cell.call("robot.stop")
                time.sleep(1)
                before = memory_mb(server.pid)
                peace = asked(cell, "robot.stop", 20)
                end = multiprocessing.Value("d", time.time() + 3600)
                pipe, told = multiprocessing.Pipe(False)
                flood = multiprocessing.Process(target=crowd,
                                                args=(count, port, token, path, end, told))
                flood.start()
                time.sleep(3)
                took = asked(cell, "robot.stop", stops)
                held = asked(cell, "robot.hold", stops // 2)
                during = memory_mb(server.pid)
                end.value = 0
                answers, size, least = pipe.recv()
                flood.join()
                time.sleep(15)
                behind = memory_mb(server.pid)
        finally:
            server.terminate()
            server.communicate(timeout=60)
    print(words("in peace: a stop answered in", peace))
    print(words(f"{count} viewers: a stop answered in", took))
    print(words(f"{count} viewers: a hold answered in", held))
    print(f"{MOVING} moved at {sum(moved)} of {len(moved)} of its stops and holds")
    print(f"{answers} answers ({size >> 20} MB) to viewers, {least} to the one that got the fewest; "
          f"memory {before:.0f} MB before, {during:.0f} MB during, {behind:.0f} MB behind")
    slow = any(one[len(one) // 2] > MEDIAN_MS or one[-1] > WORST_MS for one in (took, held))
    keeps = behind > before + KEPT_MB
    if sum(moved) < len(moved) / 2:
        print(f"{MOVING} stood")
        return 1
    if slow or keeps:
        print("the viewers have delayed a stop" if slow else "memory was not given back")
    return 1 if slow or keeps else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""stop_latency.py SINEW-PROGRAM [STOPS [--realtime]]: from a client's stop to its first byte on the wire.

Real processes: the server, a simulated device in another, a client on the Unix socket, and between
server and device a tap that stamps what passes with the same clock. Once in peace, once with eight
clients that ask without a pause. Each stop comes at a random moment of a motion. Ends with 1 where a stop was never seen on the wire, or where half of
them took longer than two control cycles (4 ms) and a frame.
"""

import json
import multiprocessing
import os
import pty
import random
import select
import subprocess
import sys
import tempfile
import time
import tty
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "clients" / "python"))

import sinew  # noqa: E402

CYCLE_MS = 2.0


class LscEar:
    """A LeArm's frames: 55 55 LENGTH COMMAND ..; where it is told to stay is a move as well."""

    frame_ms = 28 * 10 / 9.6  # the longest one at 9600 baud

    def __init__(self):
        self.bytes = bytearray()

    def hear(self, data):
        self.bytes += data
        targets = []
        while True:
            at = self.bytes.find(b"\x55\x55")
            if at < 0 or len(self.bytes) < at + 4 or len(self.bytes) < at + 2 + self.bytes[at + 2]:
                return targets
            if self.bytes[at + 3] == 3:
                targets.append(bytes(self.bytes[at + 7 : at + 2 + self.bytes[at + 2]]))
            del self.bytes[: at + 2 + self.bytes[at + 2]]


class IcpEar:
    """The hexapod: a stop is that no step follows; the legs' statuses are read instead."""

    frame_ms = 4 * 10 / 9.6 + 5  # an exchange at 9600 baud, and what its modules take

    def __init__(self):
        self.command_is_due = False

    def hear(self, data):
        told = []
        for byte in data:
            if self.command_is_due:
                told.append(b"status" if byte == 0xF0 else b"step")
            # A byte behind F0 names a leg and opens nothing.
            self.command_is_due = byte == 0xFF
        return told


WIRES = {
    f"learm-{profile}": dict(
        robot="learm", options=["--profile", profile], cell=f'profile = "{profile}"', ear=LscEar,
        stand="joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg",
        swing=["joint base=60deg speed=20%", "joint base=-60deg speed=20%"])
    for profile in ("bus", "lsc6", "esp32")
}
# Its device answers each byte, 500 times a second: before everything else on the computer it now and
# then came to a stand for longer than its host waits.
WIRES["hexapod"] = dict(
    before_all=False,
    robot="hexapod", options=[], cell="", ear=IcpEar, run=dict(standing_at=[268.3629e-3] * 6), stand="joint leg1=268.4mm",
    swing=["joint leg1=268.5mm leg2=268.3mm", "joint leg1=268.3mm leg2=268.5mm"])


def not_of_this_computer(wire):
    """Device and tap stand for things that no load of this computer makes slower."""
    if not WIRES[wire].get("before_all", True):
        return
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(30))
    except PermissionError:
        pass


def tap(wire, device, ready, heard):
    """Passes everything on; tells the moment of each frame that the ear counts."""
    not_of_this_computer(wire)
    ear = WIRES[wire]["ear"]()
    host, near = pty.openpty()
    tty.setraw(near)
    far = os.open(device, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(far)
    ready.send(os.ttyname(near))
    while True:
        for source in select.select([host, far], [], [])[0]:
            try:
                data = os.read(source, 4096)
            except OSError:
                return
            if not data:
                return
            if source == host:
                now = time.monotonic()
                for what in ear.hear(data):
                    heard.send((now, what))
            os.write(far if source == host else host, data)


def ask(path):
    with sinew.connect(path) as cell:
        while True:
            cell.call("cell.status")


class HadEnded(Exception):
    """The motion was over before the stop: there was nothing to send."""


def drained(pipe, after, until):
    moments = []
    while True:
        left = until - time.monotonic()
        if not pipe.poll(max(0, left)):
            return [one for one in moments if one[0] >= after]
        moments.append(pipe.recv())


def one_stop(cell, robot, text, pipe, rng):
    """ms from the request to the frame that stops; None where none came."""
    cell.call("program.run", robot=robot, text=text)
    begun = time.monotonic()
    while cell.call("robot.status", robot=robot)["state"] != "moving":
        if time.monotonic() > begun + 10:
            raise SystemExit(f"{robot} does not move: {cell.call('job.status', robot=robot)}")
        time.sleep(0.01)
    moment = time.monotonic() + rng.uniform(0.2, 1.2)
    while time.monotonic() < moment - 0.05:  # a lease lives on messages
        cell.call("robot.status", robot=robot)
        time.sleep(0.05)
    time.sleep(max(0, moment - time.monotonic()))
    drained(pipe, 0, time.monotonic())
    if cell.call("robot.status", robot=robot)["state"] != "moving":
        raise HadEnded
    asked = time.monotonic()
    cell.call("robot.stop", robot=robot)
    moments = drained(pipe, asked, time.monotonic() + 0.5)
    while (cell.call("robot.status", robot=robot)["state"] != "ready"
           or not cell.call("job.status", robot=robot)["over"]):
        time.sleep(0.02)
        if time.monotonic() > asked + 20:
            raise SystemExit(f"{robot} is not ready again: {cell.call('robot.status', robot=robot)}")
    if not moments and cell.call("job.status", robot=robot)["progress"] == 1:
        raise HadEnded  # all of it was sent
    # The order to stay is repeated; on the LeArm's wire it is a move, and one of the motion's own may
    # have been on its way.
    first = next((moment for moment, what in moments if what == moments[-1][1]), None)
    return None if first is None else (first - asked) * 1e3


def measure(program, wire, stops, loaded):
    facts = WIRES[wire]
    rng = random.Random(20261122)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        device = subprocess.Popen([program, "sim", facts["robot"], *facts["options"]],
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                  preexec_fn=lambda: not_of_this_computer(wire))
        ready, told = multiprocessing.Pipe(False)
        pipe, heard = multiprocessing.Pipe(False)
        tapping = multiprocessing.Process(
            target=tap, args=(wire, device.stdout.readline().strip(), told, heard),
            daemon=True)
        tapping.start()
        (place / "cell.toml").write_text(
            f'title = "Stops"\n[[robot]]\nname = "{facts["robot"]}"\nrobot = "{facts["robot"]}"\n'
            f'{facts["cell"]}\nport = "{ready.recv()}"\njournal = "stops"\n')
        environment = dict(os.environ, XDG_STATE_HOME=folder)
        server = subprocess.Popen(
            [program, "serve", str(place / "cell.toml"), "--socket", str(place / "s"), "--listen",
             "none", "--json", *sys.argv[3:]], stdout=subprocess.PIPE, text=True, env=environment)
        json.loads(server.stdout.readline())
        crowd = []
        try:
            took = []
            with sinew.connect(str(place / "s")) as cell:
                robot = cell.robot(facts["robot"])
                with robot.lease() as lease:
                    lease.enable()
                robot.run(facts["stand"], **facts.get("run", {}))
                with robot.lease():
                    if loaded:
                        crowd = [multiprocessing.Process(target=ask, args=(str(place / "s"),),
                                                         daemon=True) for _ in range(8)]
                        for one in crowd:
                            one.start()
                    for k in range(stops):
                        try:
                            took.append(
                                one_stop(cell, facts["robot"], facts["swing"][k % 2], pipe, rng))
                        except HadEnded:
                            while not cell.call("job.status", robot=facts["robot"])["over"]:
                                time.sleep(0.02)
        finally:
            for one in crowd:
                one.kill()
            for process in (server, device):
                process.terminate()
                process.communicate(timeout=60)
            tapping.kill()
    return took


def main():
    program = str(Path(sys.argv[1]).resolve())
    stops = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    code = 0
    for wire, facts in WIRES.items():
        for loaded in (False, True):
            took = measure(program, wire, stops, loaded)
            missed = took.count(None)
            seen = sorted(t for t in took if t is not None)
            at = lambda share: seen[min(len(seen) - 1, int(len(seen) * share))]  # noqa: E731
            bound = 2 * CYCLE_MS + facts["ear"].frame_ms
            bad = missed > 0 or not seen or (not loaded and at(0.5) > bound)
            code |= bad
            print(f"{wire}, {'under load' if loaded else 'in peace'}: {len(seen)} stops, ms to the "
                  f"first byte: median {at(0.5):.1f}, 90 % {at(0.9):.1f}, 99 % {at(0.99):.1f}, worst "
                  f"{seen[-1]:.1f}; never seen {missed}{'; TOO LATE' if bad else ''}", flush=True)
    return code


if __name__ == "__main__":
    sys.exit(main())

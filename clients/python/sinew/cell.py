"""A running cell and its robots. One thread uses a Cell; each wait is bounded."""

import json
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, Iterator, List, Optional, Sequence

from .types import CellDescription, Job, RobotDescription, Status, Truth
from .wires import encode, wire_to

RENEWAL_S = 0.3  # a lease ends a second behind its holder's last message
JOG_INTERVAL_S = 0.05
JOG_EXPIRY_S = 0.3


class Refused(Exception):
    """The cell has answered with an error: `str()` is its sentence."""

    def __init__(self, error: Dict[str, Any]) -> None:
        super().__init__(error.get("message", "refused"))
        self.code: int = error.get("code", 0)
        self.data: Any = error.get("data")


class Cell:
    def __init__(self, wire) -> None:
        self._wire = wire
        self._last_id = 0
        self._spoke = 0.0
        self._messages: Deque[Dict[str, Any]] = deque(maxlen=1000)
        self._holds: set = set()
        # Leases count the cell's time, which a simulated one may let run faster.
        self._renewal_s = RENEWAL_S
        self.time_scale = float(self.describe().get("time_scale", 1))
        self._renewal_s = RENEWAL_S / max(1.0, self.time_scale)

    def __enter__(self) -> "Cell":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        """Leases end with the connection, and with them what they moved."""
        self._wire.close()

    def call(self, method: str, timeout_s: float = 60, **params: Any) -> Any:
        """One request and its answer. Raises Refused, TimeoutError, ConnectionError."""
        number = self._send(method, params)
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            self._renew()
            text = self._wire.receive(min(self._renewal_s, end - time.monotonic()))
            if text is None:
                continue
            message = json.loads(text)
            if "method" in message:
                self._messages.append(message)
            elif message.get("id") == number:
                if "error" in message:
                    raise Refused(message["error"])
                return message["result"]
        raise TimeoutError(f"{method}: no answer within {timeout_s} s")

    def _renew(self) -> None:
        if self._holds:
            self._speak()

    def _speak(self) -> None:
        """Leases, and programs that have taken theirs, live while their holder says something."""
        if time.monotonic() - self._spoke > self._renewal_s:
            self._send("lease.renew", {})

    def _send(self, method: str, params: Dict[str, Any]) -> int:
        self._last_id += 1
        self._spoke = time.monotonic()
        self._wire.send(encode(self._last_id, method, params))
        return self._last_id

    def next_message(self, timeout_s: float = 1) -> Optional[Dict[str, Any]]:
        """The next `status`, `job`, `event` or `objects` message; None after the time."""
        end = time.monotonic() + timeout_s
        while not self._messages:
            left = end - time.monotonic()
            if left <= 0:
                return None
            self._renew()
            text = self._wire.receive(min(self._renewal_s, left))
            if text is not None:
                message = json.loads(text)
                if "method" in message:
                    self._messages.append(message)
        return self._messages.popleft()

    def describe(self) -> CellDescription:
        return self.call("cell.describe")

    def statuses(self) -> List[Status]:
        return self.call("cell.status")["robots"]

    def stop(self) -> None:
        """All robots, to rest."""
        self.call("robot.stop")

    def robot(self, name: str) -> "Robot":
        """Raises Refused where the cell has none of that name."""
        return Robot(self, name)

    def robots(self) -> List["Robot"]:
        return [Robot(self, one["name"]) for one in self.describe()["robots"]]


class Robot:
    def __init__(self, cell: Cell, name: str) -> None:
        self.cell = cell
        self.name = name
        self.status()

    def status(self) -> Status:
        return self.cell.call("robot.status", robot=self.name)

    def description(self) -> RobotDescription:
        return next(one for one in self.cell.describe()["robots"] if one["name"] == self.name)

    def truth(self) -> Truth:
        """Where a simulated machine really stands."""
        return self.cell.call("simulation.truth", robot=self.name)

    def stop(self) -> None:
        self.cell.call("robot.stop", robot=self.name)

    def wait_until_ready(self, timeout_s: float = 20) -> None:
        """At rest, and able to move. Raises TimeoutError with the state that it is in."""
        end = time.monotonic() + timeout_s
        while (state := self.status()["state"]) != "ready":
            if time.monotonic() > end:
                raise TimeoutError(f"{self.name} is {state} and not ready after {timeout_s} s")
            self.cell.next_message(0.02)

    def lease(self, take_over: bool = False) -> "Lease":
        """The right to move, for as long as the `with` lasts."""
        return Lease(self, take_over)

    def run(self, program: str, timeout_s: float = 3600,
            watch: Optional[Callable[[Job], None]] = None, **options: Any) -> Job:
        """Runs rows as in docs/programs.md, and waits for their end.

        watch: called with the job each time it is looked at.
        Raises Refused where it is refused, fails or is stopped.
        """
        number = self.cell.call("program.run", robot=self.name, text=program, **options)["job"]
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            # Asking keeps the lease alive, too.
            job: Job = self.cell.call("job.status", robot=self.name)
            if watch is not None:
                watch(job)
            if job["job"] != number:
                raise Refused({"message": f"another program runs on {self.name}"})
            if job["over"]:
                break
            self.cell.next_message(0.05)
        else:
            self.stop()
            raise TimeoutError(f"the program did not end within {timeout_s} s; it is stopped")
        if job["phase"] != "done":
            error = job.get("error", {})
            sentence = error.get("sentence", f"stopped by {job.get('stopped_by', 'somebody')}")
            raise Refused({"message": sentence, "data": error})
        return job

    def samples(self, program: str, rate_hz: float = 50) -> Iterator[Status]:
        """Runs rows, and gives how the robot is meanwhile, `rate_hz` times a second."""
        number = self.cell.call("program.run", robot=self.name, text=program)["job"]
        self.cell.call("watch", rate_hz=rate_hz, robot=self.name)
        begun = False
        try:
            while True:
                self.cell._speak()
                message = self.cell.next_message(self.cell._renewal_s)
                if message is None or message["method"] != "status":
                    continue
                status: Status = message["params"]["robots"][0]
                yield status
                job = status.get("job", {})
                begun = begun or job.get("job") == number
                if begun and job.get("job") != number:
                    raise Refused({"message": f"another program runs on {self.name}"})
                if begun and job.get("over"):
                    if job["phase"] != "done":
                        raise Refused({"message": job.get("error", {}).get("sentence", "stopped"),
                                       "data": job.get("error")})
                    return
        finally:
            self.cell.call("watch", rate_hz=0)


class Lease:
    def __init__(self, robot: Robot, take_over: bool) -> None:
        self._robot = robot
        self._take_over = take_over

    def __enter__(self) -> "Lease":
        self._robot.cell.call("lease.take", robot=self._robot.name, take_over=self._take_over)
        self._robot.cell._holds.add(self._robot.name)
        return self

    def __exit__(self, *_) -> None:
        self._robot.cell._holds.discard(self._robot.name)
        try:
            self._robot.cell.call("lease.release", robot=self._robot.name)
        except (Refused, ConnectionError):
            pass  # it had ended already

    def enable(self) -> None:
        """Finds the device; nothing where it is found already."""
        if self._robot.status()["state"] != "ready":
            self._robot.cell.call("robot.enable", robot=self._robot.name)
        self._robot.wait_until_ready()

    def jog(self, frame: str, velocity: Sequence[float], duration_s: float) -> None:
        """This velocity for so long, and then to rest.

        frame: joint, base, tool or platform. velocity: rad/s and m/s, as docs/api.md has it.
        It ends by itself 0.3 s behind the last message (real time, however fast the cell's runs),
        whatever becomes of this program. Where this program was late, and it has ended so, it
        begins again.
        """
        end = time.monotonic() + duration_s
        late = False
        while time.monotonic() < end:
            try:
                self._robot.cell.call("robot.jog", robot=self._robot.name, frame=frame,
                                      velocity=list(velocity), expiry_s=JOG_EXPIRY_S)
                late = False
            except Refused:
                if late:
                    raise
                late = True
                self._robot.wait_until_ready()
                continue
            pause = min(JOG_INTERVAL_S, end - time.monotonic())
            if pause > 0:
                time.sleep(pause)
        self._robot.stop()
        self._robot.wait_until_ready()


def connect(address: Optional[str] = None, token: Optional[str] = None,
            ca_file: Optional[str] = None) -> Cell:
    """A running cell.

    address: nothing for this user's own Unix socket; another socket's path; or the link that
        `sinew serve` prints, http://127.0.0.1:8700/#token=..., also without its token.
    token: of the network door; where neither this nor the link has one, this user's own.
    ca_file: certificates to trust beside https, where the system does not know the server's.
    """
    return Cell(wire_to(address, token, ca_file))

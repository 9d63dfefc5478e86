"""How texts come and go: a Unix socket (standard library), or a WebSocket (python3-websockets)."""

import json
import os
import queue
import socket
import threading
import time
from pathlib import Path
from typing import Optional, Tuple
from urllib.parse import urlsplit

# Messages that nobody has read yet: beyond them old statuses go, all else stays with the server.
WAITING_MAX = 256
MESSAGE_MAX = 64 * 1024 * 1024  # bytes; answers of a server that this user trusts


class UnixWire:
    """A message a line."""

    def __init__(self, path: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.connect(path)
        self._received = b""

    def send(self, text: str) -> None:
        self._socket.sendall(text.encode() + b"\n")

    def receive(self, timeout_s: float) -> Optional[str]:
        """The next message, or None after the time. Raises ConnectionError at the end."""
        self._socket.settimeout(max(timeout_s, 0.001))
        try:
            while b"\n" not in self._received:
                part = self._socket.recv(65536)
                if not part:
                    raise ConnectionError("the cell has gone away")
                self._received += part
        except (TimeoutError, socket.timeout):
            return None
        finally:
            self._socket.settimeout(None)
        line, self._received = self._received.split(b"\n", 1)
        return line.decode()

    def close(self) -> None:
        self._socket.close()


class WebWire:
    """A message a frame. The library is asyncio's, so it has a thread of its own."""

    def __init__(self, url: str, token: str, ca_file: Optional[str] = None) -> None:
        try:
            import websockets  # noqa: F401
        except ImportError as error:
            raise ImportError("over the network this needs websockets: on Debian, apt-get install "
                              "python3-websockets; on this machine sinew.connect() needs nothing"
                              ) from error
        import asyncio
        self._incoming: "queue.Queue[str]" = queue.Queue(WAITING_MAX)
        self._ended = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        try:
            self._socket = asyncio.run_coroutine_threadsafe(
                self._open(url, token, ca_file), self._loop).result(30)
        except BaseException:
            self._end_loop()
            raise

    async def _open(self, url, token, ca_file):
        import asyncio
        import ssl

        import websockets
        secured = {}
        if url.startswith("wss:"):
            secured["ssl"] = ssl.create_default_context(cafile=ca_file)
        try:
            opened = await websockets.connect(
                url, subprotocols=["sinew.v1", "bearer." + token], compression=None,
                max_size=MESSAGE_MAX, max_queue=256, open_timeout=20, **secured)
        except websockets.exceptions.InvalidHandshake as error:
            # Where the status stands depends on the library's version: 10 (Debian 12), 15 (13).
            status = getattr(error, "status_code", None) or getattr(
                getattr(error, "response", None), "status_code", None)
            if status is None:
                raise
            raise ConnectionError({
                401: "the token is not the one of this server",
                403: "the server does not serve this origin",
                421: "the server is not called so",
                429: "too many wrong tokens came from here; wait a minute",
                503: "the server has as many clients as it serves"}.get(
                    status, f"the server answered {status}")) from error
        self._reader = asyncio.ensure_future(self._read(opened))
        return opened

    async def _read(self, opened):
        import asyncio
        try:
            async for message in opened:
                while self._incoming.full() and not self._make_room():
                    await asyncio.sleep(0.01)
                self._incoming.put(message)
        except Exception:  # however it ended, it did
            pass
        self._ended.set()

    def _make_room(self) -> bool:
        """Of statuses that nobody has read the newer ones count; all else waits for its reader."""
        with self._incoming.mutex:
            for i, text in enumerate(self._incoming.queue):
                if '"method":"status"' in text[:60]:
                    del self._incoming.queue[i]
                    return True
        return False

    def send(self, text: str) -> None:
        import asyncio
        try:
            asyncio.run_coroutine_threadsafe(self._socket.send(text), self._loop).result(30)
        except Exception as error:
            raise ConnectionError("the cell has gone away") from error

    def receive(self, timeout_s: float) -> Optional[str]:
        """As UnixWire.receive."""
        end = time.monotonic() + max(timeout_s, 0.001)
        while True:
            ended = self._ended.is_set()  # before the look: what had come by then is there
            try:
                left = max(end - time.monotonic(), 0.001)
                return self._incoming.get(timeout=0 if ended else min(0.1, left))
            except queue.Empty:
                if ended:
                    raise ConnectionError("the cell has gone away") from None
                if time.monotonic() >= end:
                    return None

    def close(self) -> None:
        import asyncio
        try:
            asyncio.run_coroutine_threadsafe(self._socket.close(), self._loop).result(10)
        except Exception:  # it may be gone already
            pass
        self._end_loop()

    def _end_loop(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)
        self._loop.close()


def own_socket() -> str:
    """Where this user's `sinew serve` answers."""
    folder = os.environ.get("XDG_RUNTIME_DIR", "")
    return f"{folder}/sinew/cell.sock" if folder else f"/tmp/sinew-{os.getuid()}/cell.sock"


def own_token(role: str = "operator") -> str:
    """The token that this user's `sinew serve` made at its first start."""
    state = os.environ.get("XDG_STATE_HOME", "")
    folder = Path(state) if state.startswith("/") else Path.home() / ".local" / "state"
    return (folder / "sinew" / "web" / f"{role}.token").read_text().strip()


def place_of(address: str, token: Optional[str]) -> Tuple[str, str]:
    """The URL of the WebSocket and the token, of a link as the start line prints it."""
    parts = urlsplit(address)
    scheme = {"http": "ws", "https": "wss", "ws": "ws", "wss": "wss"}[parts.scheme]
    if token is None and parts.fragment.startswith("token="):
        token = parts.fragment[len("token="):]
    return f"{scheme}://{parts.netloc}/ws", token if token is not None else own_token()


def wire_to(address: Optional[str], token: Optional[str], ca_file: Optional[str]):
    if address is not None and "://" in address:
        return WebWire(*place_of(address, token), ca_file)
    return UnixWire(address if address is not None else own_socket())


def encode(number: int, method: str, params: dict) -> str:
    return json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": params})

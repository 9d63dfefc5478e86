"""For tests: a simulated cell that is served for all of them; its files go behind them."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path


class ServedCell(unittest.TestCase):
    """One server for all tests of a class: each leaves its robots at rest."""

    PROGRAM = ""  # set before the tests run
    CELL = ""     # the text of its file, of each class

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        folder = Path(cls.folder.name)
        (folder / "cell.toml").write_text(cls.CELL)
        os.environ["XDG_STATE_HOME"] = str(folder / "state")
        os.environ["XDG_RUNTIME_DIR"] = str(folder)
        cls.socket = str(folder / "cell.sock")
        cls.server = subprocess.Popen(
            [cls.PROGRAM, "serve", str(folder / "cell.toml"), "--socket", cls.socket, "--listen",
             "127.0.0.1:0", "--program-folder", str(folder / "kept"), "--json"],
            stdout=subprocess.PIPE, text=True)
        cls.begun = json.loads(cls.server.stdout.readline())
        cls.url = cls.begun["web"]["url"]

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        cls.server.communicate(timeout=60)
        cls.folder.cleanup()

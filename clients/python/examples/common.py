"""What the examples share: where the cell is, and how a refusal ends."""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import sinew  # noqa: E402


def parser(what: str, robot: str) -> argparse.ArgumentParser:
    made = argparse.ArgumentParser(description=what)
    made.add_argument("--cell", help="a socket's path, or the link that sinew serve prints; this "
                                     "user's own socket where left out")
    made.add_argument("--robot", default=robot, help="its name in the cell (%(default)s)")
    return made


def main(run) -> None:
    """run(): an example. What the cell refuses is told in its sentence."""
    try:
        run()
    except sinew.Refused as refused:
        sys.exit(f"refused: {refused}")
    except (ConnectionError, FileNotFoundError, TimeoutError) as error:
        sys.exit(f"{error}; is sinew serve running?")

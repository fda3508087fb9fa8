"""The program efam: `python -m efam` is the same."""

import signal
import sys

from ._efam import main as program


def main() -> None:
    """Runs the program and ends with its exit code."""
    # The program has its own answer to Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(program(["efam", *sys.argv[1:]]))


if __name__ == "__main__":
    main()

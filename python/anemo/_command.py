"""The command line `anemo`, as pip installs it."""

import os
import signal
import sys

from ._anemo import main as run


def main() -> None:
    # The command hears of Ctrl-C itself; Python would keep it from that.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # What hands work to other processes starts this again, not Python.
    os.environ["ANEMO_PROGRAM"] = os.path.abspath(sys.argv[0])
    sys.exit(run(sys.argv[1:]))

"""The command line `anemo`, as pip installs it."""

import signal
import sys

from ._anemo import main as run


def main() -> None:
    # The command hears of Ctrl-C itself; Python would keep it from that.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run(sys.argv[1:]))

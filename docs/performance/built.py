"""What the comparisons share: one thread for all libraries, and the examples that cargo has built.

Imported before numpy, which counts its threads then.
"""
import os
import sys
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ.setdefault(name, "1")

ROOT = Path(__file__).resolve().parents[2]


def example(name):
    """An example of the crate `anemo-tests`."""
    program = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/examples" / name
    if not program.exists():
        sys.exit(f"{program} is not there: build it with `cargo build --release -p anemo-tests --example {name}`")
    return program


def numbers(*usual):
    """Whole numbers of the command line, or these."""
    given = [int(value) for value in sys.argv[1 : len(usual) + 1]]
    return [*given, *usual[len(given) :]]

"""What several tests begin with."""

import signal
from pathlib import Path

import anemo
import numpy as np
import pytest
from scipy.signal import lfilter

# What runs in the background of a shell ignores Ctrl-C, and its children do so, too.
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).resolve().parents[2]
EXPERIMENTS = ROOT / "experiments"


@pytest.fixture(scope="session")
def prbs() -> anemo.Table:
    """An hour of pseudo-random heating, simulated."""
    return anemo.simulate(EXPERIMENTS / "prbs.toml")


def heater(seed: int, rows: int = 40_000) -> dict[str, np.ndarray]:
    """A body of 10 K/W at 0.05 rad/s and 3 K/W at 1 rad/s, driven by chance bits of 2 s, with noise."""
    chance = np.random.default_rng(seed)
    power = np.repeat(chance.integers(0, 2, rows // 20), 20).astype(float)
    rise = sum(r * lfilter([0, 1 - np.exp(-0.1 * rate)], [1, -np.exp(-0.1 * rate)], power) for r, rate in POLES)
    return {
        "time_s": np.arange(rows) * 0.1,
        "power_w_core": power,
        "temperature_c_core": 20 + rise + 0.01 * chance.standard_normal(rows),
    }


POLES = [(10.0, 0.05), (3.0, 1.0)]


@pytest.fixture(scope="session")
def model() -> anemo.Model:
    """What such a record shows."""
    return anemo.identify(heater(1), free_poles=2, feed_through=False, dead_time=0)


@pytest.fixture
def short(tmp_path: Path) -> Path:
    """The same experiment for a minute."""
    text = (EXPERIMENTS / "prbs.toml").read_text()
    head = (ROOT / "heads").as_posix()
    lines = ["duration_s = 60.0" if line.startswith("duration_s") else line for line in text.splitlines()]
    path = tmp_path / "short.toml"
    path.write_text("\n".join(lines).replace("../heads", head))
    return path

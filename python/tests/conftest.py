"""What several tests begin with."""

from pathlib import Path

import anemo
import pytest

ROOT = Path(__file__).resolve().parents[2]
EXPERIMENTS = ROOT / "experiments"


@pytest.fixture(scope="session")
def prbs() -> anemo.Table:
    """An hour of pseudo-random heating, simulated."""
    return anemo.simulate(EXPERIMENTS / "prbs.toml")


@pytest.fixture(scope="session")
def model(prbs: anemo.Table) -> anemo.Model:
    """What it shows of its first sector."""
    return anemo.identify(prbs, input="sector1", output="sector1", order=6, drift="none")


@pytest.fixture
def short(tmp_path: Path) -> Path:
    """The same experiment for a minute."""
    text = (EXPERIMENTS / "prbs.toml").read_text()
    head = (ROOT / "heads").as_posix()
    lines = ["duration_s = 60.0" if line.startswith("duration_s") else line for line in text.splitlines()]
    path = tmp_path / "short.toml"
    path.write_text("\n".join(lines).replace("../heads", head))
    return path

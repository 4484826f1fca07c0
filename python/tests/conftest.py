"""What several tests begin with."""

import getpass
import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
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


SLURM = ["munged", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue", "scancel"]
SLURM_CONF = """\
ClusterName=anemo
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0
SchedulerType=sched/builtin
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
NodeName=n1 NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 RealMemory=1000
NodeName=n2 NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 RealMemory=1000
PartitionName=day Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A cluster with Slurm on this computer: a controller and two nodes of one core."""
    monkeypatch.setenv("PATH", f"{os.environ['PATH']}:/usr/sbin")
    missing = [program for program in SLURM if shutil.which(program) is None]
    if missing and os.environ.get("ANEMO_COUNTERPARTS") != "all":
        pytest.skip(f"{missing[0]} is absent: cargo xtask counterparts --slurm installs it")
    assert not missing, f"{missing[0]} is absent: cargo xtask counterparts --slurm installs it"
    folder = tmp_path / "slurm"
    for name in ("state", "spool-n1", "spool-n2"):
        (folder / name).mkdir(parents=True)
    # Bound all at once, so that they differ.
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(3)]
    ports = [bound.getsockname()[1] for bound in sockets]
    for bound in sockets:
        bound.close()
    (folder / "slurm.conf").write_text(SLURM_CONF.format(folder=folder, ports=ports, user=getpass.getuser()))
    (folder / "munge.key").write_bytes(b"Z" * 128)
    (folder / "munge.key").chmod(0o600)
    monkeypatch.setenv("SLURM_CONF", str(folder / "slurm.conf"))
    files = ["socket=munge.socket", "key-file=munge.key", "pid-file=munged.pid", "log-file=munged.log"]
    files.append("seed-file=munged.seed")
    munged = ["munged", "--force", *("--" + file.replace("=", f"={folder}/") for file in files)]
    try:
        for command in (munged, ["slurmctld"], ["slurmd", "-N", "n1"], ["slurmd", "-N", "n2"]):
            subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=60)
        deadline = time.monotonic() + 90
        while (said := subprocess.check_output(["sinfo", "-h", "-N", "-o", "%t"], text=True)) != "idle\nidle\n":
            assert time.monotonic() < deadline, said + (folder / "slurmctld.log").read_text()
            time.sleep(0.1)
        yield
        # A node outlives its signal while it has a job.
        deadline = time.monotonic() + 60
        while subprocess.check_output(["squeue", "-h"]) and time.monotonic() < deadline:
            time.sleep(0.1)
    finally:
        for name in ("slurmd-n1", "slurmd-n2", "slurmctld", "munged"):
            if (folder / f"{name}.pid").exists():
                os.kill(int((folder / f"{name}.pid").read_text()), signal.SIGTERM)

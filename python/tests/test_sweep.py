"""A sweep by the workers of Dask comes to what the plain one comes to."""

import os
import signal
import threading
import time
from pathlib import Path

import anemo
import pyarrow.parquet as pq
import pytest
from conftest import EXPERIMENTS

distributed = pytest.importorskip("distributed", reason="the sweep by Dask needs dask.distributed")

SWEEP = """\
experiment = "{experiments}/steady.toml"

[[vary]]
key = "duration_s"
values = [{duration_s}]

[[vary]]
key = "wind.speed_m_s"
range = [1.0, 16.0]
scale = "log"
steps = 12
"""


def hashes(report: anemo.Report) -> dict[str, str]:
    table = pq.read_table(report.results)
    return dict(zip(table["run"].to_pylist(), table["result_hash"].to_pylist(), strict=True))


def attempts(folder: Path) -> dict[str, int]:
    logs = folder.glob("run=*/attempts.log")
    return {log.parent.name: len(log.read_text().splitlines()) for log in logs}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "winds.toml"
    # Runs of about a second, so that one can be killed in the middle.
    path.write_text(SWEEP.format(experiments=EXPERIMENTS.as_posix(), duration_s=6000.0))
    return path


def test_a_sweep_gives_a_report_and_a_table(file, tmp_path):
    report = anemo.sweep(file, output=tmp_path / "plain")
    assert (report.complete, report.failed, report.missing) == (12, [], [])
    assert "12 complete" in str(report)
    again = anemo.sweep(file, output=tmp_path / "plain", jobs=1)
    assert again == report and set(attempts(tmp_path / "plain").values()) == {1}
    with pytest.raises(anemo.Error, match="there is no such file|No such file"):
        anemo.sweep(tmp_path / "none.toml")


def test_workers_of_dask_come_to_the_same_and_only_what_a_killed_one_did_is_done_again(file, tmp_path):
    plain = anemo.sweep(file, output=tmp_path / "plain")
    folder = tmp_path / "dask"
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            pids = client.run(os.getpid)
            killed = []

            def kill() -> None:
                # Once it has done something, and in the middle of the next.
                while len(list(folder.glob("run=*/result.json"))) < 3:
                    time.sleep(0.02)
                began = len(attempts(folder))
                while len(attempts(folder)) == began:
                    time.sleep(0.005)
                victim = next(iter(pids.values()))
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)

            threading.Thread(target=kill, daemon=True).start()
            report = anemo.sweep(file, client, output=folder)
    assert killed, "the sweep was over before a worker could be killed"
    assert report.complete == 12 and hashes(report) == hashes(plain)
    counts = sorted(attempts(folder).values())
    # One run at most was under way on the worker that died.
    assert counts[:-1] == [1] * 11 and counts[-1] in (1, 2), counts

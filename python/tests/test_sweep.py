"""Sweeps: their designs, what they repeat and what not, what fails, and who does the work."""

import functools
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import anemo
import numpy as np
import pyarrow.parquet as pq
import pytest
from conftest import EXPERIMENTS, ROOT
from scipy import stats

distributed = pytest.importorskip("distributed", reason="sweeps need dask.distributed")

from anemo._sweep import combinations  # noqa: E402

STEADY = EXPERIMENTS / "steady.toml"
SECOND = {"duration_s": [1.0]}


def test_a_script_from_stdin_sweeps(tmp_path):
    script = f"""
import anemo

table = anemo.sweep({str(STEADY)!r}, {{"seed": [1, 2]}}, results={str(tmp_path / "out")!r})
print(len(table), set(map(str, table["failed"])))
"""
    done = subprocess.run([sys.executable, "-"], input=script, capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == "2 {''}", done.stderr


def killed_once(marker: Path) -> None:
    """Kills the worker, unless one was killed before."""
    try:
        marker.touch(exist_ok=False)
    except FileExistsError:
        return
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.fixture(scope="module")
def client():
    """Two workers with one thread each."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


@pytest.fixture
def sweep(client, tmp_path):
    """The sweep by those workers, in a folder of its own."""
    return functools.partial(anemo.sweep, client=client, results=tmp_path / "out")


def noted(log: Path, table: anemo.Table) -> dict[str, int]:
    """A line for each run, with its seed; gives the number of rows."""
    with log.open("a") as file:
        file.write(re.search(r'seed"? = (\d+)', table.metadata["experiment"])[1] + "\n")
    return {"rows": len(table)}


def lines(log: Path) -> list[int]:
    return sorted(int(line) for line in log.read_text().splitlines())


def test_a_grid_is_every_combination_and_each_run_the_one_made_by_hand(sweep, tmp_path):
    table = sweep(STEADY, {**SECOND, "wind.speed_m_s": np.array([1.0, 4.0]), "seed": [1, 2]})
    assert list(zip(table["wind_speed_m_s"], table["seed"])) == [(1.0, 1.0), (1.0, 2.0), (4.0, 1.0), (4.0, 2.0)]
    assert set(table["failed"]) == {""}
    assert table.report == {"runs": 4, "failed": 0, "results": str(tmp_path / "out/results.parquet")}
    text = STEADY.read_text().replace("../heads", (ROOT / "heads").as_posix())
    text = re.sub(r"duration_s = \S+", "duration_s = 1.0", re.sub(r"speed_m_s = \S+", "speed_m_s = 4.0", text))
    by_hand = tmp_path / "by-hand.toml"
    by_hand.write_text("seed = 2\n" + re.sub(r"(?m)^seed = .*$", "", text))
    run = anemo.simulate(by_hand)
    assert table["hash"][3] == run.report.hash and len(set(table["run"])) == 4
    assert table["elements_core1_mean_power_w"][3] == run.report.elements["core1"]["mean_power_w"]
    last = run["power_w_core1"][3 * len(run) // 4 :]
    assert table["steady_power_w_core1"][3] == last.mean()
    assert pq.read_table(tmp_path / "out/results.parquet").column("run").to_pylist() == list(table["run"])
    # The files of a run are an experiment.
    folder = tmp_path / "out" / f"run={table['run'][3]}"
    assert anemo.simulate(folder / "steady.toml").report.hash == run.report.hash


def test_a_latin_hypercube_is_once_in_every_part_of_every_distribution(sweep):
    columns = [stats.uniform(0, 1), stats.loguniform(1, 1e4), list("abcd"), stats.randint(0, 4)]
    drawn = combinations(["a", "b", "c", "d"], columns, "latin", 100, 7)
    share = [[value for value, *_ in drawn], [np.log10(value) / 4 for _, value, *_ in drawn]]
    parts = [[int(100 * one) for one in of] for of in share]
    assert parts[0] != parts[1] and [sorted(of) for of in parts] == [list(range(100))] * 2
    assert [[one[2] for one in drawn].count(letter) for letter in "abcd"] == [25] * 4
    assert [[one[3] for one in drawn].count(whole) for whole in range(4)] == [25] * 4
    table = sweep(STEADY, {**SECOND, "wind.speed_m_s": stats.loguniform(1, 16)}, method="latin", samples=4)
    assert sorted(np.log2(table["wind_speed_m_s"]).astype(int)) == [0, 1, 2, 3] and set(table["failed"]) == {""}


def test_random_values_are_uniform_the_same_again_and_another_key_leaves_them(sweep):
    one = stats.uniform(-1, 2)
    draw = lambda names, seed: np.array(combinations(names, [one] * len(names), "random", 4000, seed))  # noqa: E731
    alone, both = draw(["a"], 3), draw(["b", "a"], 3)
    assert np.array_equal(alone[:, 0], both[:, 1]) and not np.array_equal(both[:, 0], both[:, 1])
    assert not np.array_equal(alone, draw(["a"], 4))
    # Mean of 4000 uniform numbers in (-1, 1): 0 +- 0.0091, here within five of these.
    assert abs(alone.mean()) < 0.046
    table = sweep(STEADY, {**SECOND, "seed": stats.randint(1, 1000)}, method="random", samples=3)
    assert len(set(table["run"])) == 3 and table["seed"].max() > 3


def test_finished_runs_are_not_repeated_and_changed_ones_are(sweep, tmp_path):
    log, head, read = tmp_path / "log", tmp_path / "head.toml", tmp_path / "read.txt"
    named = re.search(r'head = "\.\./(\S+)"', STEADY.read_text())[1]
    head.write_text((ROOT / named).read_text())
    read.write_text("one")
    then = functools.partial(noted, log)
    vary = {**SECOND, "head": [head], "seed": [1, 2]}
    first = sweep(STEADY, vary, then=then, reads=[read])
    assert lines(log) == [1, 2] and list(first["rows"]) == list(first["ticks"])
    again = sweep(STEADY, {**vary, "seed": [2, 3, 2]}, then=then, reads=[read])
    assert lines(log) == [1, 2, 3] and list(again["seed"]) == [2, 3, 2]
    assert again["run"][0] == first["run"][1] == again["run"][2]
    # A comment changes nothing, another limit or word does.
    head.write_text("# A comment.\n" + head.read_text())
    sweep(STEADY, vary, then=then, reads=[read])
    assert len(lines(log)) == 3
    head.write_text(head.read_text().replace('name = "', 'name = "other ', 1))
    sweep(STEADY, vary, then=then, reads=[read])
    assert lines(log) == [1, 1, 2, 2, 3]
    read.write_text("two")
    sweep(STEADY, vary, then=then, reads=[read])
    assert len(lines(log)) == 7
    other = tmp_path / "other"
    sweep(STEADY, vary, then=functools.partial(noted, other), reads=[read])
    assert lines(other) == [1, 2]


def test_the_code_of_then_and_what_it_refers_to_count(sweep):
    factor = 2.0

    def helper(table):
        return factor * len(table)

    def scaled(table):
        return {"scaled": helper(table)}

    one = sweep(STEADY, SECOND, then=scaled)
    factor = 3.0
    two = sweep(STEADY, SECOND, then=scaled)
    assert one["run"][0] != two["run"][0] and two["scaled"][0] == 1.5 * one["scaled"][0]
    functions = [lambda table: {"a": 1}, lambda table: {"a": 2}, lambda table: {"a": 1}]
    keys = [sweep(STEADY, SECOND, then=then)["run"][0] for then in functions]
    assert keys[0] == keys[2] != keys[1]


def test_a_run_that_fails_stands_in_the_table_and_is_tried_again(sweep, tmp_path):
    vary = {**SECOND, "wind.speed_m_s": [1.0, -1.0]}
    with pytest.warns(UserWarning, match="1 of 2 runs failed"):
        table = sweep(STEADY, vary)
    assert table["failed"][0] == "" and "speed_m_s" in table["failed"][1] and "\n" not in table["failed"][1]
    assert np.isnan(table["steady_power_w_core1"][1]) and table.report.failed == 1
    log = tmp_path / "log"

    def stumble(table):
        noted(log, table)
        raise ValueError("no\nluck")

    for attempts in (1, 2):
        with pytest.warns(UserWarning, match="1 of 1 runs failed"):
            assert sweep(STEADY, SECOND, then=stumble)["failed"][0] == "ValueError: no luck"
        assert len(lines(log)) == attempts
    with pytest.warns(UserWarning):
        assert "`then` gives the column `hash`" in sweep(STEADY, SECOND, then=lambda table: {"hash": 1})["failed"][0]


def test_only_the_run_of_a_killed_worker_is_begun_twice(sweep, tmp_path):
    log, marker = tmp_path / "log", tmp_path / "killed"

    def then(table):
        found = noted(log, table)
        # In the middle of the fourth run that is begun.
        if len(lines(log)) >= 4:
            killed_once(marker)
        return found

    plain = anemo.sweep(STEADY, {"duration_s": [60.0], "seed": list(range(1, 13))}, results=tmp_path / "plain")
    table = sweep(STEADY, {"duration_s": [60.0], "seed": list(range(1, 13))}, then=then)
    assert marker.exists() and set(table["failed"]) == {""}
    assert list(table["hash"]) == list(plain["hash"])
    assert len(lines(log)) == 13 and set(lines(log)) == set(range(1, 13))


def test_a_run_that_kills_every_worker_has_failed(tmp_path):
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        cluster.scheduler.allowed_failures = 1
        with distributed.Client(cluster) as client, pytest.warns(UserWarning, match="1 of 1 runs failed"):
            kill = lambda table: os.kill(os.getpid(), signal.SIGKILL)  # noqa: E731
            table = anemo.sweep(STEADY, SECOND, then=kill, client=client, results=tmp_path)
    assert table["failed"][0].startswith("its worker failed: ")


def test_several_experiments_are_one_run_and_recordings_are_kept(sweep, tmp_path):
    names = ["steady.toml", "still-gas.toml"]
    table = sweep(
        [EXPERIMENTS / name for name in names],
        SECOND,
        then=lambda steady, still: {"rows": [len(steady), len(still)]},
        recordings=True,
    )
    assert table["rows_0"][0] == table["steady_ticks"][0] and table["still_gas_hash"][0] != table["steady_hash"][0]
    folder = tmp_path / "out" / f"run={table['run'][0]}"
    assert len(anemo.load(folder / "still-gas.parquet")) == table["rows_1"][0]


def test_keys_lead_into_head_and_lists_and_take_one_value_together(sweep, tmp_path):
    table = sweep(STEADY, {**SECOND, ("wind[0].speed_m_s", "wind[0].elevation_deg"): [3.0], "head.name": ["own"]})
    assert table["head"][0] == "own" and table["wind_0_speed_m_s"][0] == 3.0
    folder = tmp_path / "out" / f"run={table['run'][0]}"
    content = anemo.Experiment.read(folder / "steady.toml").content
    assert content["wind"][0]["elevation_deg"] == content["wind"][0]["speed_m_s"] == 3.0


WRONG = [
    ({"wind.sped_m_s": [1.0]}, {}, r"no run of the sweep can be read; the first: steady.toml.*`sped_m_s`.*`speed_m_s`"),
    ({"gass.temperature_c": [1.0]}, {}, "`gass`.*`gas`"),
    ({"duration_s": ["long"]}, {}, "duration_s"),
    ({"title.x": [1]}, {}, "`title` is no table that could have a key `x`"),
    ({"wind[7].speed_m_s": [1]}, {}, "`wind` has no entry 7"),
    ({"wind[x].speed_m_s": [1]}, {}, "is no key: one reads as"),
    ({"models.x": [1]}, {}, "steady.models.toml.*unknown key `x`"),
    ({"device.x": [1]}, {}, "steady.toml names no `device`"),
    ({"seed": [object()]}, {}, "a TOML file has no such value"),
    ({"seed": []}, {}, "`seed` has no values, so there are no runs"),
    ({}, {}, "nothing is varied"),
    ({"seed": [1], ("seed", "title"): [1]}, {}, "varied twice"),
    ({"head": ["none.toml"]}, {}, "none.toml: No such file"),
    ({"experiment": [STEADY]}, {}, "give an experiment, or vary"),
    ({"seed": [1]}, {"samples": 3}, "`samples`, 1 or more"),
    ({"seed": [1]}, {"method": "random"}, "`samples`, 1 or more"),
    ({"seed": [1]}, {"method": "sobol"}, "no method `sobol`"),
    ({"seed": stats.randint(1, 9)}, {}, "`seed` has a distribution"),
    ({"seed": [1]}, {"reads": ["none.csv"]}, "none.csv: No such file"),
]


@pytest.mark.parametrize(("vary", "options", "sentence"), WRONG)
def test_a_sweep_that_cannot_be_meant_is_refused_in_a_sentence(vary, options, sentence, tmp_path):
    with pytest.raises(anemo.Error, match=sentence) as raised:
        anemo.sweep(STEADY, vary, results=tmp_path / "out", **options)
    assert raised.value.code == 2 and "\n" not in str(raised.value)
    assert not (tmp_path / "out").exists(), "nothing is begun"


def test_a_missing_dask_is_named_with_what_installs_it(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(anemo.Error, match="a sweep needs distributed: pip install distributed pyarrow"):
        anemo.sweep(STEADY, SECOND, results=tmp_path)


def script(path: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, path, ROOT], cwd=folder, capture_output=True, text=True, timeout=600)


@pytest.mark.parametrize("name", ["winds", "fleet", pytest.param("calibrations", marks=pytest.mark.nightly)])
def test_an_example_runs_on_all_cores_and_keeps_its_claims(name, tmp_path):
    done = script(ROOT / f"python/examples/{name}.py", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == (ROOT / f"python/examples/{name}.out").read_text()


def test_a_script_whose_workers_would_sweep_again_says_so(tmp_path):
    path = tmp_path / "bare.py"
    path.write_text(f"import anemo\nanemo.sweep({str(STEADY)!r}, {SECOND!r})\n")
    done = script(path, tmp_path)
    assert done.returncode != 0 and 'call anemo.sweep below `if __name__ == "__main__":`' in done.stderr


@pytest.mark.nightly
def test_jobs_of_slurm_come_to_the_same_and_only_a_killed_run_is_repeated(slurm, tmp_path, monkeypatch):
    jobqueue = pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is not installed")
    # Workers import this file.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT / "python/tests"), os.environ.get("PYTHONPATH", "")]))
    vary = {"duration_s": [600.0], "seed": list(range(1, 9))}
    plain = anemo.sweep(STEADY, vary, results=tmp_path / "plain")
    log, marker = tmp_path / "log", tmp_path / "killed"

    def then(table):
        found = noted(log, table)
        if len(lines(log)) >= 3:
            killed_once(marker)
        return {**found, "job": os.environ["SLURM_JOB_ID"]}

    cluster = jobqueue.SLURMCluster(
        cores=1, memory="500 MB", queue="day", walltime="0:10:00", interface="lo", log_directory=str(tmp_path / "logs")
    )
    with cluster, distributed.Client(cluster) as client:
        cluster.scale(jobs=2)
        client.wait_for_workers(2, timeout=120)
        table = anemo.sweep(STEADY, vary, then=then, client=client, results=tmp_path / "out")
    assert marker.exists() and set(table["failed"]) == {""}
    assert list(table["hash"]) == list(plain["hash"]) and len(set(table["job"])) == 2
    assert len(lines(log)) == 9 and set(lines(log)) == set(range(1, 9))

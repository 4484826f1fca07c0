"""Commands in process: their words, errors, interruptions, and forks."""

import inspect
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import warnings

import anemo
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from conftest import EXPERIMENTS, ROOT, heater


def long_run() -> anemo.Experiment:
    """A run of a million seconds, which nobody waits for."""
    text = (EXPERIMENTS / "prbs.toml").read_text()
    lines = ["duration_s = 1000000.0" if line.startswith("duration_s") else line for line in text.splitlines()]
    return anemo.Experiment("\n".join(lines), EXPERIMENTS)


def test_arguments_are_called_as_on_the_command_line(prbs):
    model = anemo.identify(
        prbs,
        input=["sector1"],
        output="sector1",
        order=np.int64(5),
        mesh=(0.002, 3),
        ridge=1e-7,
        feed_through=False,
        tie=False,
        non_negative="all",
        drift="none",
    )
    rates = model.spectrum()["rate_rad_s"]
    assert (len(rates), rates[0], rates[-1]) == (5, 0.002, 3.0)
    again = anemo.identify(prbs, input=("sector1",), output="sector1", order=5, mesh=[0.002, np.float32(3)], drift="none")
    assert again.spectrum()["rate_rad_s"][-1] == 3.0
    with pytest.raises(anemo.Error, match="`no` stands where True or False belongs"):
        anemo.identify(prbs, tie="no")
    with pytest.raises(anemo.Error, match="set is no file, no table and no number"):
        anemo.identify({1, 2})
    with pytest.raises(TypeError, match="odrer"):
        anemo.identify(prbs, odrer=5)
    with pytest.raises(anemo.Error, match="invalid value 'walking' for '--drift") as raised:
        anemo.identify(prbs, drift="walking")
    assert raised.value.code == 2
    with pytest.raises(anemo.Error, match="the table: .*no column `sector9`"):
        anemo.identify(prbs, input="sector9")


@pytest.mark.parametrize("name", [name for name in anemo.__all__ if name[0].islower() and name != "load"])
def test_every_function_says_what_its_arguments_are(name):
    function = getattr(anemo, name)
    for parameter in inspect.signature(function).parameters:
        assert f"    {parameter}\n" in function.__doc__, parameter


def test_what_the_command_warns_of_is_a_warning(prbs, tmp_path):
    step = anemo.Table({name: prbs[name][:400] for name in ("time_s", "power_w_sector1", "temperature_c_sector1")})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = anemo.identify(step, order=4, drift="none")
    # What a record does not show stands in the model, as in its file.
    assert model.warnings


def test_an_interrupted_run_keeps_what_it_has_recorded():
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt) as raised:
        anemo.simulate(long_run())
    assert time.monotonic() - began < 10
    assert len(raised.value.table) > 100 and raised.value.table.metadata["complete"] == "false"
    # And the next call works.
    assert anemo.check(EXPERIMENTS / "prbs.toml")


def test_an_interrupted_identification_ends_soon(prbs):
    many = anemo.Table({name: np.tile(prbs[name], 20) for name in ("power_w_sector1", "temperature_c_sector1")})
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            anemo.identify(many, sample_period=0.05)
    assert time.monotonic() - began < 10


def test_other_threads_go_on_while_a_command_works(short):
    counted, done = 0, threading.Event()

    def work():
        anemo.simulate(EXPERIMENTS / "prbs.toml")
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.wait(0.005):
        counted += 1
    thread.join()
    assert counted > 10


def in_child(results):
    try:
        results.put(len(anemo.simulate(EXPERIMENTS / "steady.toml")))
    except anemo.Error as refused:
        results.put(str(refused))


def test_a_fork_works_unless_another_thread_is_at_work():
    fork = multiprocessing.get_context("fork")
    results = fork.Queue()
    anemo.simulate(EXPERIMENTS / "steady.toml")
    process = fork.Process(target=in_child, args=(results,))
    process.start()
    assert results.get(timeout=60) > 100
    process.join()
    busy = threading.Thread(target=lambda: anemo.simulate(EXPERIMENTS / "prbs.toml"))
    busy.start()
    time.sleep(0.2)
    process = fork.Process(target=in_child, args=(results,))
    process.start()
    said = results.get(timeout=60)
    process.join()
    busy.join()
    assert "forked while another thread was at work" in said and "spawn" in said


def test_the_command_line_comes_along():
    command = [os.path.join(os.path.dirname(sys.executable), "anemo")]
    version = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
    assert version.stdout == f"anemo {anemo.__version__}\n"
    wrong = subprocess.run([*command, "run", "none.toml", "--on", "sim"], capture_output=True, text=True)
    assert wrong.returncode == 2 and wrong.stderr.startswith("anemo: none.toml: there is no such file")
    running = subprocess.Popen(
        [*command, "run", str(ROOT / "experiments/thesis/rems-self-still.toml"), "--on", "sim"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    time.sleep(0.5)
    running.send_signal(signal.SIGINT)
    assert running.wait(timeout=20) in (0, 4)


def test_the_package_is_small_to_import():
    code = "import time; t = time.perf_counter(); import anemo, sys; print('numpy' in sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout == "False\n"

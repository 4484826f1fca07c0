#!/usr/bin/env python3
"""The Python package beside the command: `identify` of an Arrow table in memory, and of the same rows in Parquet by a process
of its own.

    cargo xtask python --no-test
    target/tools/python/bin/python docs/performance/in_process.py [ROWS] [RUNS]

In turn, RUNS times; the ratio is that of the medians. Peak memory is what the process has grown by while it identified.
"""
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import anemo
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

OPTIONS = {"input": "power_w_core", "output": "temperature_c_core", "order": 8, "mesh": (0.001, 100), "drift": "none", "losses": "none"}


def record(rows):
    """Chance bits of 1 s, and what answers them at 0.5 s and 50 s, with noise; 1 kHz."""
    chance = np.random.default_rng(1)
    power = np.repeat(chance.integers(0, 2, rows // 1000 + 1), 1000)[:rows].astype(float)
    temperature = np.full(rows, 20.0)
    for gain, time_s in ((5.0, 0.5), (3.0, 50.0)):
        keep, state = np.exp(-1e-3 / time_s), 0.0
        # Bits last 1000 rows, in which the answer is an exponential.
        powers = keep ** np.arange(1000)
        for begin in range(0, rows, 1000):
            until = min(begin + 1000, rows)
            u = gain * power[begin]
            temperature[begin:until] += u + (state - u) * powers[: until - begin]
            state = u + (state - u) * keep**1000
    temperature += 0.1 * chance.standard_normal(rows)
    return pa.table({"time_s": np.arange(rows) * 1e-3, "power_w_core": power, "temperature_c_core": temperature})


def peak_mib():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main():
    rows, runs = (int(value) for value in (sys.argv[1:] + ["2000000", "7"][len(sys.argv) - 1 :])[:2])
    root = Path(__file__).resolve().parents[2]
    command = Path(os.environ.get("ANEMO_BIN", root / "target/release/anemo"))
    if not command.exists():
        sys.exit(f"{command} is not there: build it with `cargo build --release -p anemo`, or name it in ANEMO_BIN")
    words = [word for name, value in OPTIONS.items() for word in (f"--{name}", value)]
    words = [":".join(map(str, word)) if isinstance(word, tuple) else str(word) for word in words]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "record.parquet")
        table = record(rows)
        pq.write_table(table, path, compression="snappy")
        ours_s, theirs_s, grown_mib = [], [], 0.0
        for run in range(runs + 1):
            before, begin = peak_mib(), time.perf_counter()
            model = anemo.identify(table, **OPTIONS)
            ours_s.append(time.perf_counter() - begin)
            grown_mib = grown_mib if run else peak_mib() - before
            begin = time.perf_counter()
            answer = subprocess.run([command, "identify", path, *words, "--json"], check=True, capture_output=True, text=True)
            theirs_s.append(time.perf_counter() - begin)
        other = anemo.Model.from_json(answer.stdout.replace(str(path), "the table"))
    if model != other:
        sys.exit("the two models differ")
    # The first round warms up.
    ours, theirs = statistics.median(ours_s[1:]), statistics.median(theirs_s[1:])
    print(f"{rows} rows, {runs} rounds; both models are the same")
    print(f"command, Parquet      {theirs:7.3f} s")
    print(f"package, Arrow table  {ours:7.3f} s    {ours / theirs:.2f} times the command's")
    print(f"memory grows by {grown_mib:.1f} MiB; the table has {table.nbytes / 2**20:.1f} MiB")


if __name__ == "__main__":
    main()

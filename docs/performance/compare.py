#!/usr/bin/env python3
"""Runs the usual numpy/scipy route beside ours on the same record: states, normal equations and solution.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy
    cargo build --release -p anemo-tests --example identify_speed
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 /tmp/venv/bin/python docs/performance/compare.py [ROWS] [ORDER] [RUNS]

Both take plain least squares on a mesh of ORDER rates from 1 mHz to 1 kHz and an offset, 0.5 ms a row, one thread. Both must find the
same resistances to 1e-6. Times are the least of RUNS runs, in turn, since the machine may be shared.
"""
import json
import subprocess
import sys
import tempfile
import time

from built import example, numbers

import numpy as np
from scipy.signal import lfilter

SAMPLE_PERIOD_S = 5e-4


def route(u, y, order):
    """States by one filter a rate, AᵀA by BLAS, solution by LU."""
    rates = 2 * np.pi * np.geomspace(1e-3, 1e3, order)
    columns = np.empty((len(u), order + 1), order="F")
    for k, rate in enumerate(rates):
        gain = -np.expm1(-rate * SAMPLE_PERIOD_S)
        columns[:, k] = lfilter([0.0, gain], [1.0, gain - 1.0], u)
    columns[:, order] = 1.0
    return np.linalg.solve(columns.T @ columns, columns.T @ y)


def record(rows):
    """Chance bits of 1 s, and what answers them at 0.5 s and 50 s, with noise."""
    chance = np.random.default_rng(1)
    u = np.repeat(chance.integers(0, 2, rows // 2000 + 1), 2000)[:rows].astype(float)
    y = 20 + 5 * lfilter([0, 1e-3], [1, -0.999], u) + 3 * lfilter([0, 1e-5], [1, -0.99999], u)
    return u, y + 0.1 * chance.standard_normal(rows)


def main():
    rows, order, runs = numbers(2_000_000, 8, 10)
    u, y = record(rows)
    program, reports, theirs_s = example("identify_speed"), [], []
    with tempfile.NamedTemporaryFile(suffix=".f64") as data:
        np.column_stack([u, y]).astype("<f8").tofile(data.name)
        for _ in range(runs):
            start = time.perf_counter()
            theta = route(u, y, order)
            theirs_s.append(time.perf_counter() - start)
            answer = subprocess.run([program, data.name, str(order), "100"], check=True, capture_output=True, text=True)
            reports.append(json.loads(answer.stdout))
    ours = np.array(reports[0]["r_k_per_w"] + [reports[0]["offset_c"]])
    apart = np.max(np.abs(ours - theta)) / np.max(np.abs(theta))
    if not apart < 1e-6:
        sys.exit(f"the answers differ by {apart:.1e} of the largest: {ours} {theta}")

    best = min(reports, key=lambda report: report["ns_per_row"])
    theirs_ns, ours_ns = 1e9 * min(theirs_s) / rows, best["ns_per_row"]
    flops_ns = 1e9 * best["flops_per_row"] / max(report["flops_per_second"] for report in reports)
    bytes_ns = 1e9 * best["bytes_per_row"] / max(report["bytes_per_second"] for report in reports)
    limit_ns, limit = max((flops_ns, "floating point"), (bytes_ns, "memory"))
    print(f"{rows} rows, {order} rates and an offset, one thread; answers agree to {apart:.1e}")
    print(f"numpy/scipy           {theirs_ns:8.1f} ns a row")
    print(f"anemo                 {ours_ns:8.1f} ns a row    {theirs_ns / ours_ns:6.1f} times faster")
    drift_ns = min(report["drift_ns_per_row"] for report in reports)
    columns = f"sums for drifts of every size, {best['drift_columns']} columns for {order + 2}"
    print(f"anemo, drift          {drift_ns:8.1f} ns a row    {theirs_ns / drift_ns:6.1f} times faster; {columns}")
    print(f"limit, floating point {flops_ns:8.1f} ns a row    {best['flops_per_row']:.0f} flop")
    print(f"limit, memory         {bytes_ns:8.1f} ns a row    {best['bytes_per_row']:.0f} bytes")
    print(f"anemo takes {ours_ns / limit_ns:.1f} times what {limit} allows")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Predicts the same closed loop with scipy, and with ngspice if it is installed, and holds all against ours.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy
    cargo build --release -p anemo-tests --example loop_speed
    /tmp/venv/bin/python docs/performance/closed_loop.py [TICKS] [WINDS]

scipy: `expm` of D for every wind and one product a tick; `lsim` of the sliding motion in the first wind. ngspice: the Foster network of the
first wind, its junction held at the set-point by a voltage source, whose current is the equivalent control. The script stops if a power
differs by more than 1e-6 of itself. Ours makes the prediction under the one-bit rule in the same time.
"""
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from built import example, numbers

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.signal import StateSpace, lsim

# ngspice: s, and what its trapezoids must resolve of the fastest zero.
SPICE_END_S, SPICE_STEP_S = 5.0, 2e-4


def ours(ticks, winds, out):
    answer = subprocess.run([example("loop_speed"), str(ticks), str(winds), out], check=True, capture_output=True, text=True)
    return json.loads(answer.stdout), np.fromfile(out, "<f8")


def matrix(rates, r):
    eta = rates * r
    return np.diag(rates) - np.outer(eta, rates) / eta.sum(), rates / eta.sum()


def with_expm(case, ticks):
    """Power at every tick from the first on the surface, that tick, and the moment and states at which it was met."""
    rates, period = np.array(case["rates_rad_s"]), case["period_s"]
    r = np.array(case["r_k_per_w"])
    first = case["winds"][0][1]
    rise = lambda t: case["high_w"] * (r[first] @ -np.expm1(-rates * t)) - case["rise_k"]
    met = brentq(rise, 0, 100 / rates[0], xtol=1e-13, rtol=1e-15)
    z_met = -r[first] * case["high_w"] * np.expm1(-rates * met)
    planes = [matrix(rates, own) for own in r]
    steps = [expm(-d * period) for d, _ in planes]
    tick = int(np.ceil(met / period))
    z = expm(-planes[first][0] * (tick * period - met)) @ z_met
    wind = np.zeros(ticks, int)
    for at, which in case["winds"]:
        wind[at:] = which
    power = np.empty(ticks - tick)
    for n in range(tick, ticks):
        power[n - tick] = planes[wind[n]][1] @ z
        z = steps[wind[n]] @ z
    return power, tick, met, z_met


def with_ngspice(case, z_met):
    """(t, power) in the first wind, counted from the moment at which the surface is met."""
    rates, r = np.array(case["rates_rad_s"]), np.array(case["r_k_per_w"][case["winds"][0][1]])
    nodes = ["j"] + [f"n{k}" for k in range(1, len(r))] + ["0"]
    lines = ["loop held at its set-point", f"V1 j 0 {case['rise_k']!r}"]
    for k, (rate, own, z) in enumerate(zip(rates.tolist(), r.tolist(), z_met.tolist())):
        lines.append(f"R{k} {nodes[k]} {nodes[k + 1]} {own!r}")
        lines.append(f"C{k} {nodes[k]} {nodes[k + 1]} {1 / (rate * own)!r} ic={z!r}")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "power.txt"
        lines += [
            ".options reltol=1e-10 abstol=1e-16 vntol=1e-13 gmin=1e-18 numdgt=15",
            f".tran {SPICE_STEP_S} {SPICE_END_S} 0 {SPICE_STEP_S} uic",
            ".control", "set numdgt=15", "run", f"wrdata {out} i(v1)", "quit 0", ".endc", ".end",
        ]
        net = Path(folder) / "loop.cir"
        net.write_text("\n".join(lines) + "\n")
        subprocess.run(["ngspice", "-b", str(net)], check=True, capture_output=True)
        table = np.loadtxt(out)
    return table[:, 0], -table[:, 1]


def hold(name, apart):
    print(f"  {name}: largest relative difference {apart:.1e}")
    if not apart < 1e-6:
        sys.exit(f"{name} differs from ours by {apart:.1e}")


def main():
    ticks, winds = numbers(360_000, 100)
    with tempfile.NamedTemporaryFile(suffix=".f64") as data:
        case, power = ours(ticks, winds, data.name)
    if case["saturated"]:
        sys.exit("the loop leaves its surface, which the routes here do not know: choose other winds")
    print(f"{ticks} ticks, {winds} winds, K = {len(case['rates_rad_s'])}")
    start = time.perf_counter()
    theirs, tick, met, z_met = with_expm(case, ticks)
    theirs_s = time.perf_counter() - start
    if not abs(met - case["first_met_s"]) < 1e-9:
        sys.exit(f"the surface is met at {met} s, and ours says {case['first_met_s']} s")
    hold("scipy expm", np.max(np.abs(power[tick:] / theirs - 1)))

    rates, first = np.array(case["rates_rad_s"]), case["winds"][0][1]
    d, row = matrix(rates, np.array(case["r_k_per_w"][first]))
    end = (case["winds"][1][0] if winds > 1 else ticks) - tick
    z = expm(-d * (tick * case["period_s"] - met)) @ z_met
    times = np.arange(end) * case["period_s"]
    system = StateSpace(-d, np.zeros((len(z), 1)), row[None, :], np.zeros((1, 1)))
    start = time.perf_counter()
    _, answer, _ = lsim(system, np.zeros(end), times, X0=z)
    lsim_s = (time.perf_counter() - start) * ticks / end
    hold("scipy lsim, first wind", np.max(np.abs(power[tick : tick + end] / answer.ravel() - 1)))

    if shutil.which("ngspice"):
        start = time.perf_counter()
        at, spice = with_ngspice(case, z_met)
        spice_s = time.perf_counter() - start
        n = np.arange(tick, tick + int(SPICE_END_S / case["period_s"]) - 1)
        n = n[n < tick + end]
        # From 20 steps on: its first step is of lower order.
        n = n[n * case["period_s"] - met > 20 * SPICE_STEP_S]
        between = np.interp(n * case["period_s"] - met, at, spice)
        hold("ngspice, first wind", np.max(np.abs(power[n] / between - 1)))
    print(f"  ours {1e3 * case['seconds']:.1f} ms, with the one-bit rule")
    print(f"  scipy expm {1e3 * theirs_s:.0f} ms, {theirs_s / case['seconds']:.1f} times as long")
    print(f"  scipy lsim {1e3 * lsim_s:.0f} ms for as many ticks, {lsim_s / case['seconds']:.1f} times as long")
    if shutil.which("ngspice"):
        print(f"  ngspice {1e3 * spice_s:.0f} ms for {SPICE_END_S:g} s")


if __name__ == "__main__":
    main()

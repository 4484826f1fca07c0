#!/usr/bin/env python3
"""The same records identified by anemo and by other Python libraries: one table of held-out fit and time.

    pip install -r python/gallery/requirements.txt                       # into an environment with anemo
    python docs/performance/peers.py [--runs 3] [RECORD …]

- SIPPY (sippy_unipi): N4SID, with 20, 50 or 100 rows ahead and behind, with and without feed-through
- python-control: Markov parameters by least squares, 20 to 800 of them, then the eigensystem realisation (ERA)
- sysidentpy: FROLS, polynomial NARX with 2 to 40 lags, degree 1, also 2 of short ones, terms by its AIC

Of these all settings are tried, orders from 1 to 8 (2, 3, 4 and 6 of long records), without the mean or without what
the record began with, and the one is kept whose *held-out* fit is best, which favours them. anemo gets its default
options and sees nothing held out.

Fit is 100 (1 - |y - p| / |y - mean y|) in per cent, of a free run. Of the simulated records another run is held out, of
other seeds: initial state and offset are fitted to it, FROLS is given its first rows. Of the measured ones the second
half is forecast from the first, without any output of it. Time is processor time of one thread, the least
of so many fits with the setting kept, warm; anemo's holds all its choosing.
"""
import argparse
import itertools
import platform
import sys
import time
import warnings
from dataclasses import dataclass
from importlib import metadata

from built import ROOT

import anemo
import control
import numpy as np
import pandas as pd
from sippy_unipi import system_identification
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

MEASURED = ["heating_system", "dryer", "unthermal_prbs", "tclab_apm_steps", "tclab_apm_mimo_T1"]
ORDERS = range(1, 9)


@dataclass
class Task:
    """A record to identify, and the inputs of another to forecast; its output is for the score."""

    name: str
    period_s: float
    u: np.ndarray
    y: np.ndarray
    u_next: np.ndarray
    y_next: np.ndarray
    balance_u: np.ndarray
    """Input with which the record may have begun in balance."""
    goes_on: bool
    """Whether the second follows the first; else it is a run of its own."""

    def table(self, u, y, first_row=0):
        time_s = (first_row + np.arange(len(y))) * self.period_s
        return {"time_s": time_s, **{f"u{i}": column for i, column in enumerate(u.T)}, "y": y}


def fit_percent(measured, forecast):
    wrong = np.linalg.norm(measured - forecast) / np.linalg.norm(measured - measured.mean())
    return 100 * (1 - wrong) if np.isfinite(wrong) else -np.inf


def sphere(period_s, bit_s):
    """Sector 1 of sphere B on pseudo-random bits for an hour, in a wind of 1 m/s."""
    text = (ROOT / "experiments/prbs.toml").read_text()
    runs = []
    for seed in (1, 2):
        drives = f"[drives]\nsector1 = {{ prbs = {{ order = 20, bit_time_s = {bit_s}, seed = {seed} }} }}\n\n[[wind]]"
        changed = text[: text.index("[drives]")] + drives + text[text.index("[[wind]]") + len("[[wind]]") :]
        changed = changed.replace("sample_period_s = 0.05", f"sample_period_s = {period_s}")
        run = anemo.simulate(anemo.Experiment(changed.replace("\nseed = 3", f"\nseed = {seed}"), ROOT / "experiments"))
        runs += [run["power_w_sector1"][:, None], run["temperature_c_sector1"]]
    return Task(f"sphere B, {period_s:g} s a row", period_s, *runs, balance_u=runs[0].min(axis=0), goes_on=False)


def measured(name):
    """Both halves of a record that stands beside the repository; `None` without it."""
    path = ROOT.parent / "shared/data" / f"{name}.csv"
    if not path.exists():
        print(f"{name}: skipped, since {path} is not there", file=sys.stderr)
        return None
    frame = pd.read_csv(path)
    values, half = frame.to_numpy(float), len(frame) // 2
    period_s = (values[-1, 0] - values[0, 0]) / (len(frame) - 1)
    u, y = values[:, 1:-1], values[:, -1]
    return Task(name, period_s, u[:half], y[:half], u[half:], y[half:], balance_u=u[0], goes_on=True)


def by_anemo(task, _):
    inputs = [f"u{i}" for i in range(task.u.shape[1])]
    model = anemo.identify(task.table(task.u, task.y), input=inputs, output="y")
    start, first = ("continue", len(task.y)) if task.goes_on else ("estimate", 0)
    return lambda: anemo.validate(model, task.table(task.u_next, task.y_next, first), start=start).fit_percent


def in_state_space(task, centre, of_centred):
    """A model of centred columns as what forecasts, with initial state and offset by least squares."""
    u_0, y_0 = (task.u.mean(axis=0), task.y.mean()) if centre == "mean" else (task.balance_u, task.y[0])
    a, b, c, d = of_centred(task.u - u_0, task.y - y_0)
    system = control.ss(a, b, c, d, task.period_s)
    u, y = (np.vstack([task.u, task.u_next]), task.y) if task.goes_on else (task.u_next, task.y_next)

    def forecast():
        run = control.forced_response(system, U=(u - u_0).T, squeeze=False).outputs[0]
        free, x = [], np.eye(len(a))
        for _ in u:
            free.append((c @ x)[0])
            x = a @ x
        columns = np.column_stack([free, np.ones(len(u))])
        if not np.all(np.isfinite(columns)):
            return -np.inf
        begin = np.linalg.lstsq(columns[: len(y)], y - run[: len(y)], rcond=None)[0]
        return fit_percent(task.y_next, (run + columns @ begin)[-len(task.y_next) :])

    return forecast


def by_sippy(task, setting):
    rows, order, feed_through, centre = setting

    def model(u, y):
        found = system_identification(
            y[None], u.T, "N4SID", SS_f=rows, SS_p=rows, SS_fixed_order=order, SS_D_required=feed_through
        )
        return found.A, found.B, found.C, found.D

    return in_state_space(task, centre, model)


def by_control(task, setting):
    count, order, centre = setting

    def model(u, y):
        # A trailing parameter would make the Hankel matrix of an even number of them too large.
        markov = control.markov(y[None], u.T, count + 1)
        system, _ = control.eigensys_realization(markov, order, m=count // 2, n=count // 2)
        return system.A, system.B, system.C, system.D

    return in_state_space(task, centre, model)


def by_sysidentpy(task, setting):
    lags, degree = setting
    back = list(range(1, lags + 1))
    model = FROLS(
        ylag=lags,
        xlag=[back] * task.u.shape[1] if task.u.shape[1] > 1 else lags,
        basis_function=Polynomial(degree=degree),
        estimator=LeastSquares(),
        n_info_values=min(30, lags * (1 + task.u.shape[1])),
    )
    model.fit(X=task.u, y=task.y[:, None])

    def forecast():
        # It needs outputs to begin with: the record's last, or the first of what it forecasts.
        u, y = task.u_next, task.y_next[:lags]
        if task.goes_on:
            u, y = np.vstack([task.u[-lags:], u]), task.y[-lags:]
        ahead = model.predict(X=u, y=y[:, None])[:, 0]
        return fit_percent(task.y_next, ahead[lags:] if task.goes_on else ahead)

    return forecast


def settings(task):
    """Every library, what does it, and what is tried of it."""
    rows, short = len(task.y), len(task.y) < 5_000
    orders, through = (ORDERS, (False, True)) if short else ((2, 3, 4, 6), (False,))
    counts = [m for m in ((20, 50, 100, 200, 400) if short else (200, 800)) if (2 + task.u.shape[1]) * m < rows]
    ahead = [f for f in (20, 50, 100) if 5 * f < rows]
    lags = [(lag, degree) for lag in (2, 5, 10, 20, 40) for degree in ((1, 2) if short and lag < 10 else (1,))]
    sippy = list(itertools.product(ahead, orders, through, ("mean", "start")))
    eras = list(itertools.product(counts, orders, ("mean", "start")))
    return [
        ("anemo", "", by_anemo, [None]),
        ("sippy_unipi", "N4SID", by_sippy, sippy),
        ("control", "ERA", by_control, eras),
        ("sysidentpy", "FROLS", by_sysidentpy, lags),
    ]


def compared(task, runs):
    for library, method, identify, tried in settings(task):
        best = (-np.inf, None)
        for setting in tried:
            try:
                best = max(best, (identify(task, setting)(), setting), key=lambda pair: pair[0])
            except (ValueError, np.linalg.LinAlgError, FloatingPointError):
                continue  # such a model cannot be made of this record
        times = []
        for _ in range(runs):
            begin = time.process_time()
            identify(task, best[1])
            times.append(time.process_time() - begin)
        yield {
            "record": task.name,
            "rows": len(task.y),
            "library": f"{library} {method}".strip(),
            "held_out_fit_percent": best[0],
            "setting": best[1],
            "tried": len(tried),
            "time_s": min(times),
        }


def main():
    parser = argparse.ArgumentParser(description="One table of held-out fit and time, of anemo and other libraries.")
    parser.add_argument("--runs", type=int, default=3, help="time is the least of so many (default: 3)")
    parser.add_argument("record", nargs="*", help="only records whose names hold one of these words")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    tasks = itertools.chain((sphere(*periods) for periods in [(0.05, 0.1), (0.5, 2.0)]), map(measured, MEASURED))
    for task in filter(None, tasks):
        if not options.record or any(word in task.name for word in options.record):
            for line in compared(task, options.runs):
                show(line)
    versions = [f"{name} {metadata.version(name)}" for name in ("anemo", "sippy_unipi", "control", "sysidentpy", "numpy")]
    print(", ".join([*versions, f"python {platform.python_version()}"]))


def show(line):
    setting = "" if line["setting"] is None else f"{line['setting']} of {line['tried']}"
    record = f"{line['record']} ({line['rows']} rows)"
    print(f"{record:36} {line['library']:18} {line['held_out_fit_percent']:7.2f} % {line['time_s']:9.3f} s  {setting}")


if __name__ == "__main__":
    main()

# %% [markdown]
# # Simple laws of charge and a diffusive model
# Charge in a dielectric is often described by one formula for its response S(t) to a step. Six such laws and anemo's
# diffusive model are fitted to a day of pseudo-random symbols; each then forecasts the next day from its symbols alone.
# `python python/gallery/mems_laws.py docs/results` writes the table and the picture there.

# %%
import sys
from pathlib import Path

import anemo
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter, oaconvolve

folder = Path("." if "ipykernel" in sys.modules else [*sys.argv, "."][1])
root = Path(__file__).resolve().parents[2] if "__file__" in globals() else Path.cwd()

# %% [markdown]
# ## Two days
# As `anemo run experiments/mems/prbs.toml` records them: a symbol ±1 a second, and the voltage shift before it.

# %%
record = anemo.simulate(root / "experiments/mems/prbs.toml")
time_s, u, y = (np.asarray(record[name]) for name in ("time_s", "symbol_mems", "voltage_shift_v_mems"))
first, later = time_s < 86_400, time_s >= 86_400
period_s, rows = time_s[1] - time_s[0], first.sum()

# %% [markdown]
# ## Laws
# A law is a convolution of the symbols with S; charge from before the record leaves a decay of the same shape. Gains,
# decays and the value at rest are linear: only the shapes are searched (variable projection).

# %%
def exponentials(ln_tau_s, symbols):
    for decay in np.exp(-period_s / np.exp(ln_tau_s)):
        yield lfilter([0, 1 - decay], [1, -decay], symbols), decay ** np.arange(len(symbols))

def convolved(step, symbols):
    return oaconvolve(np.diff(step, prepend=step[0]), symbols)[: len(symbols)]
def stretched(shape, symbols):
    left = np.exp(-((np.arange(len(symbols)) * period_s / np.exp(shape[0])) ** shape[1]))
    yield convolved(1 - left, symbols), left

def square_root(_, symbols):
    step = np.sqrt(np.arange(len(symbols)) * period_s)
    yield convolved(step, symbols), step

def columns(law, shape, symbols):
    return np.column_stack([column for term in law(shape, symbols) for column in term] + [np.ones(len(symbols))])

def forecast(law, shape):
    by = columns(law, shape, u)
    return by @ np.linalg.lstsq(by[first], y[first], rcond=None)[0]
def fitted(law, starts, bounds):
    def errors(shape):  # of every tenth row: a bit of the sequence has a hundred
        by, measured = columns(law, shape, u[first])[::10], y[first][::10]
        return by @ np.linalg.lstsq(by, measured, rcond=None)[0] - measured
    return min((least_squares(errors, start, bounds=bounds) for start in starts), key=lambda end: end.cost).x

shortest, longest = np.log(0.3 * period_s), np.log(100 * rows * period_s)
grid = np.log(np.geomspace(5 * period_s, rows * period_s / 3, 4))
forecasts, shape = {}, []
for name in ["one exponential", "two exponentials", "three exponentials", "four exponentials"]:
    shape = fitted(exponentials, [np.r_[shape, ln_tau_s] for ln_tau_s in grid], (shortest, longest))
    forecasts[name] = forecast(exponentials, shape)
kohlrausch = fitted(stretched, [[ln_tau_s, 0.5] for ln_tau_s in grid[1:]], ([shortest, 0.05], [longest, 1]))
forecasts |= {"stretched exponential": forecast(stretched, kohlrausch), "square root of time": forecast(square_root, 0)}

# %% [markdown]
# ## The diffusive model
# Identified without options, but for an offset that stands. Rates and resistances are those of the model; the decays
# of the time before the record are fitted as those of the laws.

# %%
model = anemo.identify({"time_s": time_s[first], "symbol": u[first], "shift_v": y[first]}, drift="none")
spectrum = model.spectrum()
responses, decays = zip(*exponentials(-np.log(spectrum["rate_rad_s"]), u))
driven = spectrum["r_k_per_w"] @ np.array(responses)
free = np.column_stack([*decays, np.ones(len(u))])
forecasts["diffusive model"] = driven + free @ np.linalg.lstsq(free[first], (y - driven)[first], rcond=None)[0]
numbers = dict(zip(forecasts, [4, 7, 10, 13, 5, 3, 2 * len(decays) + 1]))

# %% [markdown]
# ## Table and picture
# Errors of the second day in ten blocks: a law is alike if its mean square is within two standard errors of the best.

# %%
def fit_percent(wrong, part):
    return 100 * (1 - np.linalg.norm(wrong[part]) / np.linalg.norm(y[part] - y[part].mean()))

errors = {name: y - forecast for name, forecast in forecasts.items()}
blocks = {name: np.array([np.mean(b**2) for b in np.array_split(e[later], 10)]) for name, e in errors.items()}
best = min(blocks, key=lambda name: blocks[name].mean())
more = {name: own - blocks[best] for name, own in blocks.items()}
marks = {name: "alike" if of.mean() <= 2 * of.std(ddof=1) / 10**0.5 else "" for name, of in more.items()}
table = "# Simple laws of charge and a diffusive model\n\nBy [`mems_laws`](../../python/gallery/mems_laws.py).\n\n"
table += "| law | numbers | fit, first day | fit, second day | V rms | |\n|---|--:|--:|--:|--:|---|\n"
figure, panels = plt.subplots(len(errors), 1, figsize=(7, 8), sharex=True, sharey=True, layout="constrained")
for panel, (name, wrong) in zip(panels, errors.items()):
    fits = " | ".join(f"{fit_percent(wrong, part):.2f} %" for part in (first, later))
    mark = "best" if name == best else marks[name]
    table += f"| {name} | {numbers[name]} | {fits} | {np.sqrt(np.mean(wrong[later] ** 2)):.4g} | {mark} |\n"
    panel.plot(time_s[::120] / 3600, wrong[::120], linewidth=0.5)
    panel.axvspan(0, 24, color="0.9")
    panel.set_title(name, fontsize="small", loc="left")
panels[0].set(ylim=(-0.15, 0.15), xlim=(0, 48))
panels[-1].set_xlabel("time, h; fitted to the first day")
figure.supylabel("error of the voltage shift, V")
figure.savefig(folder / "mems_laws.png", dpi=120)
figure.savefig(folder / "mems-laws.svg", metadata={"Date": None})
(folder / "mems-laws.md").write_text(table, encoding="utf-8")
print(table)

# %% [markdown]
# ## What was claimed

# %%
assert best == "diffusive model" and [name for name, mark in marks.items() if mark] == ["stretched exponential", best]

# %% [markdown]
# # Identify your own CSV
# A block of aluminium with a heater and a thermometer: time constants of 6 s and 80 s, a fan that is off or on, and
# a logger that lost some rows. Here the record is made up, so that the answer is known; put your own file in its place.

# %%
import sys
from pathlib import Path

import anemo
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

folder = Path("." if "ipykernel" in sys.modules else [*sys.argv, "."][1])
TRUE_K_PER_W = {"fan off": {6.0: 3.0, 80.0: 9.0}, "fan on": {6.0: 2.5, 80.0: 4.0}}  # by time constant, s

# %% [markdown]
# ## A table
# A row holds the temperature at its time, and the power from then on. The column `event` has the conditions: each gets
# a spectrum of its own. Of a block at rest the temperature is that of the room, 22 °C.

# %%
chance, period_s, rows = np.random.default_rng(1), 0.5, 14_400
power_w = np.repeat(chance.integers(0, 2, rows // 8), 8) * 2.0
event = np.repeat(chance.permutation(["fan off", "fan on"] * 6), rows // 12)
temperature_c = 22 + chance.normal(0, 0.01, rows)
for tau_s in (6.0, 80.0):
    rise_k, held = 0.0, np.exp(-period_s / tau_s)
    for row in range(rows):
        temperature_c[row] += rise_k
        rise_k = held * rise_k + (1 - held) * TRUE_K_PER_W[event[row]][tau_s] * power_w[row]
columns = {"time_s": np.arange(rows) * period_s, "power_w": power_w, "temperature_c": temperature_c, "event": event}
table = pd.DataFrame(columns)
table.loc[500:507, "temperature_c"] = np.nan  # a thermometer that did not answer
table = table.drop(index=range(6000, 6060)).reset_index(drop=True)  # half a minute without a logger
table.to_csv(folder / "block.csv", index=False)

# %% [markdown]
# ## A model
# A file or a data frame, the answer is the same. Two poles, since the block is two lumps; without `free_poles` a
# logarithmic grid of rates is chosen by cross-validation.

# %%
model = anemo.identify(folder / "block.csv", free_poles=2)
same = anemo.identify(table, free_poles=2)
print(model)
gains = {name: model.steady_gain(class_=name) for name in model.classes}
print(anemo.validate(model, table))

# %% [markdown]
# ## Pictures

# %%
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 7), layout="constrained")
part = table[table["time_s"].between(2400, 3600)]
above.plot(part["time_s"], part["temperature_c"], ".", markersize=2)
above.set(xlabel="time, s", ylabel="temperature, °C", title="part of the record, and the gap in it")
time_s = np.geomspace(0.5, 600, 200)
for name, marker in zip(model.classes, "os"):
    foster = model.foster(class_=name)
    rises = foster["resistance_k_per_w"] * (1 - np.exp(-time_s[:, None] * foster["rate_rad_s"]))
    true = sum(r * (1 - np.exp(-time_s / tau)) for tau, r in TRUE_K_PER_W[name].items())
    label = f"{name}: {gains[name][0]:.4f} ± {gains[name][1]:.4f} K/W"
    (line,) = below.semilogx(time_s, rises.sum(axis=1), label=label)
    below.plot(time_s[::10], true[::10], marker, color=line.get_color(), fillstyle="none", label=f"{name}, true")
below.set(xlabel="time after a step of 1 W, s", ylabel="thermal impedance, K/W")
below.legend()
figure.savefig(folder / "identify_your_csv.png", dpi=120)

# %% [markdown]
# ## What was claimed

# %%
for name, true in TRUE_K_PER_W.items():
    gain, error = gains[name]
    assert abs(gain - sum(true.values())) < 3 * error < 0.2, (name, gain, error)
    assert np.allclose(np.sort(model.foster(class_=name)["time_constant_s"]), sorted(true), rtol=0.02)
assert same.steady_gain(class_="fan on") == gains["fan on"]

# %% [markdown]
# # A head in the tunnel
# From an unknown head to wind with known errors, all in a simulated tunnel: what every element heats in quiescent gas,
# a calibration in sixty known winds, and sixty winds that it has not seen. On a bench `anemo run --on serial:…` makes
# the recordings, and the rest is the same.

# %%
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import anemo
import matplotlib.pyplot as plt
import numpy as np

folder = Path("." if "ipykernel" in sys.modules else [*sys.argv, "."][1])
root = Path(__file__).resolve().parents[2] if "__file__" in globals() else Path.cwd()
quick = root / "experiments/wind/quick"

# %% [markdown]
# ## Eight runs
# 3.8 hours of the tunnel. While one works, other threads do, too.

# %%
elements = ["sector1", "sector2", "sector3", "sector4", "core1", "core2"]
names = [f"identify-{element}" for element in elements] + ["tunnel", "winds"]
with ThreadPoolExecutor() as pool:
    *heated, tunnel, winds = pool.map(anemo.simulate, [quick / f"{name}.toml" for name in names])

# %% [markdown]
# ## Network and calibration
# The network of thermal resistances takes the heat that goes into the structure off the power; the calibration gives
# the wind from what is left.

# %%
network = anemo.identify_head(*heated)
head = anemo.calibrate(tunnel, network=network, settle=10)
print(head.report)
head.write(folder / "calibrated.toml")

# %% [markdown]
# ## Winds
# An estimate every 0.1 s, of 0.5 Hz bandwidth. The first minute is quiescent gas, and three seconds after every change
# of the wind do not count, nor do estimates with a quality flag: of a surface that was saturated, of winds nearer to
# the stem than the calibration's.

# %%
wind = anemo.wind(winds, head=head, bandwidth=0.5, every=0.1, from_=60, settle=3)
print(wind.report)
truth, estimate = (np.column_stack([wind[f"{of}wind_{axis}_m_s"] for axis in "xyz"]) for of in ("true_", ""))
since = wind["time_s"] - np.floor(wind["time_s"] / 6 + 1e-9) * 6  # a new wind every 6 s
counts = (wind["time_s"] >= 60) & (since >= 3) & (wind["quality_flags"] == 0)
truth, estimate = truth[counts], estimate[counts]
speed = np.linalg.norm(truth, axis=1)
speed_error = np.linalg.norm(estimate, axis=1) / speed - 1
cosine = np.sum(truth * estimate, axis=1) / speed / np.linalg.norm(estimate, axis=1)
angle_deg = np.degrees(np.arccos(np.clip(cosine, -1, 1)))

# %% [markdown]
# ## Pictures

# %%
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, layout="constrained")
above.errorbar(
    speed, 100 * speed_error, 200 * wind["wind_speed_u_m_s"][counts] / speed, fmt=".", markersize=3, elinewidth=0.3
)
above.axhline(0, color="0.5")
above.set(ylabel="error of the speed, %", title=f"{counts.sum()} estimates; bars: two standard uncertainties")
below.semilogx(speed, angle_deg, ".", markersize=3, label="error")
below.plot(speed, wind["wind_direction_u_deg"][counts], "x", markersize=3, label="standard uncertainty")
below.set(xlabel="true wind speed, m/s", ylabel="error of the direction, °")
below.legend()
figure.savefig(folder / "head_in_the_tunnel.png", dpi=120)

# %% [markdown]
# ## What was claimed

# %%
rms = lambda values: float(np.sqrt(np.mean(np.square(values))))
print(f"speed {100 * rms(speed_error):.2f} %, direction {rms(angle_deg):.2f}° rms of {counts.sum()} estimates")
assert head.report.grade == "good"
assert counts.sum() > 1000 and rms(speed_error) < 0.005 and rms(angle_deg) < 0.6
report = wind.report
assert report.speed_rms_error < 0.01 and report.direction_rms_error_deg < 1

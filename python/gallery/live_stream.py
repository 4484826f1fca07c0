# %% [markdown]
# # A live stream into a notebook
# Another process runs the instrument: here `anemo live` with a simulation, forty times as fast as time; with
# `--on serial:/dev/ttyACM0` a sensor board. Its page is fed by server-sent events, which Python reads as well: means
# over 0.1 s of every channel. For each single row take `anemo log` and read its folder.

# %%
import json
import signal
import subprocess
import sys
import sysconfig
import urllib.request
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

folder = Path("." if "ipykernel" in sys.modules else [*sys.argv, "."][1])
root = Path(__file__).resolve().parents[2] if "__file__" in globals() else Path.cwd()
UNTIL_S = 240  # of the instrument's time: six seconds here
# %% [markdown]
# ## An instrument
# Gusts on Mars, by a calibrated head. The first line that the command prints is the address of its page.

# %%
text = (root / "experiments/gusts.toml").read_text(encoding="utf-8")
text = text.replace("../heads/sphere-b.toml", (root / "tests/fixtures/sphere-b-calibrated.toml").as_posix())
text = text.replace("models =", "# models =")  # of another head
experiment = folder / "live_stream.toml"
experiment.write_text(text, encoding="utf-8")
program = Path(sysconfig.get_path("scripts")) / "anemo"
command = [program, "live", experiment, "--on", "sim", "--speed", "40"]
instrument = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
address = instrument.stdout.readline().strip()

# %% [markdown]
# ## Its stream
# An event has a name and one line of JSON: first `layout` with the channels, then `rows`. The last bucket of 0.1 s
# comes again until it is full: its number tells.

# %%
def events(address):
    with urllib.request.urlopen(f"{address}events?window_s=60", timeout=10) as stream:
        for line in stream:
            key, _, value = line.decode().strip().partition(": ")
            if key == "event":
                name = value
            elif key == "data":
                yield name, json.loads(value)

buckets = {}
try:
    for name, message in events(address):
        if name == "layout":
            columns = [f"{channel['quantity']}_{channel['of']}".rstrip("_") for channel in message["channels"]]
        elif name == "rows":
            buckets |= {one["id"]: [one["time_s"], *one["mean"]] for one in message["buckets"]}
            if message["time_s"] > UNTIL_S:
                break
finally:
    # As Ctrl-C does: heaters low, then the end.
    instrument.send_signal(signal.SIGINT)
    code = instrument.wait(timeout=20)
live = pd.DataFrame([buckets[key] for key in sorted(buckets)], columns=["time_s", *columns])
print(live[["time_s", "temperature_c_sector1", "wind_speed_m_s"]].describe())

# %% [markdown]
# ## A picture

# %%
figure, axes = plt.subplots(3, 1, figsize=(8, 8), sharex=True, layout="constrained")
axes[0].plot(live["time_s"], live["true_wind_speed_m_s"], color="0.7", linewidth=4, label="true")
axes[0].plot(live["time_s"], live["wind_speed_m_s"], linewidth=1, label="estimate")
for k, style in enumerate(["-", "--", "-.", ":"], 1):
    axes[1].plot(live["time_s"], live[f"temperature_c_sector{k}"], style, label=f"sector{k}")
    axes[2].plot(live["time_s"], 1e3 * live[f"power_w_sector{k}"].rolling(20).mean(), style, label=f"sector{k}")
axes[0].set(ylabel="wind speed, m/s")
axes[1].set(ylabel="temperature, °C")
axes[2].set(xlabel="time, s", ylabel="power, mean of 2 s, mW")
for place, where in zip(axes, ["upper left", "lower right", "upper right"]):
    place.legend(loc=where, ncols=4, fontsize="small")
figure.savefig(folder / "live_stream.png", dpi=120)

# %% [markdown]
# ## What was claimed

# %%
assert code == 0 and live["time_s"].iloc[-1] > UNTIL_S - 1
assert live["time_s"].diff().max() < 0.15  # no bucket is missing
steady = live[live["time_s"] > 90]  # warm by then
assert (steady["temperature_c_sector1"] + 23.15).abs().max() < 0.5
error_m_s = (steady["wind_speed_m_s"] - steady["true_wind_speed_m_s"]).abs().median()
print(f"median error of the speed: {error_m_s:.3f} m/s")
assert error_m_s < 0.2

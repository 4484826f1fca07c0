# %% [markdown]
# # Two calibrations compared
# Two hot films of one drawing, each with a resistor that is 0.06 % off in its own way. Each is calibrated by itself
# with King's law, Nu = A + B Reᵐ. Do they agree within what is stated of them, and what if one is used with the
# calibration of the other? 0.06 % of a resistor is 0.16 K, of 20 K of overheat; speed goes with the square of power.

# %%
import subprocess
import sys
import sysconfig
from pathlib import Path

import anemo
import matplotlib.pyplot as plt
import numpy as np

folder = Path("." if "ipykernel" in sys.modules else [*sys.argv, "."][1])

# %% [markdown]
# ## A head and its experiments
# `anemo head new` writes them for a film on a needle; their seed decides about noise and about the specimen.

# %%
wire = folder / "wire"
if not wire.exists():
    program = Path(sysconfig.get_path("scripts")) / "anemo"
    subprocess.run([program, "head", "new", wire, "--kind", "wire"], check=True, stdout=subprocess.DEVNULL)


def run(name, seed):
    text = (wire / f"{name}.toml").read_text(encoding="utf-8")
    text = text.replace("[front_end]", "[front_end]\nresistance_error_percent = 0.06")
    text = text.replace("seed = 41", f"seed = {seed}")
    return anemo.simulate(anemo.Experiment(text, wire))


# %% [markdown]
# ## Two calibrations
# Quiescent gas first, for the heat that goes into the prongs; then sixty winds of 0.5 to 10 m/s.

# %%
heads, winds = {}, {}
for seed in (41, 42):
    network = anemo.identify_head(run("identify-film", seed))
    heads[seed] = anemo.calibrate(run("tunnel", seed), network=network, law="king", settle=5)
    winds[seed] = run("winds", seed)
    king, report = heads[seed].report.king, heads[seed].report
    print(f"specimen {seed}: exponent {king['exponent']:.6f} ± {king['se_exponent']:.6f},")
    print(f"  cross-validated {100 * report.cross_validated_speeds['speed_rms_error']:.3f} % of speed")

# %% [markdown]
# ## Residuals, in winds that no calibration has seen
# The mean over each wind, three seconds after its beginning, of each specimen by either calibration.


# %%
def errors(seed, by):
    wind = anemo.wind(winds[seed], head=heads[by], bandwidth=1, fixed=True, every=0.1)
    truth = np.hypot(wind["true_wind_x_m_s"], wind["true_wind_y_m_s"])
    settled = (wind["time_s"] >= 60) & (wind["time_s"] % 10 >= 3)
    slots = (wind["time_s"] // 10).astype(int)
    chosen = [settled & (slots == slot) for slot in np.unique(slots[settled])]
    columns = truth, wind["wind_speed_m_s"], wind["wind_speed_u_m_s"]
    truth, estimate, uncertainty = (np.array([column[one].mean() for one in chosen]) for column in columns)
    return truth, 100 * (estimate / truth - 1), 100 * uncertainty / truth


figure, (own, swapped) = plt.subplots(2, 1, figsize=(8, 7), sharex=True, layout="constrained")
rms, worst = {}, {}
for (seed, by), marker in {(41, 41): "o", (42, 42): "s", (41, 42): "x", (42, 41): "+"}.items():
    truth, error, uncertainty = errors(seed, by)
    rms[seed, by], worst[seed, by] = np.sqrt(np.mean(error**2)), np.max(np.abs(error) / uncertainty)
    place = own if seed == by else swapped
    place.errorbar(truth, error, 2 * uncertainty, fmt=marker, capsize=2, label=f"specimen {seed}, calibration of {by}")
for place in (own, swapped):
    place.axhline(0, color="0.5")
    place.set(xscale="log", ylabel="error of the speed, %")
    place.legend()
own.set(title="mean over each wind; bars: two standard uncertainties of an estimate")
swapped.set(xlabel="true wind speed, m/s")
figure.savefig(folder / "calibration.png", dpi=120)
print("rms error in %:", rms)
print("worst in standard uncertainties, which know the noise and the calibration, not the one-bit ripple:", worst)

# %% [markdown]
# ## What was claimed

# %%
one, other = (heads[seed].report.king for seed in (41, 42))
assert abs(one["exponent"] - other["exponent"]) < 3 * np.hypot(one["se_exponent"], other["se_exponent"])
assert rms[41, 41] < 0.05 and rms[42, 42] < 0.05 and min(rms[41, 42], rms[42, 41]) > 1

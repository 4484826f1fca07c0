# %% [markdown]
# # A structure function, beside PyRth
# A chip on a heat sink: three capacities in a chain, C₁ at the heater, R₁, C₂, … A step of 1 W, sampled every 2 ms
# for two minutes with 2 mK of noise, goes into both programs. The chain is known, so that both can be judged.

# %%
import sys
import time
from pathlib import Path

import anemo
import matplotlib.pyplot as plt
import numpy as np
import PyRth

folder = Path("." if "ipykernel" in sys.modules else [*sys.argv, "."][1])
CAPACITY_J_PER_K = np.array([0.02, 0.3, 5.0])
RESISTANCE_K_PER_W = np.array([1.5, 2.0, 4.0])

# %% [markdown]
# ## The transient
# Every capacity C dT/dt = what comes from the left less what goes to the right; the modes of the chain give its exact
# step response.

# %%
between = np.diag(1 / RESISTANCE_K_PER_W)
leads = np.eye(3) - np.eye(3, k=1)  # T_i - T_(i+1), the last to the sink
scale = np.diag(CAPACITY_J_PER_K**-0.5)
rates, modes = np.linalg.eigh(scale @ leads.T @ between @ leads @ scale)
resistance = (scale @ modes)[0] ** 2 / rates  # of every mode, seen by the heater
time_s = np.arange(60_000) * 0.002
noise = np.random.default_rng(1).normal(0, 0.002, len(time_s))
rise_k = (1 - np.exp(-time_s[:, None] * rates)) @ resistance + noise

# %% [markdown]
# ## anemo
# Half a minute of rest belongs to the record: it says what the temperature is without heat.

# %%
rest = 1_500
record = {
    "time_s": np.arange(rest + len(time_s)) * 0.002,
    "power_w": np.r_[np.zeros(rest), np.ones(len(time_s))],
    "temperature_c": 20 + np.r_[np.random.default_rng(2).normal(0, 0.002, rest), rise_k],
}
begin = time.perf_counter()
model = anemo.identify(record, free_poles=3, initial_state="rest")
ours = model.structure()
print(f"{model}\nanemo: {time.perf_counter() - begin:.2f} s")

# %% [markdown]
# ## PyRth
# Deconvolution of the derivative over logarithmic time, Bayesian (its default) or by Lasso, then the chain by its
# default method. It is made for samples that are dense over logarithmic time. The first evaluation compiles.

# %%
dense = np.unique(np.geomspace(1, len(time_s) - 1, 4000).astype(int))
transient = np.column_stack([time_s, rise_k])[dense]
theirs = {}
for mode in ("bayesian", "bayesian", "lasso"):
    begin = time.perf_counter()
    options = {"input_mode": "impedance", "is_heating": True, "deconv_mode": mode, "output_dir": str(folder)}
    module = PyRth.Evaluation().standard_module({"data": transient, "label": "chip", **options})
    theirs[mode] = module.int_cau_res, module.int_cau_cap
    print(f"PyRth, {mode}: {module.int_cau_res[-1]:.3f} K/W, {time.perf_counter() - begin:.2f} s")

# %% [markdown]
# ## Pictures
# A plateau is a resistance that stores nothing, a steep part a capacity. PyRth's spectrum is continuous, with the
# width that deconvolution leaves, so that its steps are rounded; free poles assume that there are few lumps.

# %%
figure, axes = plt.subplots(figsize=(8, 5), layout="constrained")
true = np.cumsum(RESISTANCE_K_PER_W), np.cumsum(CAPACITY_J_PER_K)
axes.step(np.r_[0, true[0]], np.r_[true[1], true[1][-1]], where="post", color="0.7", linewidth=6, label="the chain")
chain = ours["cumulative_resistance_k_per_w"], ours["cumulative_capacitance_j_per_k"]
axes.step(np.r_[0, chain[0]], np.r_[chain[1], chain[1][-1]], where="post", label="anemo, three free poles")
for (mode, (resistances, capacities)), style in zip(theirs.items(), ["--", ":"]):
    axes.plot(resistances, capacities, style, label=f"PyRth, {mode}")
axes.set(yscale="log", ylim=(1e-3, 100), xlim=(0, 8), xlabel="sum of resistances, K/W", ylabel="sum of capacities, J/K")
axes.legend()
figure.savefig(folder / "structure_function.png", dpi=120)

# %% [markdown]
# ## What was claimed

# %%
print("anemo", chain, "chain", true)
assert np.allclose(chain[0], true[0], rtol=0.02) and np.allclose(chain[1], true[1], rtol=0.05)
for mode, (resistances, capacities) in theirs.items():
    assert abs(resistances[-1] - true[0][-1]) < 0.1, mode
    # In the middle of the second and the third step.
    assert np.allclose(np.interp([2.5, 5.5], resistances, capacities), true[1][1:], rtol=0.15), mode

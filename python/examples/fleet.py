"""Sixteen specimens of one design, each identified by its own record. They differ by the tolerances of production."""

from pathlib import Path

import anemo
import numpy as np

EXPERIMENTS = Path(__file__).resolve().parents[2] / "experiments"
TOLERANCES = {"capacity_percent": 5.0, "conductance_percent": 10.0, "area_percent": 2.0, "normal_deg": 2.0}


def identified(record: anemo.Table) -> dict[str, float]:
    model = anemo.identify(record, output="film1", order=6, mesh=(0.002, 20))
    gain_k_per_w, standard_error = model.steady_gain()
    return {"gain_k_per_w": gain_k_per_w, "standard_error": standard_error}


def main() -> None:
    vary = {"head.body.tolerances": [TOLERANCES], "seed": range(1, 17)}
    table = anemo.sweep(EXPERIMENTS / "specimen.toml", vary, then=identified, results="fleet")
    gains = table["gain_k_per_w"]
    # Distance from the median over the standard deviation, which the median deviation gives (Hampel, JASA 69, 1974).
    distances = abs(gains - np.median(gains)) / (1.4826 * np.median(abs(gains - np.median(gains))))
    for worst in np.argsort(distances)[:-4:-1]:
        gain, error = gains[worst], table["standard_error"][worst]
        print(f"specimen {table['seed'][worst]:2.0f}: {gain:.0f} ± {error:.0f} K/W, {distances[worst]:.1f} deviations away")


if __name__ == "__main__":
    main()

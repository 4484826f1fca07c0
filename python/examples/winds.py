"""Twelve winds around sphere B, three speeds and four directions: the power of its first sector."""

from pathlib import Path

import anemo
import numpy as np

EXPERIMENTS = Path(__file__).resolve().parents[2] / "experiments"


def main() -> None:
    vary = {"wind.speed_m_s": [1.0, 4.0, 16.0], "wind.azimuth_deg": [0.0, 90.0, 180.0, 270.0]}
    table = anemo.sweep(EXPERIMENTS / "steady.toml", vary, results="winds")
    for speed_m_s in (1.0, 4.0, 16.0):
        power_mw = 1e3 * table["steady_power_w_sector1"][table["wind_speed_m_s"] == speed_m_s]
        print(f"{speed_m_s:2.0f} m/s: mean {power_mw.mean():.2f} mW, spread {np.ptp(power_mw):.2f} mW")


if __name__ == "__main__":
    main()

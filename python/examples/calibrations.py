"""Two heads of sphere B, each with resistors of its own: records of its network, the tunnel, the calibration of both."""

from pathlib import Path

import anemo

QUICK = Path(__file__).resolve().parents[2] / "experiments/wind/quick"


def calibrated(*records: anemo.Table) -> anemo.Head:
    network = anemo.identify_head(*records[:-1])
    return anemo.calibrate(records[-1], network=network, settle=10)


def main() -> None:
    experiments = [*sorted(QUICK.glob("identify-*.toml")), QUICK / "tunnel.toml"]
    table = anemo.sweep(experiments, {"seed": [1, 2]}, then=calibrated, results="calibrations")
    for n, seed in enumerate(table["seed"]):
        error_deg = table["cross_validated_directions_direction_rms_error_deg"][n]
        print(f"head {seed:.0f}: {table['grade'][n]}, directions of winds left out within {error_deg:.2f}° rms")


if __name__ == "__main__":
    main()

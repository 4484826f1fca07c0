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
    print(table.report)
    print([name for name in table.columns if "mean_power" not in name and "steady" not in name])


if __name__ == "__main__":
    main()

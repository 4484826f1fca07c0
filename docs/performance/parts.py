#!/usr/bin/env python3
"""Identification in parts beside that of the whole record: four sectors in a gas that drifts, cut at random places.

    cargo xtask python --no-test
    target/tools/python/bin/python docs/performance/parts.py [DURATION_S] [SEED] [RECORDINGS]

Cuts the record 1, 7 and 64 times, sums the parts by `anemo gram`, joins some of them, and identifies all. Prints how far
resistances and standard errors are from those of the whole, of the largest, the most memory that any step took, and sizes.
With RECORDINGS a minute is missing at the end of each of so many stretches: recordings of one head, cut anywhere.
"""
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import anemo
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

ROOT = Path(__file__).resolve().parents[2]
OPTIONS = ["--output", "sector1", "sector2", "sector3", "sector4"]


def record(duration_s):
    """Pseudo-random heat in a gas whose temperature swings."""
    text = (ROOT / "experiments/prbs.toml").read_text()
    lines = [f"duration_s = {duration_s}" if line.startswith("duration_s") else line for line in text.splitlines()]
    lines.insert(lines.index("[gas]") + 1, "swing = { amplitude_k = 0.3, period_s = 700.0 }")
    table = pa.table(anemo.simulate(anemo.Experiment("\n".join(lines), ROOT / "experiments")))
    return table.select([name for name in table.column_names if name.startswith(("time_s", "power_w", "temperature_c"))])


def recordings(table, count):
    """Stretches of a record, a minute apart."""
    if count == 1:
        return [table]
    borders = np.linspace(0, table.num_rows, count + 1).astype(int)
    gap = round(60.0 / (table["time_s"][1].as_py() - table["time_s"][0].as_py()))
    return [table.slice(begin, end - begin - gap) for begin, end in zip(borders, borders[1:])]


def run(*words):
    """A command, the seconds that it took, and its peak of memory in MiB."""
    command = os.environ.get("ANEMO_BIN", str(ROOT / "target/release/anemo"))
    begin = time.perf_counter()
    with tempfile.TemporaryFile("w+") as printed, tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen([command, *map(str, words)], stdout=printed, stderr=said, text=True)
        most_kib = 0
        # The kernel keeps the peak of a process as long as it lives; what rusage has is that of this one, too.
        while process.poll() is None:
            status = Path(f"/proc/{process.pid}/status").read_text()
            most_kib = max([most_kib, *(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM"))])
            time.sleep(0.005)
        took_s = time.perf_counter() - begin
        printed.seek(0), said.seek(0)
        if process.returncode:
            sys.exit(f"anemo {' '.join(map(str, words))}: {said.read()}")
        return printed.read(), took_s, most_kib / 1024


def numbers(model, key):
    return np.concatenate([row[key] for pair in model["pairs"] for row in pair["classes"].values()])


def main():
    duration_s, seed, count = (sys.argv[1:] + ["1500", "1", "1"][len(sys.argv) - 1 :])[:3]
    chance, tables = random.Random(int(seed)), recordings(record(float(duration_s)), int(count))
    table = pa.concat_tables(tables)
    rows = table.num_rows
    with tempfile.TemporaryDirectory() as folder:
        wholes = [Path(folder, f"whole-{at:03}.parquet") for at in range(len(tables))]
        for path, own in zip(wholes, tables):
            pq.write_table(own, path)
        text, whole_s, whole_mib = run("identify", *wholes, *OPTIONS, "--losses", "none", "--json")
        expected = json.loads(text)
        drift = [output["drift"]["kind"] if output.get("drift") else "none" for output in expected["outputs"]]
        print(f"{rows} rows in {count} recordings, drift {', '.join(drift)}; the whole in {whole_s:.1f} s and {whole_mib:.0f} MiB")
        for cuts in (1, 7, 64):
            borders = [0, *sorted(chance.sample(range(1, rows), cuts)), rows]
            parts, sums, mib = [], [], {}
            for part, (begin, end) in enumerate(zip(borders, borders[1:])):
                parts.append(Path(folder, f"{cuts}-part-{part:03}.parquet"))
                pq.write_table(table.slice(begin, end - begin), parts[-1])
            plan = Path(folder, f"{cuts}.plan")
            _, plan_s, mib["plan"] = run("gram", *parts, *OPTIONS, "-o", plan)
            sums_s, mib["sums"] = 0.0, 0.0
            for part in parts:
                sums.append(part.with_suffix(".gram"))
                _, took_s, took_mib = run("gram", part, "--plan", plan, "-o", sums[-1])
                sums_s, mib["sums"] = sums_s + took_s, max(mib["sums"], took_mib)
            joined = Path(folder, f"{cuts}-joined.gram")
            both = chance.randrange(len(sums) - 1)
            _, _, mib["join"] = run("gram", sums[both], sums[both + 1], "-o", joined)
            size_mb = max(of.stat().st_size for of in sums) / 1e6
            sums[both : both + 2] = [joined]
            chance.shuffle(sums)
            text, merged_s, mib["identify"] = run("identify", *sums, "--json")
            model = json.loads(text)
            off = {key: np.abs(numbers(model, key) - numbers(expected, key)).max() / np.abs(numbers(expected, key)).max()
                   for key in ("r_k_per_w", "se_k_per_w")}
            same = model["chosen"]["reasons"] == expected["chosen"]["reasons"]
            print(f"{cuts:3} cuts: R {off['r_k_per_w']:.0e}, standard errors {off['se_k_per_w']:.0e} of the largest, reasons "
                  f"{'the same' if same else 'DIFFER'}; plan {1e6 * plan_s / rows:.1f} µs a row, sums {1e6 * sums_s / rows:.1f} µs, "
                  f"identify {merged_s:.1f} s; {size_mb:.1f} MB a part at most; MiB: "
                  + ", ".join(f"{what} {most:.0f}" for what, most in mib.items()))
            if max(off.values()) > 1e-9 or not same:
                sys.exit("not the model of the whole")


if __name__ == "__main__":
    main()

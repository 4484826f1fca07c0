"""Records of two structures, for docs/explanation/closed-loop.md: an hour of random heat in a steady wind from rest, 20 Hz, 2 mK of noise.

a: the resistor sits in a package, glued to the silver; the silver sees the wind and is fixed to a core of 5 J/K.
b: a bare chip glued to the silver, and a thin support.

python3 docs/closed-loop/structures.py FOLDER writes a.csv and b.csv. Nothing but Python is needed.
"""
import random
import sys

PERIOD_S, STEPS, ROWS = 0.05, 50, 72000
WIND_W_PER_K = 2.0e-3

# Nodes: heat capacity in J/K. Links: (node, node, W/K). The wind cools node `windy`; node 0 is heated and measured.
STRUCTURES = {
    "a": dict(capacities=[0.02, 0.12, 5.0], links=[(0, 1, 1 / 40), (1, 2, 1 / 500)], windy=1, ground=(2, 2e-3)),
    "b": dict(capacities=[0.0047, 0.118], links=[(0, 1, 0.2)], windy=1, ground=(1, 2e-4)),
}


def record(capacities, links, windy, ground, rng):
    rises = [0.0] * len(capacities)
    power = 0.0
    for n in range(ROWS):
        if n % 2 == 0:
            power = rng.choice([0.005, 0.06])
        yield n * PERIOD_S, power, 20.0 + rises[0] + rng.gauss(0.0, 0.002)
        step = PERIOD_S / STEPS
        for _ in range(STEPS):
            flows = [0.0] * len(rises)
            flows[0] += power
            flows[windy] -= WIND_W_PER_K * rises[windy]
            flows[ground[0]] -= ground[1] * rises[ground[0]]
            for i, j, conductance in links:
                heat = conductance * (rises[i] - rises[j])
                flows[i] -= heat
                flows[j] += heat
            rises = [rise + step * flow / capacity for rise, flow, capacity in zip(rises, flows, capacities)]


if __name__ == "__main__":
    for name, structure in STRUCTURES.items():
        with open(f"{sys.argv[1]}/{name}.csv", "w") as file:
            file.write("time_s,power_w,temperature_c\n")
            for time_s, power, temperature in record(**structure, rng=random.Random(name)):
                file.write(f"{time_s:.2f},{power},{temperature:.5f}\n")

"""Spheres A and B as thermal networks: how fast the loop's power answers a wind step, and how slow each sphere is without a loop.

    python3 calibrate_spheres.py

A wind step from 2 to 6 m/s in CO2 at 10 mbar. Closed loop: the heated nodes are held at 30 K of overheat and the power that this takes
is the equivalent control in the limit of fast sampling,

    C dT/dt = -G T + B u,   T_held constant:   u = G_hh T_h + G_hf T_f,   dT_f/dt = -C_f^-1 (G_ff T_f + G_fh T_h)

so the free nodes' eigenvalues are the transmission zeros. Open loop: the same step under constant powers. Settling to x % is the last
time at which the answer is further than x % of its whole change from where it ends. numpy and scipy only; a few seconds.
"""
import json
from math import pi
from pathlib import Path

import numpy as np
from scipy.linalg import eig

DIAMETER_M = 0.01
STEFAN_BOLTZMANN = 5.670374e-8
GAS_K, PRESSURE_PA, OVERHEAT_K = 220.0, 1000.0, 30.0
# CO2 at 220 K, docs of host-sim/src/sensor/gas.rs: viscosity and conductivity do not depend on pressure.
VISCOSITY, CONDUCTIVITY, DENSITY = 11.05e-6, 10.84e-3, PRESSURE_PA * 0.0440095 / (8.314462618 * GAS_K)
TABLE = json.loads((Path(__file__).parents[2] / "host-sim/data/sphere_nusselt_legendre_pr0772.json").read_text())
SECTOR_MEAN = [1.0, 0.744857, 0.367553, 0.045538, -0.108904, -0.100742]
HEMISPHERE_MEAN = [1.0, 0.5, 0.0, -0.125, 0.0, 0.0625]
RADIATION_W_K = 4 * 0.03 * STEFAN_BOLTZMANN * pi * DIAMETER_M**2 * (GAS_K + OVERHEAT_K / 2) ** 3


def legendre_coefficients(speed):
    re = DENSITY * speed * DIAMETER_M / VISCOSITY
    keys = sorted(TABLE, key=float)
    grid = np.log([float(k) for k in keys])
    return [np.interp(np.log(re), grid, [TABLE[k]["a"][n] for k in keys]) for n in range(6)]


def convection(speed, means, cosines):
    """W/K of each part of the sphere whose axis stands at acos(cosine) from the front stagnation point."""
    a = legendre_coefficients(speed)
    values = [sum(a[n] * means[n] * np.polynomial.legendre.legval(c, np.eye(6)[n]) for n in range(6)) for c in cosines]
    return np.array(values) * CONDUCTIVITY * pi * DIAMETER_M / len(cosines)


class Sphere:
    """Named nodes; `shell` are those that see the gas, `heated` their resistors, `cores` the heated nodes inside."""
    def __init__(self):
        self.names, self.c, self.links, self.ground = [], [], [], []
        self.shell, self.heated, self.cores = [], [], []

    def node(self, name, capacity):
        self.names.append(name)
        self.c.append(capacity)
        return len(self.c) - 1

    def conductance(self, gas):
        g = np.zeros((len(self.c),) * 2)
        for a, b, w in self.links:
            g[a, a] += w
            g[b, b] += w
            g[a, b] -= w
            g[b, a] -= w
        for a, w in self.ground:
            g[a, a] += w
        for a, w in zip(self.shell, gas):
            g[a, a] += w + RADIATION_W_K / len(self.shell)
        return g

    def stem(self, total_w_k, capacity, cells, cores):
        cell = total_w_k * cells
        nodes = [self.node(f"stem{k + 1}", capacity / cells) for k in range(cells)]
        for core in cores:
            self.links.append((core, nodes[0], 2 * cell / len(cores)))
        self.links += [(a, b, cell) for a, b in zip(nodes, nodes[1:])]
        self.ground.append((nodes[-1], 2 * cell))


B_PARAMETERS = [
    ("sector", 0.118, "J/K", "published 0.5 g of silver, 235 J/(kg K)"),
    ("chip", 4.7e-3, "J/K", "derived: silicon 2.5 x 2.5 x 0.5 mm"),
    ("contact", 2.0, "W/K", "derived: soldered; half of the chip 0.2, solder 0.1, spreading in the silver 0.2 K/W"),
    ("sector_core", 6e-4, "W/K", "assumed: gas gap and wires"),
    ("sector_sector", 1e-4, "W/K", "assumed: three seams each"),
    ("core", 0.075, "J/K", "derived: one FR4 board of 6 x 6 x 0.8 mm with copper, solder and resistor"),
    ("core_core", 0.02, "W/K", "derived: boards back to back, 36 mm2 of FR4 and some vias"),
    ("stem", 1.2e-3, "W/K", "assumed; 8 cells"),
    ("stem_capacity", 0.2, "J/K", "assumed"),
]


def sphere_b(**changed):
    """The body of heads/sphere-b.toml."""
    p = {name: value for name, value, _, _ in B_PARAMETERS} | changed
    s = Sphere()
    sectors = [s.node(f"sector{i + 1}", p["sector"]) for i in range(4)]
    chips = [s.node(f"chip{i + 1}", p["chip"]) for i in range(4)]
    cores = [s.node(f"core{i + 1}", p["core"]) for i in range(2)]
    for i in range(4):
        s.links += [(chips[i], sectors[i], p["contact"]), (sectors[i], cores[i // 2], p["sector_core"])]
        s.links += [(sectors[i], sectors[j], p["sector_sector"]) for j in range(i)]
    s.links.append((cores[0], cores[1], p["core_core"]))
    s.stem(p["stem"], p["stem_capacity"], 8, cores)
    s.shell, s.heated, s.cores = sectors, chips, cores
    s.means, s.cosines = SECTOR_MEAN, [1.0, -1 / 3, -1 / 3, -1 / 3]
    return s


A_PARAMETERS = [
    ("hemisphere", 0.282, "J/K", "published 1.2 g of silver, 235 J/(kg K)"),
    ("film", 1.0e-3, "J/K", "derived: film under its glass cover, about 1.2 mg at 0.8 J/(g K)"),
    ("ceramic", 3.8e-3, "J/K", "derived: alumina 0.5 x 1.25 x 2 mm, 4.9 mg, 780 J/(kg K)"),
    ("film_ceramic", 0.10, "W/K", "derived: 2.5 mm2 of alumina, 25 W/(m K) / 0.5 mm = 0.125, cover and spreading"),
    ("ceramic_hemisphere", 8.0e-3, "W/K", "calibrated (tail of tens of seconds): 2.5 mm2 of unfilled epoxy, 0.25 W/(m K), 80 um"),
    ("hemisphere_hemisphere", 3.0e-3, "W/K", "assumed: equator, 19 mm2 of joint 0.1 mm wide: gas 2 mW/K, dots of epoxy 1 mW/K"),
    ("hemisphere_core", 2.5e-3, "W/K", "assumed: two spacers and four copper wires of 0.1 mm (0.5 mW/K each at 6 mm), gas 0.5 mW/K"),
    ("core", 0.075, "J/K", "as in sphere B: one FR4 board of 6 x 6 x 0.8 mm with copper, solder and resistor"),
    ("core_core", 0.02, "W/K", "as in sphere B: boards back to back"),
    ("stem", 2.0e-3, "W/K", "assumed: thicker than B's 1.2 mW/K, for the SMD parts' wires"),
    ("stem_capacity", 0.3, "J/K", "assumed, with it; 8 cells"),
]


def sphere_a(**changed):
    p = {name: value for name, value, _, _ in A_PARAMETERS} | changed
    s = Sphere()
    shells = [s.node(f"hemisphere{i + 1}", p["hemisphere"]) for i in range(2)]
    films = [s.node(f"film{i + 1}", p["film"]) for i in range(2)]
    ceramics = [s.node(f"ceramic{i + 1}", p["ceramic"]) for i in range(2)]
    cores = [s.node(f"core{i + 1}", p["core"]) for i in range(2)]
    for i in range(2):
        s.links += [(films[i], ceramics[i], p["film_ceramic"]), (ceramics[i], shells[i], p["ceramic_hemisphere"]),
                    (shells[i], cores[i], p["hemisphere_core"])]
    s.links += [(shells[0], shells[1], p["hemisphere_hemisphere"]), (cores[0], cores[1], p["core_core"])]
    s.stem(p["stem"], p["stem_capacity"], 8, cores)
    s.shell, s.heated, s.cores = shells, films, cores
    s.means, s.cosines = HEMISPHERE_MEAN, [1.0, -1.0]
    return s


def settling(time, answer, end, percent):
    off = np.abs(answer - end) > percent / 100 * abs(end - answer[0])
    return 0.0 if not off.any() else time[np.nonzero(off)[0][-1]]


# Geometric times from 1 ms to 3 h.
TIME = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 1401)])


def path(matrix, start, end):
    """Deviation from `end` of dT/dt = matrix (T - end), at all of TIME, through the eigenvectors."""
    rates, v = eig(matrix)
    weights = np.linalg.solve(v, (start - end).astype(complex))
    return end + np.real(np.exp(np.outer(TIME, rates)) * weights @ v.T)


def closed_loop(s, which, held):
    """Power of the first of the `held` nodes over time, W, for a step of the gas on the parts in `which`. Elements that are not held
    keep the power that they had."""
    before = convection(2.0, s.means, s.cosines)
    after = before.copy(); after[which] = convection(6.0, s.means, s.cosines)[which]
    g0, g1 = s.conductance(before), s.conductance(after)
    free = [i for i in range(len(s.c)) if i not in held]
    t_h = np.full(len(held), OVERHEAT_K)
    given = powers(s, s.heated)[free] if len(held) < len(s.heated) else np.zeros(len(free))
    rest = lambda g: np.linalg.solve(g[np.ix_(free, free)], given - g[np.ix_(free, held)] @ t_h)
    c = np.array(s.c)[free]
    temperatures = path(-g1[np.ix_(free, free)] / c[:, None], rest(g0), rest(g1))
    power = g1[np.ix_(held, held)] @ t_h + temperatures @ g1[np.ix_(held, free)].T
    # A held chip is not in the wind itself, so its power has no jump.
    end = g1[np.ix_(held, held)] @ t_h + g1[np.ix_(held, free)] @ rest(g1)
    zeros = np.sort(np.linalg.eigvals(-g1[np.ix_(free, free)] / c[:, None]).real)[::-1]
    return power[:, 0], end[0], zeros


def powers(s, held, speed=2.0):
    """What holds the nodes in `held` at the overheat, W a node."""
    g = s.conductance(convection(speed, s.means, s.cosines))
    free = [i for i in range(len(s.c)) if i not in held]
    t = np.zeros(len(s.c))
    t[held] = OVERHEAT_K
    t[free] = -np.linalg.solve(g[np.ix_(free, free)], g[np.ix_(free, held)] @ t[held])
    power = g @ t
    power[free] = 0.0
    return power


def open_loop(s, hold):
    """Overheat of the first heated node, constant powers: those that gave 30 K on all heated nodes at 2 m/s."""
    before, after = convection(2.0, s.means, s.cosines), convection(6.0, s.means, s.cosines)
    power = powers(s, s.heated + (s.cores if hold else []))
    g1 = s.conductance(after)
    t = np.linalg.solve(s.conductance(before), power)
    end = np.linalg.solve(g1, power)
    temperatures = path(-g1 / np.array(s.c)[:, None], t, end)
    return temperatures[:, s.heated[0]], end[s.heated[0]]


def at(time_s, answer):
    return np.interp(time_s, TIME, answer)


def report(name, s):
    everywhere = list(range(len(s.shell)))
    print(f"\n{name}: gas at 2 m/s {np.round(1e3 * convection(2.0, s.means, s.cosines), 3)}, 6 m/s "
          f"{np.round(1e3 * convection(6.0, s.means, s.cosines), 3)} mW/K")
    slowest = {}
    for cores in (True, False):
        for which, text in ((everywhere, "all parts"), ([0], "front part only")):
            power, end, zeros = closed_loop(s, which, s.heated + (s.cores if cores else []))
            times = [settling(TIME, power, end, x) for x in (10, 5, 2)]
            left = 100 * (at(1.0, power) - end) / (end - power[0])
            print(f"  closed, cores {'held' if cores else 'free'}, {text:16}: {1e3 * power[0]:.2f} -> {1e3 * end:.2f} mW, to 10/5/2 %: "
                  + " / ".join(f"{x:.3g}" for x in times) + f" s, after 1 s {left:+.2f} %; slow zeros 1/"
                  + ", 1/".join(f"{-1 / z:.3g}" for z in zeros[:4]) + " s")
            slowest[cores, text] = times, left
        overheat, end = open_loop(s, cores)
        free = [settling(TIME, overheat, end, x) for x in (10, 5, 2)]
        print(f"  open,   cores {'warm' if cores else 'cold'}, all parts       : {overheat[0]:.2f} -> {end:.2f} K, to 10/5/2 %: "
              + " / ".join(f"{x:.4g}" for x in free) + " s")
        slowest[cores, "open"] = free, None
    power, end, _ = closed_loop(s, everywhere, s.heated[:1])
    times = [settling(TIME, power, end, x) for x in (10, 5, 2)]
    left = 100 * (at(1.0, power) - end) / (end - power[0])
    print(f"  closed, one element alone, others at constant power: {1e3 * power[0]:.2f} -> {1e3 * end:.2f} mW, to 10/5/2 %: "
          + " / ".join(f"{x:.3g}" for x in times) + f" s, after 1 s {left:+.2f} %")
    slowest[None, "one element alone"] = times, left
    for speed in (2.0, 13.0):
        all_held, cold = powers(s, s.heated + s.cores, speed), powers(s, s.heated, speed)
        print(f"  at {speed:.0f} m/s, {OVERHEAT_K:.0f} K: the front element takes {1e3 * all_held[s.heated[0]]:.1f} mW "
              f"({1e3 * cold[s.heated[0]]:.1f} with passive cores), a core {1e3 * all_held[s.cores[0]]:.1f} mW")
    return slowest


STATE = {True: "held", False: "free", None: "free"}


if __name__ == "__main__":
    for name, parameters in (("A", A_PARAMETERS), ("B", B_PARAMETERS)):
        print(f"sphere {name}")
        for row in parameters:
            print("  {:22} {:8.4g} {:5} {}".format(*row))
    print(f"  radiation, all of the sphere {1e6 * RADIATION_W_K:.1f} uW/K")
    a = report("sphere A", sphere_a())
    b = report("sphere B as it is", sphere_b())
    report("sphere A, silver-filled glue (0.1 W/K)", sphere_a(ceramic_hemisphere=0.1))
    for contact in (0.2, 0.5, 1.0, 4.0):
        report(f"sphere B, contact {contact} W/K", sphere_b(contact=contact))
    print("\nobservation                                              published             ours")
    for (cores, text), (times, left) in a.items():
        if text != "open":
            verdict = "met" if times[1] >= 20 else "NOT MET"
            print(f"A, cores {STATE[cores]}, {text:17}: tail to 5 %, s       tens of seconds      {times[1]:.0f} {verdict}")
    for (cores, text), (times, left) in b.items():
        if text != "open":
            verdict = "met" if abs(left) < 2 and times[2] < 1 else "NOT MET"
            print(f"B, cores {STATE[cores]}, {text:17}: left after 1 s, %    under 2              {left:+.2f} {verdict}")
    for name, x in (("A", a), ("B", b)):
        for cores in (True, False):
            ratio = x[cores, "open"][0][2] / x[cores, "all parts"][0][2]
            print(f"{name}, cores {STATE[cores]}: open / closed, to 2 %               {'over 100' if name == 'B' else '-':20} {ratio:.0f}")

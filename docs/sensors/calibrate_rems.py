"""The REMS-type transducer as a thermal network, and what comes out of it against what was published.

    python3 calibrate_rems.py [FOLDER]

Three cards at 120 degrees on a boom, four silicon dice (2 x 2) a card, one platinum resistor a die that heats and senses, a Pt100 on
the boom; 240 mbar of air at 21 degrees C. Prints every parameter with its origin, then every observation with ours. With a FOLDER, the
records go there as CSV, to be identified with `anemo identify`. numpy and scipy only; about a minute.

    gas ── die ── leg ── card ── boom head ── shank, 3 cells ── support
            │      │       │         │              │
         the next die    gas       gas, Pt100      gas
         and leg of the card (a ring of four)

Axes: x along the boom, the tip at +x; card k has the outward normal (0, cos, sin) of 90, 210 and 330 degrees. Wind is the vector the
air moves along, so head-on is (-U, 0, 0).
"""
import itertools
import sys
from math import pi, sqrt

import numpy as np
from scipy.linalg import eigh, expm
from scipy.optimize import minimize, nnls
from scipy.signal import lfilter

# --- gas: air, as in host-sim/src/sensor/gas.rs (ideal gas, Sutherland) ---------------------------------------------------------
GAS_C, PRESSURE_PA = 21.0, 24e3
T = GAS_C + 273.15
DENSITY = PRESSURE_PA * 0.0289647 / (8.314462618 * T)
SUTHERLAND = lambda at, constant: at * (T / 273.15) ** 1.5 * (273.15 + constant) / (T + constant)
VISCOSITY, CONDUCTIVITY = SUTHERLAND(1.716e-5, 110.4), SUTHERLAND(0.0241, 194.4)
HEAT_CAPACITY = 1005.0
NU_M2_S = VISCOSITY / DENSITY
PRANDTL = VISCOSITY * HEAT_CAPACITY / CONDUCTIVITY
STEFAN_BOLTZMANN = 5.670374e-8

# --- geometry ------------------------------------------------------------------------------------------------------------------
DIE_M, DIE_THICK_M, GAP_M = 1.5e-3, 0.25e-3, 0.7e-3
LEG_M2, LEG_HIGH_M = 0.64e-6, 0.3e-3
CARD_LONG_M, CARD_WIDE_M, CARD_THICK_M = 45e-3, 22e-3, 0.6e-3
HEAD_D_M, HEAD_LONG_M = 10e-3, 18e-3
SHANK_CELLS = 3

# --- parameters: (value, unit, origin) -------------------------------------------------------------------------------------------
P = {}


def given(name, value, unit, origin):
    P[name] = (value, unit, origin)
    return value


def plate_still():
    """Natural convection of an upright plate, Churchill and Chu (laminar), at 5 K; W/(m2 K)."""
    rayleigh = 9.81 / T * 5.0 * CARD_WIDE_M**3 * PRANDTL / NU_M2_S**2
    nusselt = 0.68 + 0.670 * rayleigh**0.25 / (1 + (0.492 / PRANDTL) ** (9 / 16)) ** (4 / 9)
    return nusselt * CONDUCTIVITY / CARD_WIDE_M


def cylinder_still(diameter):
    """Natural convection of a horizontal cylinder, Churchill and Chu (laminar), at 5 K; W/(m2 K)."""
    rayleigh = 9.81 / T * 5.0 * diameter**3 * PRANDTL / NU_M2_S**2
    nusselt = 0.36 + 0.518 * rayleigh**0.25 / (1 + (0.559 / PRANDTL) ** (9 / 16)) ** (4 / 9)
    return nusselt * CONDUCTIVITY / diameter


C_DIE = given("C_die", 9.3e-4, "J/K", "derived: silicon 1.5 x 1.5 x 0.25 mm (thickness assumed), 2330 kg/m3, 710 J/(kg K)")
C_LEG = given("C_leg", 3.2e-4, "J/K", "derived: four Pyrex legs 0.4 x 0.4 x 0.3 mm, 2230 kg/m3, 750 J/(kg K)")
G_DIE_LEG = given("G_die_leg", 4.7e-3, "W/K", "derived: upper half of the legs, 0.64 mm2 x 1.1 W/(m K) / 0.15 mm")
G_LEG_CARD = given("G_leg_card", 1.63e-3, "W/K", "calibrated (pole of a die 0.24 Hz); lower half of the legs 4.7, in series with a "
                   "1.5 mm footprint on a board of 0.7 W/(m K) with its tracks 2.4 and bond wires 0.1 mW/K, gives 1.63")
G_LEG_LEG = given("G_leg_leg", 3.7e-4, "W/K", "calibrated (diagonal against adjacent die): board and tracks between neighbours")
G_DIE_DIE = given("G_die_die", 1.4e-5, "W/K", "derived: gas between two sides, k 1.5 x 0.25 mm2 / 0.7 mm")
C_CARD = given("C_card", 1.1, "J/K", "derived: FR4 45 x 22 x 0.6 mm (assumed), 1850 kg/m3, 1000 J/(kg K); pole near 2e-3 Hz")
C_HEAD = given("C_head", 3.6, "J/K", "calibrated (pole near 2e-4 Hz): solid aluminium, 10 mm, 18 mm long (assumed) is 3.4, Pt100 and screws")
G_CARD_HEAD = given("G_card_head", 6.7e-4, "W/K", "calibrated (rise of the boom): two plastic posts and wires")
G_SHANK = given("G_shank", 2.0e-4, "W/K", "derived: glass-fibre tube, 28 mm2 x 0.4 W/(m K), and 27 manganin wires over 0.1 m; in 3 cells")
C_SHANK = given("C_shank", 4.8, "J/K", "derived: the same tube, 100 mm long, 28 mm2 x 1.7 J/(cm3 K), as a whole")
EMISSIVITY = given("emissivity_card", 0.9, "", "assumed: bare FR4 outside; inside it faces gold and does not radiate")
H_CARD = given("h_card_still", plate_still(), "W/(m2 K)", "derived: upright plate, Churchill and Chu at 5 K")
H_HEAD = given("h_head_still", cylinder_still(HEAD_D_M), "W/(m2 K)", "derived: horizontal cylinder, Churchill and Chu at 5 K; gold-plated")
G_DIE_STILL = given("G_die_gas_still", 4 / sqrt(pi) * CONDUCTIVITY * DIE_M, "W/K", "derived: square on a plane into a half space, 4/sqrt(pi) k a")
DIE_EXPOSED = given("A_die_exposed", DIE_M**2 + 4 * DIE_M * DIE_THICK_M, "m2", "derived: face and four sides")
SHADE = given("shade_reverse", 0.3, "", "assumed: share of the speed that is left behind the boom's root and the carriage (head-on 1)")
ROWS = given("front_to_rear", 0.10, "", "assumed: upstream dice 1 + 0.1, downstream 1 - 0.1 (thicker boundary layer and warm wake)")
R0, ALPHA = given("R_die_0C", 2600.0, "ohm", "calibrated: 4 mA must hold 52 C and give about 10 K of cross-heating"), 0.0031
given("alpha_die", ALPHA, "1/K", "assumed: thin film, as prototype B")
I_LOW, I_HIGH = given("I_low", 1e-3, "A", "published"), given("I_high", 4e-3, "A", "published")
PT100, PT100_ALPHA = 100.0, 3.85e-3

CARD_M2 = CARD_LONG_M * CARD_WIDE_M
HEAD_M2 = pi * HEAD_D_M * HEAD_LONG_M
SHANK_M2 = pi * 10e-3 * 0.1
H_RADIATION = EMISSIVITY * 4 * STEFAN_BOLTZMANN * T**3

# --- wind law ------------------------------------------------------------------------------------------------------------------
NORMALS = [np.array([0.0, np.cos(a), np.sin(a)]) for a in np.radians([90.0, 210.0, 330.0])]
X = np.array([1.0, 0.0, 0.0])
# Places of the dice of a card, (along the boom, around it): 0 tip-left, 1 tip-right, 2 root-right, 3 root-left; a ring.
PLACES = [(1, -1), (1, 1), (-1, 1), (-1, -1)]


def card_flow(wind, k):
    """Effective speed over card k and the direction of the stream over it (along, around), of length one at most."""
    wind = np.asarray(wind, float)
    speed = np.linalg.norm(wind)
    if speed == 0:
        return 0.0, (0.0, 0.0)
    head_on = -wind[0] / speed
    axial = wind[0] * ((1 + SHADE) / 2 + (1 - SHADE) / 2 * head_on)
    across = np.linalg.norm(wind[1:])
    facing = -wind @ NORMALS[k] / across if across > 0 else 0.0
    cross = across * (0.8 + 0.5 * facing)           # front 1.3, side 0.8, rear 0.3: a cylinder at Re 10-100
    effective = sqrt(axial**2 + cross**2)
    around = wind @ np.cross(X, NORMALS[k])
    return effective, (axial / effective, min(1.0, abs(around) / effective) * np.sign(around))


def plate_wind(speed, length):
    """Laminar plate, Nu = 0.664 Re^1/2 Pr^1/3; W/(m2 K)."""
    return 0.664 * sqrt(speed * length / NU_M2_S) * PRANDTL ** (1 / 3) * CONDUCTIVITY / length


def cylinder_wind(speed, diameter):
    """Churchill and Bernstein; W/(m2 K)."""
    re = speed * diameter / NU_M2_S
    nusselt = 0.3 + 0.62 * sqrt(re) * PRANDTL ** (1 / 3) / (1 + (0.4 / PRANDTL) ** (2 / 3)) ** 0.25 * (1 + (re / 282e3) ** 0.625) ** 0.8
    return nusselt * CONDUCTIVITY / diameter


def joined(still, wind):
    """Free and forced together, Churchill's blend with n = 4 (flow across)."""
    return (still**4 + wind**4) ** 0.25


def gas_conductances(wind):
    """W/K to the gas of every die [card][die], of every card, of the head and of a shank cell."""
    dice, cards, speeds = [], [], []
    for k in range(3):
        speed, (along, around) = card_flow(wind, k)
        speeds.append(speed)
        forced = plate_wind(speed, DIE_M) * DIE_EXPOSED if speed else 0.0
        # A die is upstream if its place is opposite to the stream.
        dice.append([G_DIE_STILL + forced * (1 - ROWS * (along * a + around * b)) for a, b in PLACES])
        outer = joined(H_CARD, plate_wind(speed, CARD_LONG_M)) if speed else H_CARD
        cards.append(CARD_M2 * (outer + H_RADIATION + H_CARD))
    mean = float(np.mean(speeds))
    head = HEAD_M2 * (joined(H_HEAD, cylinder_wind(mean, HEAD_D_M)) if mean else H_HEAD)
    shank = SHANK_M2 / SHANK_CELLS * (joined(H_HEAD, cylinder_wind(mean, HEAD_D_M)) if mean else H_HEAD)
    return dice, cards, head, shank


# --- network -------------------------------------------------------------------------------------------------------------------
die, leg, card = (lambda k, i: 9 * k + i), (lambda k, i: 9 * k + 4 + i), (lambda k: 9 * k + 8)
HEAD = 27
NODES = 28 + SHANK_CELLS
CAPACITY = np.empty(NODES)
for k in range(3):
    CAPACITY[9 * k:9 * k + 9] = [C_DIE] * 4 + [C_LEG] * 4 + [C_CARD]
CAPACITY[HEAD:] = [C_HEAD] + [C_SHANK / SHANK_CELLS] * SHANK_CELLS


def conductance(wind):
    links, ground = [], []
    dice, cards, head, shank = gas_conductances(wind)
    for k in range(3):
        for i in range(4):
            j = (i + 1) % 4
            links += [(die(k, i), leg(k, i), G_DIE_LEG), (leg(k, i), card(k), G_LEG_CARD),
                      (leg(k, i), leg(k, j), G_LEG_LEG), (die(k, i), die(k, j), G_DIE_DIE)]
            ground.append((die(k, i), dice[k][i]))
        links.append((card(k), HEAD, G_CARD_HEAD))
        ground.append((card(k), cards[k]))
    ground.append((HEAD, head))
    cell = G_SHANK * SHANK_CELLS
    links.append((HEAD, HEAD + 1, 2 * cell))
    links += [(HEAD + c, HEAD + c + 1, cell) for c in range(1, SHANK_CELLS)]
    ground += [(HEAD + c, shank) for c in range(1, SHANK_CELLS + 1)]
    ground.append((HEAD + SHANK_CELLS, 2 * cell))    # the support is at gas temperature
    g = np.zeros((NODES, NODES))
    for a, b, w in links:
        g[a, a] += w
        g[b, b] += w
        g[a, b] -= w
        g[b, a] -= w
    for a, w in ground:
        g[a, a] += w
    return g


def modes(wind):
    """Rates, and V with Z_ij(s) = sum of V_im V_jm / (s + rate_m)."""
    s = 1 / np.sqrt(CAPACITY)
    rates, v = eigh(s[:, None] * conductance(wind) * s)
    return rates, s[:, None] * v


class Step:
    """Exact step of `ts` with powers held, under one wind."""
    def __init__(self, wind, ts):
        a = -conductance(wind) / CAPACITY[:, None]
        self.a = expm(a * ts)
        self.b = np.linalg.solve(a, self.a - np.eye(NODES)) / CAPACITY


ELEMENTS = [die(k, i) for k in range(3) for i in range(4)] + [HEAD]
R_0 = np.array([R0] * 12 + [PT100])
ALPHAS = np.array([ALPHA] * 12 + [PT100_ALPHA])
NOISE_K = 2e-3


def simulate(ts, n, current, wind=None, winds=((0.0, 0.0, 0.0),), seed=1, settle=None, keep=1):
    """`current(n, temperatures)` gives 13 currents; `wind(n)` an index. Temperatures (with noise) and powers, 13 columns each."""
    rng = np.random.default_rng(seed)
    steps = [Step(w, ts) for w in winds]
    rise = np.zeros(NODES)
    if settle is not None:                        # steady state under constant currents
        for _ in range(8):
            power = np.zeros(NODES); power[ELEMENTS] = settle**2 * R_0 * (1 + ALPHAS * (GAS_C + rise[ELEMENTS]))
            rise = np.linalg.solve(conductance(winds[0]), power)
    temperatures, powers = np.empty((n // keep, 13)), np.zeros((n // keep, 13))
    noise = NOISE_K * rng.standard_normal((n, 13))
    bs = [s.b[:, ELEMENTS] for s in steps]
    for m in range(n):
        true_c = GAS_C + rise[ELEMENTS]
        read_c = true_c + noise[m]
        power = current(m, read_c) ** 2 * R_0 * (1 + ALPHAS * true_c)
        if m % keep == 0:
            temperatures[m // keep] = read_c
        powers[m // keep] += power / keep
        w = wind(m) if wind else 0
        rise = steps[w].a @ rise + bs[w] @ power
    return temperatures, powers


def prbs(n, hold, seed):
    """The first bit is low, so that the record begins settled under what it begins with."""
    bits = np.random.default_rng(seed).integers(0, 2, n // hold + 1)
    bits[0] = 0
    return np.repeat(bits, hold)[:n]


# --- identification, in the main as `anemo identify --order K --mesh FIRST:LAST --initial-state settled` does it -------------------------------------------------
def states(u, rates, ts):
    """x_k of the normalised state, settled under the first input."""
    gains = -np.expm1(-np.asarray(rates) * ts)
    return np.stack([lfilter([0, g], [1, g - 1], u, zi=[u[0] * (1 - g)])[0] for g in gains], 1)


def mesh_fit(columns, y, non_negative):
    """Least squares with an offset; columns of unit norm, a ridge of 1e-9."""
    a = columns - columns.mean(0)
    b = y - y.mean()
    norm = np.linalg.norm(a, axis=0); norm[norm == 0] = 1
    gram = (a / norm).T @ (a / norm) + 1e-9 * np.eye(a.shape[1])
    right = (a / norm).T @ b
    if non_negative:
        c = np.linalg.cholesky(gram)
        x, _ = nnls(c.T, np.linalg.solve(c, right), maxiter=5000)
    else:
        x = np.linalg.solve(gram, right)
    return x / norm, float(np.std(b - (a / norm) @ x))


def write(name, ts, temperatures, powers, event=None):
    if len(sys.argv) < 2:
        return
    names = [f"die{k + 1}{i + 1}" for k in range(3) for i in range(4)] + ["boom"]
    keep = [0, 1, 2, 3, 12]
    with open(f"{sys.argv[1]}/{name}.csv", "w") as file:
        head = ["time_s", "power_w:card1"] + [f"power_w:{names[i]}" for i in keep] + [f"temperature_c:{names[i]}" for i in keep]
        file.write(",".join(head + (["event"] if event else [])) + "\n")
        for m in range(len(temperatures)):
            row = [f"{m * ts:.3f}", f"{powers[m, :4].sum():.7g}"] + [f"{powers[m, i]:.7g}" for i in keep] + [f"{temperatures[m, i]:.5f}" for i in keep]
            file.write(",".join(row + ([event[m]] if event else [])) + "\n")


LOW = np.array([I_LOW] * 12 + [1e-3])             # passive elements carry the low level; the boom's Pt100 is read at 1 mA
TABLE = []


def observe(what, published, ours, ok, residual=""):
    TABLE.append((what, published, ours, residual, "met" if ok else "NOT MET"))


def hz(rates):
    return np.asarray(rates) / (2 * pi)


def ratio(ours, published):
    return f"{100 * (ours / published - 1):+.0f} %"


# --- observations ----------------------------------------------------------------------------------------------------------------
MESH_STILL = np.geomspace(1 / 900, 10, 8) * 2 * pi
MESH_WIND = np.geomspace(2 * pi * 3 / 1700, 75.0, 8)
MESH_CROSS = np.geomspace(0.0024, 10.0, 7)
MESH_BOOM = np.geomspace(2 * pi / 72000, 2 * pi * 0.02, 6)


def self_heating_still():
    ts, n = 0.05, 18000
    peaks = []
    for i in range(4):
        bits = prbs(n, 2, 10 + i)
        def current(m, _):
            c = LOW.copy(); c[i] = I_HIGH if bits[m] else I_LOW; return c
        t, p = simulate(ts, n, current, settle=LOW, seed=20 + i)
        r, rms = mesh_fit(states(p[:, i], MESH_STILL, ts), t[:, i], True)
        k = int(np.argmax(r)); peaks.append(r[k])
        if i == 0:
            write("self-still", ts, t, p)
            observe("self, still: peak, Hz", "0.2 ±20 %", f"{hz(MESH_STILL)[k]:.3f}", abs(hz(MESH_STILL)[k] / 0.2 - 1) <= 0.2, ratio(hz(MESH_STILL)[k], 0.2))
            print("self still: mesh Hz", hz(MESH_STILL).round(4), "R", r.round(1), f"rms {1e3 * rms:.1f} mK")
    spread = max(peaks) / min(peaks) - 1
    observe("self, still: four dice alike", "5 %", f"{100 * spread:.1f} %", spread < 0.05)


WINDS = [(0.0, 0.0, 0.0), (-0.125, 0.0, 0.0), (0.125, 0.0, 0.0)]
LABELS = ["still", "head-on", "reverse"]


def self_heating_wind():
    ts, n, run = 0.025, 68000, 1600
    order = np.array([[1, 0, 2, 0][m % 4] for m in range(n // run + 1)])
    wind = np.repeat(order, run)[:n]
    for i in (0, 2):
        bits = prbs(n, 2, 40 + i)
        def current(m, _):
            c = LOW.copy(); c[i] = I_HIGH if bits[m] else I_LOW; return c
        t, p = simulate(ts, n, current, wind=lambda m: wind[m], winds=WINDS, settle=LOW, seed=50 + i)
        u = p[:, i]
        columns = np.hstack([states(u * (wind == j), MESH_WIND, ts) for j in range(3)])
        r, rms = mesh_fit(columns, t[:, i], True)
        r = r.reshape(3, 8)
        k = int(np.argmax(r[0]))
        print(f"self wind die {i + 1}: mesh Hz", hz(MESH_WIND).round(4), f"rms {1e3 * rms:.1f} mK")
        for j in range(3):
            print(f"   {LABELS[j]:8}", r[j].round(1), "sum", r[j].sum().round(1))
        change = r[0] - r[1]
        others = np.abs(np.delete(change, k)).max()
        if i == 0:
            write("self-wind", ts, t, p, [LABELS[j] for j in wind])
            observe("self, wind run: peak, Hz", "0.3 ±20 %", f"{hz(MESH_WIND)[k]:.3f}", abs(hz(MESH_WIND)[k] / 0.3 - 1) <= 0.2, ratio(hz(MESH_WIND)[k], 0.3))
            observe("self, wind: largest other change / peak's (mesh)", "< 10 %", f"{100 * others / abs(change[k]):.0f} %", others < 0.1 * abs(change[k]))
        observe(f"self, wind: die {i + 1} peak still > reverse > head-on, K/W", "order", " > ".join(f"{x:.1f}" for x in (r[0, k], r[2, k], r[1, k])),
                r[0, k] > r[2, k] > r[1, k])


def clusters():
    """Modes of the network itself, in three groups: what the wind changes in the self-heating of die 1."""
    sums = []
    for wind in WINDS:
        rates, v = modes(wind)
        r = v[0] ** 2 / rates
        f = hz(rates)
        sums.append([r[(f >= a) & (f < b)].sum() for a, b in ((0, 0.02), (0.02, 1), (1, 99))])
    for label, row in zip(LABELS, sums):
        print(f"true self-heating, {label:8}: slow {row[0]:.1f}, die {row[1]:.1f}, fast {row[2]:.1f} K/W")
    change = np.array(sums[0]) - np.array(sums[1])
    observe("self, wind: other true changes / the pole's", "< 10 %", f"slow {100 * change[0] / change[1]:.0f} %, fast {100 * change[2] / change[1]:.0f} %",
            np.abs(change[[0, 2]]).max() < 0.1 * change[1])


def cross_heating():
    ts, n = 0.4, 9000
    for w, name in enumerate(LABELS):
        bits = prbs(n, 2, 60)
        def current(m, _):
            c = LOW.copy(); c[0] = I_HIGH if bits[m] else I_LOW; return c
        t, p = simulate(ts, n, current, winds=[WINDS[w]], settle=LOW, seed=70)
        r = [mesh_fit(states(p[:, 0], MESH_CROSS, ts), t[:, j], False)[0] for j in (1, 3, 2)]
        k = int(np.argmax(r[0]))
        print(f"cross {name}: mesh Hz", hz(MESH_CROSS).round(4), *(x.round(1) for x in r))
        if w == 0:
            write("cross-still", ts, t, p)
            still, peak = r, k
            observe("cross: peak of an adjacent die, Hz", "0.1 ±20 %", f"{hz(MESH_CROSS)[k]:.3f}", abs(hz(MESH_CROSS)[k] / 0.1 - 1) <= 0.2, ratio(hz(MESH_CROSS)[k], 0.1))
            observe("cross: two adjacent dice alike", "10 %", f"{100 * abs(r[0][k] / r[1][k] - 1):.1f} %", abs(r[0][k] / r[1][k] - 1) < 0.1)
            observe("cross: diagonal / adjacent at the peak", "< 40 %", f"{100 * r[2][k] / r[0][k]:.0f} %", abs(r[2][k] / r[0][k]) < 0.4)
        else:
            observe(f"cross: change of the peak, {name}", "none", f"{100 * (r[0][peak] / still[0][peak] - 1):+.1f} %", abs(r[0][peak] / still[0][peak] - 1) < 0.1)
    n = 36000
    bits = [prbs(n, 1, 80 + i) for i in range(4)]
    def current(m, _):
        c = LOW.copy(); c[:4] = [I_HIGH if b[m] else I_LOW for b in bits]; return c
    t, p = simulate(0.1, n, current, settle=LOW, seed=71)
    z = np.linalg.inv(conductance(WINDS[0]))
    extra = sum(z[0, j] * (p[-18000:, j].mean() - p[:, 4].mean()) for j in (1, 2, 3))
    whole = sum(z[0, j] * p[-18000:, j].mean() for j in (1, 2, 3))
    print(f"four PRBS: die at {t[-18000:, 0].mean():.1f} C, powers {1e3 * p[-18000:, 0].mean():.1f} mW")
    observe("four dice PRBS: cross-heating on a die, K", "10 (8-12)", f"{whole:.1f} ({extra:.1f} above passive)", 8 <= whole <= 12, ratio(whole, 10))


def regulated(targets, boom=None):
    """Sigma-delta loops: high if the reading is under the target; nan is passive. `boom(m)` gives the boom's current."""
    def current(m, read_c):
        c = np.where(read_c < targets(m), np.array([I_HIGH] * 12 + [19.9e-3]), LOW)
        if boom:
            c[12] = boom(m, read_c)
        return c
    return current


def passive():
    return np.full(13, np.nan)


def boom_setpoints():
    ts, n = 0.1, 720000
    points = np.random.default_rng(5).choice([42.0, 47.0, 52.0], (241, 4))
    def targets(m):
        x = passive()
        if m >= 10:                                # a second of low level first, so that the record begins settled
            x[:4] = points[m // 3000]
        return x
    t, p = simulate(ts, n, regulated(targets), settle=LOW, seed=6, keep=10)
    u = p[:, :4].sum(1)
    r, rms = mesh_fit(states(u, MESH_BOOM, 1.0), t[:, 12], False)
    print("boom: mesh Hz", hz(MESH_BOOM).round(6), "R", r.round(2), f"rms {1e3 * rms:.1f} mK")
    rates, v = modes(WINDS[0])
    residue = v[0] * v[HEAD] / rates
    big = np.argsort(-np.abs(residue))[:4]
    print("boom: true poles Hz", hz(rates[big]).round(6), "R", residue[big].round(2))
    # Two free rates, by search: the pair of poles that explains the record best.
    def miss(x):
        return mesh_fit(states(u, np.exp(x), 1.0), t[:, 12], False)[1]
    best = minimize(miss, np.log([1.3e-3, 1.3e-2]), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-9, "maxiter": 120})
    free = np.sort(hz(np.exp(best.x)))
    for ours, published in zip(free, (2e-4, 2e-3)):
        observe("boom: pole (two free), Hz", f"{published:g} x/÷ 1.5", f"{ours:.2e}", 1 / 1.5 < ours / published < 1.5, ratio(ours, published))
    write("boom", 1.0, t, p)
    z = np.linalg.inv(conductance(WINDS[0]))
    per_watt = z[0, :4].sum()
    rise = 17 / per_watt * 4 * z[0, HEAD]
    observe("boom: rise for 17 K of overheat of four dice, K", "0.6-0.7", f"{rise:.2f}", 0.6 <= rise <= 0.7, ratio(rise, 0.65))


def boom_switched(air_c):
    """3 h on, 3 h off, twice: dice at 42 C in air at `air_c`."""
    ts, n = 0.1, 6 * 36000
    def targets(m):
        x = passive()
        if m < 3 * 36000: x[:4] = 42.0 - air_c + GAS_C
        return x
    t, p = simulate(ts, n, regulated(targets), settle=LOW, seed=8, keep=10)
    rise = t[10000:10800, 12].mean() - t[-800:, 12].mean()
    observe(f"boom: dice switched to 42 C, rise in air at {air_c:.0f} C, K", "0.5 (±20 %)", f"{rise:.2f}", 0.4 <= rise <= 0.6, ratio(rise, 0.5))


def boom_held():
    ts, n = 0.1, 4 * 36000
    def boom(m, read):
        return (19.9e-3 if read[12] < 28.5 else 10e-3) if m < 2 * 36000 else 1e-3
    t, p = simulate(ts, n, regulated(lambda m: passive(), boom), settle=LOW, seed=9, keep=10)
    on, off = slice(6400, 7200), slice(13600, 14400)
    held = t[on, 12].mean()
    warm = t[on, 0].mean() - t[off, 0].mean()
    print(f"boom held: {held:.3f} C at {1e3 * p[on, 12].mean():.1f} mW (levels 11.1 and 44 mW), falls to {t[off, 12].mean():.2f}")
    observe("boom held at 28.5 C, C", "28.5", f"{held:.2f}", abs(held - 28.5) < 0.02)
    observe("boom held: passive dice warm with it, K", "> 0", f"{warm:.2f}", warm > 0.1)


def boom_prbs():
    ts, n = 0.1, 36000
    bits = prbs(n, 1200, 3)
    def targets(m):
        x = passive(); x[:4] = 40.0; return x
    boom = lambda m, read: 19.9e-3 if bits[m] else 8.9e-3
    start = LOW.copy(); start[:4] = 3.0e-3; start[12] = 8.9e-3
    t, p = simulate(ts, n, regulated(targets, boom), settle=start, seed=11, keep=10)
    boom_c, dice_w = t[600:, 12].reshape(-1, 60).mean(1), p[600:, :4].sum(1).reshape(-1, 60).mean(1)
    hot = np.corrcoef(boom_c, dice_w)[0, 1]
    slope = np.polyfit(boom_c, dice_w, 1)[0]
    swing = np.ptp(boom_c)
    observe("boom PRBS: slope of four dice's power on the boom, mW/K", "< 0", f"{1e3 * slope:.2f} (r {hot:.2f}, boom moves {swing:.1f} K)", slope < 0)


def closed_loop():
    """Predicted from the true network: the mean power of the loop at 42 C against the equivalent control of held nodes."""
    z = np.linalg.inv(conductance(WINDS[0]))
    def targets(m):
        x = passive(); x[0] = 42.0; return x
    t, p = simulate(0.1, 26000, regulated(targets), settle=LOW, seed=12, keep=10)
    measured = p[2000:, 0].mean()
    others = p[2000:, 1:].mean(0)
    background = z[0, ELEMENTS[1:]] @ others
    mean_c = t[2000:, 0].mean()
    expected = (mean_c - GAS_C - background) / z[0, 0]
    # At 10 Hz the die swings by kelvins and its mean is not the set-point: a prediction has to know that.
    print(f"closed loop: mean reading {mean_c:.2f} C; power at the set-point would be {1e3 * (42 - GAS_C - background) / z[0, 0]:.2f} mW")
    observe("closed loop, still: power, network at the mean reading", "≤ 2 %", f"{1e3 * measured:.2f} / {1e3 * expected:.2f} mW",
            abs(measured / expected - 1) < 0.02, ratio(measured, expected))


def reach():
    """Power that each die of a card needs for every choice of 42, 47 and 52 C, all others passive."""
    z = np.linalg.inv(conductance(WINDS[0]))[np.ix_(ELEMENTS, ELEMENTS)]
    low = LOW**2 * R_0 * (1 + ALPHAS * GAS_C)
    floor = z[:4, 4:] @ low[4:]
    needed = [np.linalg.solve(z[:4, :4], np.array(c) - GAS_C - floor) for c in itertools.product([42.0, 47.0, 52.0], repeat=4)]
    levels = [i**2 * R0 * (1 + ALPHA * c) for i, c in ((I_LOW, 42), (I_HIGH, 42))]
    observe("42/47/52 C in any choice: power of a die, mW", f"{1e3 * levels[0]:.1f} to {1e3 * levels[1]:.1f}",
            f"{1e3 * np.min(needed):.1f} to {1e3 * np.max(needed):.1f}", levels[0] < np.min(needed) and np.max(needed) < levels[1])


if __name__ == "__main__":
    for name, (value, unit, origin) in P.items():
        print(f"{name:18} {value:10.4g} {unit:9} {origin}")
    for label, wind in zip(LABELS, WINDS):
        dice, cards, head, shank = gas_conductances(wind)
        print(f"gas, {label:8}: dice of card 1 {np.round(1e3 * np.array(dice[0]), 4)} card {1e3 * cards[0]:.3f} head {1e3 * head:.3f} shank cell {1e3 * shank:.3f} mW/K")
    for yaw in (0, 45, 90, 135, 180):
        wind = -0.5 * np.array([np.cos(np.radians(yaw)), np.sin(np.radians(yaw)), 0])
        print(f"0.5 m/s from yaw {yaw:3}: mean die of cards 1-3", [f"{1e3 * np.mean(d):.4f}" for d in gas_conductances(wind)[0]], "mW/K")
    rates, v = modes(WINDS[0])
    for name, j in (("self", 0), ("adjacent", 1), ("diagonal", 2), ("boom", HEAD)):
        r = v[0] * v[j] / rates
        big = np.abs(r) > 3e-3 * np.abs(r).max()
        print(f"true {name}: {r.sum():.1f} K/W =", "  ".join(f"{a:.3g} Hz {b:.1f}" for a, b in zip(hz(rates[big]), r[big])))
    self_heating_still()
    self_heating_wind()
    clusters()
    cross_heating()
    boom_setpoints()
    boom_switched(21.0)
    boom_switched(27.0)
    boom_held()
    boom_prbs()
    closed_loop()
    reach()
    print()
    for row in TABLE:
        print("{:58} {:14} {:34} {:8} {}".format(*row))

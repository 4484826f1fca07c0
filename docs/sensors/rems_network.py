"""The REMS-type transducer as a thermal network: every capacity, link, boundary and wind law, with its origin. See calibrate_rems.py.

    gas ── die ── leg ── card ── boom head ── shank, 3 cells ── support
            │      │       │         │              │
         the next die    gas       gas, Pt100      gas
         and leg of the card (a ring of four)

Axes: x along the boom, the tip at +x; card k has the outward normal (0, cos, sin) of 90, 210 and 330 degrees. Wind is the vector the
air moves along, so head-on is (-U, 0, 0).
"""
from math import pi, sqrt

import numpy as np
from scipy.linalg import eigh

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
C_HEAD = given("C_head", 3.6, "J/K", "calibrated (pole near 2e-4 Hz): aluminium 10 mm x 18 mm (assumed) 3.4, Pt100 and screws")
G_CARD_HEAD = given("G_card_head", 6.7e-4, "W/K", "calibrated (rise of the boom): two plastic posts and wires")
G_SHANK = given("G_shank", 2.0e-4, "W/K", "derived: glass-fibre tube, 28 mm2 x 0.4 W/(m K), and 27 manganin wires over 0.1 m; in 3 cells")
C_SHANK = given("C_shank", 4.8, "J/K", "derived: the same tube, 100 mm long, 28 mm2 x 1.7 J/(cm3 K), as a whole")
EMISSIVITY = given("emissivity_card", 0.9, "", "assumed: bare FR4 outside; inside it faces gold and does not radiate")
H_CARD = given("h_card_still", plate_still(), "W/(m2 K)", "derived: upright plate, Churchill and Chu at 5 K")
H_HEAD = given("h_head_still", cylinder_still(HEAD_D_M), "W/(m2 K)", "derived: horizontal cylinder, Churchill and Chu at 5 K; gold-plated")
G_DIE_STILL = given("G_die_gas_still", 4 / sqrt(pi) * CONDUCTIVITY * DIE_M, "W/K",
                    "derived: square on a plane into a half space, 4/sqrt(pi) k a")
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

//! Transport properties of the gas in the simulated wind tunnel: carbon dioxide or dry air at low
//! density.
//!
//! ```text
//! ρ  = p M / (R T)                                     ideal gas
//! cp = R (7/2 + Σ_j g_j x_j² eˣ / (eˣ − 1)²)           rigid rotor and harmonic modes, J/(mol·K)
//!      x_j = θ_j / T
//! µ  = 1.00697 √T / exp(Σ a_i ln(T / 251.196)^i) µPa·s CO2, Fenghour, Wakeham, Vesovic 1998
//! k  = 0.475598 √T (1 + r²) / Σ b_i T*^−i     mW/(m·K) CO2 from 200 K, Vesovic et al. 1990
//! µ, k of air: Sutherland, with the constants of White, Viscous Fluid Flow
//! ```
//!
//! The conductivity of Vesovic 1990 must not be extrapolated below 200 K (at 150 K it would give Pr
//! = 1.12), so there the Prandtl number is held at its value of 200 K, 0.772, and k = µ cp / Pr.
//!
//! Limits: 150–400 K and 1 Pa–200 kPa, where viscosity and conductivity do not depend on pressure
//! and the gas is ideal within 2 % (CO2 must also be a gas: below its vapour pressure). Air agrees
//! with tables within 2 %.

use serde::{Deserialize, Serialize};

/// Why a gas cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{name}` is {value}; it must be {expected}")]
pub struct GasError {
    /// The experiment's key, or an option.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Values that it may have.
    pub expected: &'static str,
}

/// Molar gas constant, J/(mol·K), exact by definition of the SI.
const MOLAR_GAS_CONSTANT: f64 = 8.314_462_618_153_24;
/// Second radiation constant h c / k_B in K·cm: turns a wave number in cm⁻¹ into a temperature in
/// K.
const KELVIN_PER_WAVE_NUMBER: f64 = 1.438_776_877;
/// Zero of the Celsius scale, K.
pub const ZERO_CELSIUS_K: f64 = 273.15;

/// Temperatures at which the properties are known, K.
pub const TEMPERATURE_RANGE_K: std::ops::RangeInclusive<f64> = 150.0..=400.0;
/// Pressures at which they are, Pa.
pub const PRESSURE_RANGE_PA: std::ops::RangeInclusive<f64> = 1.0..=200_000.0;

/// Lowest temperature at which the conductivity of Vesovic 1990 holds, K.
const VESOVIC_LOWEST_K: f64 = 200.0;

/// A gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Species {
    /// Carbon dioxide.
    #[serde(rename = "co2")]
    CarbonDioxide,
    /// Dry air.
    #[serde(rename = "air")]
    Air,
}

impl Species {
    /// Name in experiments.
    pub fn name(self) -> &'static str {
        match self {
            Species::CarbonDioxide => "co2",
            Species::Air => "air",
        }
    }

    /// By the name that experiments and recordings have for it.
    pub fn named(name: &str) -> Option<Self> {
        [Species::CarbonDioxide, Species::Air].into_iter().find(|species| species.name() == name)
    }
}

/// A gas at rest at one temperature and pressure, with its properties computed once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealGas {
    /// Gas.
    pub species: Species,
    /// Temperature, K.
    pub temperature_k: f64,
    /// Pressure, Pa.
    pub pressure_pa: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Dynamic viscosity, Pa·s.
    pub viscosity_pa_s: f64,
    /// Thermal conductivity, W/(m·K).
    pub conductivity_w_m_k: f64,
    /// Heat capacity at constant pressure, J/(kg·K).
    pub heat_capacity_j_kg_k: f64,
}

impl IdealGas {
    /// Properties of `species`; refuses what lies outside 150–400 K and 1 Pa–200 kPa
    /// (`gas.temperature_c`, `gas.pressure_pa`).
    pub fn new(species: Species, pressure_pa: f64, temperature_k: f64) -> Result<IdealGas, GasError> {
        check_temperature("gas.temperature_c", temperature_k)?;
        check_pressure("gas.pressure_pa", pressure_pa)?;
        Ok(IdealGas::of(species, pressure_pa, temperature_k))
    }

    fn of(species: Species, pressure_pa: f64, temperature_k: f64) -> IdealGas {
        IdealGas {
            species,
            temperature_k,
            pressure_pa,
            density_kg_m3: pressure_pa * molar_mass(species) / (MOLAR_GAS_CONSTANT * temperature_k),
            viscosity_pa_s: viscosity(species, temperature_k),
            conductivity_w_m_k: conductivity(species, temperature_k),
            heat_capacity_j_kg_k: heat_capacity(species, temperature_k),
        }
    }

    /// The same gas at another temperature and the same pressure. Whoever asks has found that
    /// temperature to be in the range.
    pub fn at(&self, temperature_k: f64) -> IdealGas {
        IdealGas::of(self.species, self.pressure_pa, temperature_k)
    }

    /// Pr = µ cp / k.
    pub fn prandtl(&self) -> f64 {
        self.viscosity_pa_s * self.heat_capacity_j_kg_k / self.conductivity_w_m_k
    }

    /// Re = ρ U d / µ.
    pub fn reynolds(&self, speed_m_s: f64, diameter_m: f64) -> f64 {
        self.density_kg_m3 * speed_m_s * diameter_m / self.viscosity_pa_s
    }

    /// Kn = λ / d with the mean free path λ = (µ / p) √(π R T / (2 M)).
    pub fn knudsen(&self, diameter_m: f64) -> f64 {
        let specific = MOLAR_GAS_CONSTANT / molar_mass(self.species);
        let thermal = (std::f64::consts::FRAC_PI_2 * specific * self.temperature_k).sqrt();
        self.viscosity_pa_s / self.pressure_pa * thermal / diameter_m
    }
}

/// Refuses a temperature at which the properties are not known; `name` is its key or option.
pub fn check_temperature(name: &'static str, temperature_k: f64) -> Result<(), GasError> {
    // −123.15 °C is 150 K but for its last digits.
    let (coldest_k, hottest_k) = (TEMPERATURE_RANGE_K.start() - 1e-3, TEMPERATURE_RANGE_K.end() + 1e-3);
    if (coldest_k..=hottest_k).contains(&temperature_k) {
        return Ok(());
    }
    // Without the tail of digits that the difference has.
    let value = ((temperature_k - ZERO_CELSIUS_K) * 1e9).round() / 1e9;
    Err(GasError { name, value, expected: "-123.15 to 126.85 °C, where the gas properties are known" })
}

/// Refuses a pressure at which they are not known.
pub fn check_pressure(name: &'static str, pressure_pa: f64) -> Result<(), GasError> {
    if PRESSURE_RANGE_PA.contains(&pressure_pa) {
        return Ok(());
    }
    Err(GasError { name, value: pressure_pa, expected: "1 to 200000 Pa, where the gas properties are known" })
}

fn molar_mass(species: Species) -> f64 {
    match species {
        Species::CarbonDioxide => 0.044_009_5,
        Species::Air => 0.028_964_7,
    }
}

/// Isobaric heat capacity of the ideal gas, J/(kg·K).
fn heat_capacity(species: Species, temperature_k: f64) -> f64 {
    let mode = |wave_number: f64| {
        let x = KELVIN_PER_WAVE_NUMBER * wave_number / temperature_k;
        // e^−x instead of e^x: a high mode in a cold gas must vanish, not overflow.
        let e = libm::exp(-x);
        x * x * e / ((1.0 - e) * (1.0 - e))
    };
    let over_r = match species {
        Species::CarbonDioxide => 3.5 + 2.0 * mode(667.4) + mode(1333.0) + mode(2349.0),
        // Nitrogen 78.1 %, oxygen 21.0 %, argon 0.9 % (which has 5/2 and no modes).
        Species::Air => 3.5 - 0.009 + 0.781 * mode(2330.0) + 0.210 * mode(1556.0),
    };
    over_r * MOLAR_GAS_CONSTANT / molar_mass(species)
}

/// Dynamic viscosity, Pa·s.
fn viscosity(species: Species, temperature_k: f64) -> f64 {
    match species {
        Species::CarbonDioxide => {
            const A: [f64; 5] = [0.235156, -0.491266, 5.211155e-2, 5.347906e-2, -1.537102e-2];
            let l = libm::log(temperature_k / 251.196);
            let exponent = A.iter().rev().fold(0.0, |sum, a| sum * l + a);
            1.00697e-6 * temperature_k.sqrt() / libm::exp(exponent)
        }
        Species::Air => sutherland(1.716e-5, 273.15, 110.4, temperature_k),
    }
}

/// Thermal conductivity, W/(m·K).
fn conductivity(species: Species, temperature_k: f64) -> f64 {
    match species {
        Species::CarbonDioxide if temperature_k < VESOVIC_LOWEST_K => {
            let prandtl = viscosity(species, VESOVIC_LOWEST_K) * heat_capacity(species, VESOVIC_LOWEST_K)
                / vesovic(VESOVIC_LOWEST_K);
            viscosity(species, temperature_k) * heat_capacity(species, temperature_k) / prandtl
        }
        Species::CarbonDioxide => vesovic(temperature_k),
        Species::Air => sutherland(0.0241, 273.15, 194.4, temperature_k),
    }
}

/// Conductivity of dilute carbon dioxide, Vesovic et al., J. Phys. Chem. Ref. Data 19 (1990) 763,
/// from 200 K.
fn vesovic(temperature_k: f64) -> f64 {
    const B: [f64; 8] = [0.4226159, 0.6280115, -0.5387661, 0.6735941, 0.0, 0.0, -0.4362677, 0.2255388];
    const C: [f64; 5] = [2.387869e-2, 4.350794, -10.33404, 7.981590, -1.940558];
    let t = temperature_k / 100.0;
    let internal: f64 = C.iter().zip([t, 1.0, 1.0 / t, 1.0 / (t * t), 1.0 / (t * t * t)]).map(|(c, t)| c * t).sum();
    let r_squared = 0.4 * (1.0 + libm::exp(-183.5 / temperature_k) * internal);
    let inverse = 251.196 / temperature_k;
    let collision = B.iter().rev().fold(0.0, |sum, b| sum * inverse + b);
    0.475598e-3 * temperature_k.sqrt() * (1.0 + r_squared) / collision
}

fn sutherland(at_reference: f64, reference_k: f64, constant_k: f64, temperature_k: f64) -> f64 {
    at_reference * libm::pow(temperature_k / reference_k, 1.5) * (reference_k + constant_k)
        / (temperature_k + constant_k)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a unit of the last printed digit of a table, plus what rounding of the inputs may add.
    fn agrees(value: f64, printed: f64, last_digit: f64) -> bool {
        (value - printed).abs() <= 0.5001 * last_digit
    }

    #[test]
    fn carbon_dioxide_agrees_with_the_table_of_the_literature_to_every_printed_digit() {
        for (t, mu, k, k_digit, cp, pr, rho) in [
            (150.0, 7.53, 6.7, 0.1, 687.0, 0.772, 0.0247),
            (200.0, 10.04, 9.56, 0.01, 735.0, 0.772, 0.0185),
            (220.0, 11.05, 10.84, 0.01, 758.0, 0.773, 0.0168),
            (260.0, 13.05, 13.62, 0.01, 803.0, 0.770, 0.0143),
            (300.0, 15.01, 16.73, 0.01, 846.0, 0.759, 0.0124),
        ] {
            let gas = IdealGas::new(Species::CarbonDioxide, 700.0, t).unwrap();
            assert!(agrees(gas.viscosity_pa_s * 1e6, mu, 0.01), "µ at {t} K: {}", gas.viscosity_pa_s);
            assert!(agrees(gas.conductivity_w_m_k * 1e3, k, k_digit), "k at {t} K: {}", gas.conductivity_w_m_k);
            assert!(agrees(gas.heat_capacity_j_kg_k, cp, 1.0), "cp at {t} K: {}", gas.heat_capacity_j_kg_k);
            // One unit: the table was made from rounded µ, cp and k (0.7694 is printed as 0.770).
            assert!((gas.prandtl() - pr).abs() <= 0.001, "Pr at {t} K: {}", gas.prandtl());
            assert!(agrees(gas.density_kg_m3, rho, 1e-4), "ρ at {t} K: {}", gas.density_kg_m3);
        }
    }

    #[test]
    fn conductivity_has_no_step_where_its_two_forms_meet() {
        let below = conductivity(Species::CarbonDioxide, 200.0 - 1e-9);
        let above = conductivity(Species::CarbonDioxide, 200.0);
        assert!((below / above - 1.0).abs() < 1e-9);
    }

    #[test]
    fn air_agrees_with_standard_tables() {
        // Incropera, table A.4, dry air at 1 atm; 2 % is the accuracy of Sutherland's form over
        // this range.
        for (t, mu, k, cp, pr) in [
            (200.0, 13.25e-6, 18.1e-3, 1007.0, 0.737),
            (300.0, 18.46e-6, 26.3e-3, 1007.0, 0.707),
            (400.0, 23.01e-6, 33.8e-3, 1014.0, 0.690),
        ] {
            let gas = IdealGas::new(Species::Air, 101_325.0, t).unwrap();
            assert!((gas.viscosity_pa_s / mu - 1.0).abs() < 0.02, "µ {}", gas.viscosity_pa_s);
            assert!((gas.conductivity_w_m_k / k - 1.0).abs() < 0.02, "k {}", gas.conductivity_w_m_k);
            assert!((gas.heat_capacity_j_kg_k / cp - 1.0).abs() < 0.01, "cp {}", gas.heat_capacity_j_kg_k);
            assert!((gas.prandtl() / pr - 1.0).abs() < 0.02, "Pr {}", gas.prandtl());
        }
    }

    #[test]
    fn refuses_what_lies_outside_the_range_of_validity() {
        for (pressure, temperature, name) in [
            (700.0, 149.0, "gas.temperature_c"),
            (700.0, 401.0, "gas.temperature_c"),
            (700.0, f64::NAN, "gas.temperature_c"),
            (0.5, 220.0, "gas.pressure_pa"),
            (-700.0, 220.0, "gas.pressure_pa"),
            (f64::INFINITY, 220.0, "gas.pressure_pa"),
        ] {
            let error = IdealGas::new(Species::CarbonDioxide, pressure, temperature).unwrap_err();
            assert!(error.to_string().contains(name), "{error}");
        }
    }

    #[test]
    fn a_ten_millimetre_sphere_on_mars_is_in_a_continuum() {
        // The literature gives 2–6e-4 between 6 and 12 mbar.
        let gas = IdealGas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap();
        assert!((2e-4..6e-4).contains(&gas.knudsen(0.01)), "{}", gas.knudsen(0.01));
    }
}

//! Sphere B with effects of the field, against balances by hand.

use super::*;
use crate::sensor::body::STEFAN_BOLTZMANN;
use crate::sensor::field::{
    Buoyancy, BuoyancyModel, DriftQuantity, ElementDrift, FieldEffects, GasProperties, Sky, Stem, StemWake, Sun,
    SurfaceHeat,
};
use anemometry::gas::ZERO_CELSIUS_K;
use std::f64::consts::PI;

const SECTORS: usize = 4;
/// Area of a sector, m².
const AREA_M2: f64 = PI * 1e-4 / 4.0;

const SUN: Sun = Sun {
    irradiance_w_m2: 300.0,
    absorptivity: 0.17,
    elevation_deg: 35.264_39,
    azimuth_deg: 45.0,
    turn_deg: 360.0,
    period_s: Some(400.0),
    start_s: 0.0,
};
const BUOYANCY: Buoyancy =
    Buoyancy { gravity_m_s2: 9.81, up: [0.0, 0.0, 1.0], model: BuoyancyModel::Advected, kappa1: 0.5, kappa2: 0.82 };
const STEM: Stem =
    Stem { conductance_w_k: 2e-4, conductance_w_k_per_root_m_s: 5e-4, axis: [0.0, 0.0, -1.0], wake: None };

/// Sphere B in a steady wind, in the steady state of its low levels.
fn sensor(wind_m_s: f64, field: FieldEffects) -> Sensor {
    Sensor::new(&with(wind_m_s, field)).unwrap()
}

fn with(speed_m_s: f64, field: FieldEffects) -> SensorConfig {
    let wind = WindEntry { turbulence: None, speed_m_s, ..breeze().remove(0) };
    SensorConfig { wind: vec![wind], field, ..SensorConfig::default() }
}

fn drift(element: &str, quantity: DriftQuantity, change: f64) -> FieldEffects {
    let drift = ElementDrift { element: element.into(), quantity, change, start_s: 0.0, until_s: None };
    FieldEffects { drifts: vec![drift], ..FieldEffects::default() }
}

fn heat(surface: &str, power_w: f64) -> SurfaceHeat {
    SurfaceHeat { surface: surface.into(), power_w, start_s: 0.0, until_s: None }
}

/// Everything at once.
fn all() -> FieldEffects {
    let drifts = [
        ("sector1", DriftQuantity::Resistance, 1e-3),
        ("sector2", DriftQuantity::Gain, -0.05),
        ("sector3", DriftQuantity::Contact, -0.2),
        ("sector4", DriftQuantity::Emissivity, 3.0),
    ];
    let drift = |(element, quantity, change): (&str, DriftQuantity, f64)| ElementDrift {
        element: element.into(),
        quantity,
        change,
        start_s: 20.0,
        until_s: Some(120.0),
    };
    FieldEffects {
        surface_heat: vec![heat("sector2", 1e-3)],
        sun: Some(SUN),
        sky: Some(Sky { temperature_c: Some(-93.15), emissivity: Some(0.1) }),
        drifts: drifts.map(drift).to_vec(),
        gas_properties: GasProperties::Film,
        buoyancy: Some(BUOYANCY),
        stem: Some(Stem { wake: Some(StemWake { angle_deg: 60.0, factor: 0.8, deflection_deg: 5.0 }), ..STEM }),
    }
}

#[test]
fn heat_in_is_heat_out_and_heat_stored_with_all_effects() {
    let config = SensorConfig {
        gas_swing: Some(TemperatureSwing { amplitude_k: 10.0, period_s: 60.0, start_s: 0.0 }),
        ..with(1.0, all())
    };
    let mut sensor = Sensor::new(&config).unwrap();
    let before = sensor.body.stored_heat_j();
    let (mut given, mut left) = (0.0, 0.0);
    for tick in 0..20_000_u16 {
        sensor.advance(usize::from(tick.wrapping_mul(40_503) >> 3) & 0x3F);
        let flows = sensor.truth().flows;
        given += flows.power_w.iter().chain(&flows.absorbed_w).sum::<f64>() * config.sample_period_s;
        let gas_w = flows.convection_w.iter().chain(&flows.radiation_w).sum::<f64>();
        left += (gas_w + flows.support_w + flows.stem_w) * config.sample_period_s;
    }
    let balance = given - left - (sensor.body.stored_heat_j() - before);
    // Same as without effects: rounding of what is stored from absolute zero on.
    assert!((balance / given).abs() < 1e-8, "{balance} J of {given} J");
}

#[test]
fn a_surface_loses_the_heat_that_is_put_onto_it() {
    let plain = sensor(3.0, FieldEffects::default()).truth();
    let warm =
        sensor(3.0, FieldEffects { surface_heat: vec![heat("sector1", 1e-3)], ..FieldEffects::default() }).truth();
    // The chips' own power changes by 0.3 % a kelvin of 1.5 mW.
    for i in 0..SECTORS {
        let gained = warm.surface_loss_w(i) - plain.surface_loss_w(i);
        let heating = warm.flows.power_w[i] - plain.flows.power_w[i];
        let expected = if i == 0 { 1e-3 } else { 0.0 };
        assert!((gained - heating - expected).abs() < 1e-9, "sector {i}: {gained}");
    }
    // The same milliwatt in the chip warms the silver as much.
    let rise = warm.surface_temperature_c[0] - plain.surface_temperature_c[0];
    let mut heated = sensor(3.0, FieldEffects::default());
    let before_c = heated.body.surface_temperature_c(0);
    let low: Vec<f64> = plain.flows.power_w.clone();
    heated.body.settle(|i, _| low[i] + if i == 0 { 1e-3 } else { 0.0 });
    let expected = heated.body.surface_temperature_c(0) - before_c;
    assert!((rise / expected - 1.0).abs() < 0.01, "{rise} K for {expected} K");
}

#[test]
fn the_sun_that_faces_a_sector_puts_three_milliwatts_onto_it_and_then_onto_the_next() {
    let mut sensor = sensor(3.0, FieldEffects { sun: Some(SUN), ..FieldEffects::default() });
    let first = sensor.truth().flows.absorbed_w;
    // α E A ⟨cos⟩ with the mean cosine 0.7476 of a sector that faces the sun.
    assert!((first[0] - 0.17 * 300.0 * AREA_M2 * 0.7476).abs() < 2e-5, "{first:?}");
    assert!((2.9e-3..3.1e-3).contains(&first[0]), "{first:?}");
    // Half a turn later sector 4, (−1, −1, 1), is where sector 1 was.
    for _ in 0..20_001 {
        sensor.advance(0);
    }
    let later = sensor.truth().flows.absorbed_w;
    assert!((later[3] - first[0]).abs() < 1e-8 && (later[0] - first[3]).abs() < 1e-8, "{later:?}");
    let cross_section_w = 0.17 * 300.0 * AREA_M2;
    assert!((later.iter().sum::<f64>() - cross_section_w).abs() < 1e-12);
}

#[test]
fn surfaces_radiate_to_the_sky_with_their_emissivity() {
    let sky = Sky { temperature_c: Some(-93.15), emissivity: Some(0.13) };
    let mut effects = drift("sector3", DriftQuantity::Emissivity, 1.0);
    effects.sky = Some(sky);
    let truth = sensor(3.0, effects).truth();
    for i in 0..SECTORS {
        let surface_k = truth.surface_temperature_c[i] + ZERO_CELSIUS_K;
        let emissivity = if i == 2 { 0.26 } else { 0.13 };
        let expected = emissivity * STEFAN_BOLTZMANN * AREA_M2 * (surface_k.powi(4) - 180.0_f64.powi(4));
        assert!((truth.flows.radiation_w[i] / expected - 1.0).abs() < 1e-9, "sector {i}");
    }
    // Without numbers it is what is there already.
    let nothing = FieldEffects { sky: Some(Sky { temperature_c: None, emissivity: None }), ..FieldEffects::default() };
    assert_eq!(sensor(3.0, nothing).truth(), sensor(3.0, FieldEffects::default()).truth());
}

#[test]
fn drifts_change_what_they_name_and_nothing_else() {
    let plain = sensor(3.0, FieldEffects::default());
    // 0.1 % of a voltage; the 1.5 mW of the low level follow with 0.1 %, some tens of µK.
    let resistance = sensor(3.0, drift("sector1", DriftQuantity::Resistance, 1e-3));
    let ratio = |i: usize| f64::from(resistance.codes()[i]) / f64::from(plain.codes()[i]);
    assert!((ratio(0) - 1.001).abs() < 2e-5 && (ratio(1) - 1.0).abs() < 2e-5, "{} {}", ratio(0), ratio(1));

    let gain = sensor(3.0, drift("sector2", DriftQuantity::Gain, -0.05));
    for (i, (with, without)) in gain.body.conductance_w_k().iter().zip(plain.body.conductance_w_k()).enumerate() {
        let expected = if i == 1 { 0.95 } else { 1.0 };
        assert!((with / without - expected).abs() < 1e-12, "sector {i}");
    }

    // Half the contact doubles how far a chip stands above its silver; being 0.8 mK warmer, it
    // takes 2.5e-6 more power.
    let contact = sensor(3.0, drift("sector3", DriftQuantity::Contact, -0.5));
    let above = |of: &Sensor| of.body.element_temperature_c(2) - of.body.surface_temperature_c(2);
    assert!((above(&contact) / above(&plain) - 2.0).abs() < 1e-5, "{}", above(&contact) / above(&plain));
}

#[test]
fn before_its_start_a_drift_is_not_there_to_the_bit() {
    let mut effects = drift("sector1", DriftQuantity::Gain, -0.05);
    effects.drifts[0].start_s = 2.0;
    effects.surface_heat.push(SurfaceHeat { start_s: 2.0, ..heat("sector1", 1e-3) });
    let [mut plain, mut later] = [FieldEffects::default(), effects].map(|effects| sensor(3.0, effects));
    for tick in 0..300 {
        plain.advance(pattern(tick));
        later.advance(pattern(tick));
        let same = plain.truth().element_temperature_c == later.truth().element_temperature_c;
        assert_eq!(same, tick < 200, "tick {tick}");
    }
}

#[test]
fn a_warm_sphere_in_quiescent_air_is_cooled_from_below() {
    let still = |field| {
        let mut sensor =
            Sensor::new(&SensorConfig { species: Species::Air, pressure_pa: 101_325.0, ..with(0.0, field) }).unwrap();
        sensor.body.settle(|i, _| if i < SECTORS { 0.02 } else { 0.0 });
        let mean_c = (0..SECTORS).map(|i| sensor.body.surface_temperature_c(i)).sum::<f64>() / 4.0;
        (sensor.body.conductance_w_k().to_vec(), mean_c - sensor.gas_temperature_c())
    };
    let (none, _) = still(FieldEffects::default());
    let (rising, overheat_k) = still(FieldEffects { buoyancy: Some(BUOYANCY), ..FieldEffects::default() });
    // Sectors 2 and 3 look down, where the gas arrives.
    assert!(rising[1] > rising[0] && rising[2] > rising[3] && rising[0] > none[0], "{rising:?}");
    // Free convection of Churchill, to the 10 % of correlations; Nu is 2 without it.
    let gas = anemometry::gas::IdealGas::new(Species::Air, 101_325.0, 220.0).unwrap();
    let viscosity_m2_s = gas.viscosity_pa_s / gas.density_kg_m3;
    let rayleigh = 9.81 / 220.0 * overheat_k * 1e-6 * gas.prandtl() / viscosity_m2_s.powi(2);
    let expected = 2.0
        + 0.589 * libm::pow(rayleigh, 0.25) / libm::pow(1.0 + libm::pow(0.469 / gas.prandtl(), 9.0 / 16.0), 4.0 / 9.0);
    let nusselt = 2.0 * rising.iter().sum::<f64>() / none.iter().sum::<f64>();
    assert!((nusselt / expected - 1.0).abs() < 0.1, "{nusselt} for {expected}");
}

#[test]
fn a_stem_in_the_wind_cools_the_cores() {
    let plain = sensor(4.0, FieldEffects::default()).truth();
    let cooled = sensor(4.0, FieldEffects { stem: Some(STEM), ..FieldEffects::default() });
    let truth = cooled.truth();
    // 0.2 + 0.5 √4 mW/K. The cores are warmer than its end by what they send there through 19 mW/K.
    let core_c = 0.5 * (truth.element_temperature_c[4] + truth.element_temperature_c[5]);
    let to_stem_w = truth.flows.stem_w + truth.flows.support_w;
    let end_c = core_c - to_stem_w / (2.0 * 8.0 * 1.2e-3);
    let expected = 1.2e-3 * (end_c - truth.gas_temperature_c);
    assert!((truth.flows.stem_w - expected).abs() < 1e-9, "{} for {expected}", truth.flows.stem_w);
    assert!(truth.element_temperature_c[4] < plain.element_temperature_c[4] - 1.0);
}

#[test]
fn a_wake_is_a_slower_wind_for_the_sphere() {
    let wake = StemWake { angle_deg: 30.0, factor: 0.5, deflection_deg: 0.0 };
    let stem = Stem { conductance_w_k: 0.0, conductance_w_k_per_root_m_s: 0.0, wake: Some(wake), ..STEM };
    let conductances = |speed_m_s: f64, elevation_deg: f64, stem| {
        let mut config = with(speed_m_s, FieldEffects { stem, ..FieldEffects::default() });
        config.wind[0].elevation_deg = elevation_deg;
        Sensor::new(&config).unwrap().body.conductance_w_k().to_vec()
    };
    let [behind, slower] = [(4.0, Some(stem)), (2.0, None)].map(|(speed, stem)| conductances(speed, 90.0, stem));
    for (behind, slower) in behind.iter().zip(&slower) {
        // A direction along z has a cosine of 6e-17 across.
        assert!((behind / slower - 1.0).abs() < 1e-9, "{behind} {slower}");
    }
    assert_eq!(conductances(4.0, -20.0, Some(stem)), conductances(4.0, -20.0, None));
}

#[test]
fn what_cannot_be_is_refused_by_its_key() {
    let refused = |field: FieldEffects| Sensor::new(&with(1.0, field)).unwrap_err().to_string();
    let default = FieldEffects::default;
    let sentence = refused(FieldEffects { surface_heat: vec![heat("sector9", 1e-3)], ..default() });
    assert!(
        sentence.starts_with("`surface_heat[0].surface` is `sector9`, which is no surface of the head; "),
        "{sentence}"
    );
    let sentence = refused(FieldEffects { sun: Some(Sun { absorptivity: 1.5, ..SUN }), ..default() });
    assert_eq!(sentence, "`sun.absorptivity` is 1.5: it must be 0 to 1");
    let sentence =
        refused(FieldEffects { sky: Some(Sky { temperature_c: Some(-300.0), emissivity: None }), ..default() });
    assert!(sentence.starts_with("`sky.temperature_c` is -300"), "{sentence}");
    let sentence = refused(FieldEffects { buoyancy: Some(Buoyancy { up: [0.0; 3], ..BUOYANCY }), ..default() });
    assert!(sentence.starts_with("`buoyancy.up` is 0: it must be a vector"), "{sentence}");
    assert!(
        refused(drift("core3", DriftQuantity::Gain, 0.1)).starts_with("`drifts[0].element` is `core3`, which is no")
    );
    let sentence = refused(drift("core1", DriftQuantity::Gain, 0.1));
    assert_eq!(sentence, "`drifts[0].element` is `core1`, which heats no surface: only its `resistance` can drift");
    assert!(
        refused(drift("sector1", DriftQuantity::Gain, -1.0)).starts_with("`drifts[0].change` is -1: it must be above")
    );
    let sentence = refused(drift("sector1", DriftQuantity::Emissivity, 40.0));
    assert!(sentence.starts_with("`drifts[0].change` is 40: it must be so small that the emissivity"), "{sentence}");

    // A head without a sphere has no sun, but can drift.
    let rems = of_head("rems");
    let of_rems = |field| Sensor::new(&SensorConfig { field, ..rems.clone() }).err().map(|error| error.to_string());
    let sentence = of_rems(FieldEffects { sun: Some(SUN), ..default() }).unwrap();
    assert_eq!(sentence, "`sun` is simulated for spheres only, and this head has none: leave it out");
    assert_eq!(of_rems(drift("card1-die1", DriftQuantity::Resistance, 1e-3)), None);
}

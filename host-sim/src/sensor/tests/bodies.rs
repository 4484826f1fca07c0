//! Bodies of files that the project does not have: what a user's `[body]` comes to.

use super::built_in;
use crate::sensor::body::ThermalBody;
use crate::sensor::{Construction, Sensor, SensorConfig, WindEntry};
use anemometry::gas::{IdealGas, Species, ZERO_CELSIUS_K};
use anemometry::head::Head;
use recording::toml_file::TomlSource;

const GAS_C: f64 = 20.0;

fn air() -> IdealGas {
    IdealGas::new(Species::Air, 101_325.0, GAS_C + ZERO_CELSIUS_K).unwrap()
}

/// A head of elements with these names and normals, and a body.
fn head(elements: &[(&str, Option<[f64; 3]>)], body: &str) -> Head {
    let mut text = "name = \"h\"\n[adc]\nfull_scale_v = 4.0\nbits = 24\n[guard]\nmissing_limit_ticks = 1\n\
                    unreachable_limit_s = 10.0\n[kinds.e]\nplatinum = { characteristic = \"iec60751\", \
                    resistance_0c_ohm = 100.0 }\ncurrent_low_a = 0.001\ncurrent_high_a = 0.02\n\
                    resistance_min_ohm = 50.0\nresistance_max_ohm = 300.0\ntemperature_max_c = 200.0\n"
        .to_owned();
    for (name, normal) in elements {
        let normal = normal.map(|normal| format!("normal = {normal:?}\n")).unwrap_or_default();
        text += &format!("[[elements]]\nname = \"{name}\"\nkind = \"e\"\n{normal}");
    }
    Head::from_source(TomlSource { path: "h.toml".into(), text: text + body }).unwrap_or_else(|e| panic!("{e}"))
}

fn body(head: &Head, support_c: f64) -> ThermalBody {
    Construction::of(head).unwrap().body(&air(), support_c + ZERO_CELSIUS_K, 0).unwrap()
}

/// Steady rises of all elements above the gas, with the same power in the first.
fn rises_k(body: &mut ThermalBody, wind_m_s: [f64; 3], power_w: f64) -> Vec<f64> {
    body.set_wind(wind_m_s);
    body.settle(|i, _| if i == 0 { power_w } else { 0.0 });
    (0..body.elements()).map(|i| body.element_temperature_c(i) - GAS_C).collect()
}

#[test]
fn contacts_links_and_rods_are_the_resistances_that_they_are_by_hand() {
    // 10 mW through a contact of 1 mm² · 5000 W/(m²·K), a link of 2 mW/K and a rod of 1 mW/K: 2 + 5
    // + 10 K above the support. The gas takes nothing: King's a and b are next to nothing.
    let head = head(
        &[("film", None), ("block", None)],
        "[body]\nnodes = [ { name = \"film\", capacity_j_k = 1e-3 }, { name = \"block\", capacity_j_k = 0.1 },\n\
         { name = \"foot\", capacity_j_k = 0.1 } ]\nlinks = [\n\
         { from = \"film\", to = \"block\", area_m2 = 1e-6, contact_w_m2_k = 5000.0 },\n\
         { from = \"block\", to = \"foot\", conductance_w_k = 2e-3 },\n\
         { rod = \"stem\", from = \"foot\", to = \"support\", conductance_w_k = 1e-3, capacity_j_k = 0.3, cells = 5 } ]\n\
         [[body.convection]]\ncorrelation = { kind = \"king\", a_w_k = 1e-11, b_w_k = 1e-11, exponent = 0.5 }\n\
         surfaces = [ { name = \"film\" } ]\n",
    );
    let mut body = body(&head, GAS_C);
    let rises = rises_k(&mut body, [3.0, 0.0, 0.0], 0.01);
    // Half a cell at either end, so the rod is exact in the steady state.
    assert!((rises[0] - 17.0).abs() < 1e-5 && (rises[1] - 15.0).abs() < 1e-5, "{rises:?}");
    assert!((body.flows().support_w - 0.01).abs() < 1e-8);
}

#[test]
fn a_gap_of_gas_conducts_more_the_warmer_it_is() {
    let text = "[body]\nnodes = [ { name = \"a\", capacity_j_k = 0.1 }, { name = \"b\", capacity_j_k = 0.1 } ]\n\
                links = [ { from = \"a\", to = \"b\", area_m2 = 1e-4, gap_m = 1e-3 },\n\
                { from = \"b\", to = \"support\", conductance_w_k = 1.0 } ]\n";
    let head = head(&[("a", None), ("b", None)], text);
    let resistance = |power_w: f64, support_c: f64| {
        let mut body = body(&head, support_c);
        let rises = rises_k(&mut body, [0.0; 3], power_w);
        (rises[0] - rises[1]) / power_w
    };
    // k of air at the middle of the gap over 10 m⁻¹ of width over area.
    for (power_w, support_c) in [(1e-3, 20.0), (1e-3, 80.0), (0.1, 20.0)] {
        let found = resistance(power_w, support_c);
        let middle_c = support_c + power_w + 0.5 * found * power_w;
        let expected = 10.0 / air().at(middle_c + ZERO_CELSIUS_K).conductivity_w_m_k;
        assert!((found / expected - 1.0).abs() < 1e-4, "{power_w} W at {support_c} °C: {found} for {expected}");
    }
    assert!(resistance(1e-3, 80.0) < 0.9 * resistance(1e-3, 20.0));
}

#[test]
fn a_wires_steady_state_is_one_at_its_own_temperature() {
    let head = head(
        &[("wire", None)],
        "[body]\nnodes = [ { name = \"wire\", capacity_j_k = 1e-6 } ]\n[[body.convection]]\n\
         correlation = { kind = \"wire\", diameter_m = 10e-6, length_m = 2e-3, law = \"collis-williams\" }\n\
         surfaces = [ { name = \"wire\" } ]\n",
    );
    let mut body = body(&head, GAS_C);
    let rise = rises_k(&mut body, [5.0, 0.0, 0.0], 0.01)[0];
    let conductance = body.conductance_w_k()[0];
    assert!((rise * conductance / 0.01 - 1.0).abs() < 1e-6, "{rise} K, {conductance} W/K");
    // Stepping in time stays there.
    for _ in 0..200 {
        body.set_wind([5.0, 0.0, 0.0]);
        body.advance(1e-3, |_, _| 0.01);
    }
    assert!((body.element_temperature_c(0) - GAS_C - rise).abs() < 1e-3);
}

#[test]
fn heat_balances_in_a_body_of_everything_that_a_file_can_say() {
    let head = head(
        &[("film1", Some([1.0, 0.0, 0.0])), ("film2", Some([-1.0, 1.0, 0.0])), ("film3", Some([-1.0, -1.0, 0.0]))],
        "[body]\nnodes = [ { name = \"film[1-3]\", capacity_j_k = 0.02, capacity_slope_per_k = 1e-3 },\n\
         { name = \"tube\", capacity_j_k = 0.5 } ]\nlinks = [\n\
         { from = \"film[1-3]\", to = \"tube\", area_m2 = 1e-4, gap_m = 2e-4 }, { among = \"film[1-3]\", conductance_w_k = 1e-3 },\n\
         { rod = \"stem\", from = \"tube\", to = \"support\", conductance_w_k = 5e-3, capacity_j_k = 0.3, cells = 4 } ]\n\
         [[body.convection]]\ncorrelation = { kind = \"cylinder\", diameter_m = 6e-3, length_m = 0.02, gravity_m_s2 = 9.81 }\n\
         surfaces = [ { name = \"film[1-3]\", emissivity = 0.9 } ]\n",
    );
    let mut body = body(&head, 30.0);
    let weather =
        |body: &mut ThermalBody, phase: f64| body.set_wind([4.0 * libm::cos(phase), 2.0 * libm::sin(phase), 0.5]);
    let power_w = |i, high| if high { 0.2 } else { 0.01 * i as f64 };
    let imbalance = crate::sensor::body::testing::imbalance(&mut body, (20_000, 0.01), weather, power_w);
    // Not to rounding: the capacities move within a step, by its fourth order.
    assert!(imbalance.abs() < 1e-7, "{imbalance}");
}

#[test]
fn a_part_too_fast_for_the_sample_period_is_refused_before_it_takes_for_ever() {
    let construction = built_in("sphere-b", &[("capacity_j_k = 4.7e-3", "capacity_j_k = 1e-9")]);
    let refused = Sensor::new(&SensorConfig { construction, ..SensorConfig::default() }).unwrap_err().to_string();
    assert!(refused.contains("its fastest part has a time constant of 5.0e-10 s"), "{refused}");
}

#[test]
fn a_seed_draws_a_specimen_and_no_tolerances_draw_none() {
    let end = "gas = { species = \"co2\", pressure_pa = 1000.0, temperature_c = -53.15 }";
    let with = format!("{end}\ntolerances = {{ capacity_percent = 5.0, area_percent = 1.0, normal_deg = 0.7 }}");
    let run = |construction: &Construction, seed: u64| {
        let wind = vec![WindEntry { label: "w".into(), speed_m_s: 3.0, ..WindEntry::default() }];
        let config = SensorConfig { construction: construction.clone(), seed, wind, ..SensorConfig::default() };
        let mut sensor = Sensor::new(&config).unwrap();
        (0..50).for_each(|_| sensor.advance(0x3F));
        sensor.truth().element_temperature_c
    };
    let (plain, drawn) = (built_in("sphere-b", &[]), built_in("sphere-b", &[(end, &with)]));
    assert_eq!(run(&plain, 1), run(&plain, 2));
    assert_eq!(run(&drawn, 1), run(&drawn, 1));
    assert_ne!(run(&drawn, 1), run(&drawn, 2));
    let differences: Vec<f64> = run(&plain, 1).iter().zip(run(&drawn, 1)).map(|(a, b)| (a - b).abs()).collect();
    // 5 % of a rise of some kelvins.
    assert!(differences.iter().all(|d| *d < 1.0) && differences.iter().any(|d| *d > 1e-3), "{differences:?}");
}

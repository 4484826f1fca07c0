use super::super::sliding_surface::SlidingSurface;
use super::super::zeros::decays_of;
use super::*;
use crate::model::testing;

const RATES: [f64; 4] = [0.05, 0.4, 3.0, 25.0];
const R: [f64; 4] = [300.0, 80.0, 25.0, 4.0];

#[test]
fn one_held_element_moves_as_its_zeros_say() {
    let system = System::new(&testing::model(&RATES, &R), None).unwrap();
    let surface = SlidingSurface::new(&RATES, &R).unwrap();
    let motion = system.motion(0, 1, 0.1).unwrap();
    let mut z = DVector::from_column_slice(&[3.0, 2.0, 1.0, 0.5]);
    let steady = 6.5 / surface.steady_gain_k_per_w;
    let decays = decays_of(&surface, z.as_slice());
    let mut scratch = z.clone();
    for n in 0..500 {
        let mut power = [0.0];
        motion.equivalent_w(&z, &mut power);
        assert!((power[0] - surface.equivalent_control_w(z.as_slice())).abs() < 1e-14);
        let exact = steady + decays.at(0.1 * f64::from(n));
        assert!((power[0] / exact - 1.0).abs() < 1e-11, "{n}: {} {exact}", power[0]);
        motion.advance(&mut z, &[0.0], &mut scratch);
    }
    assert!((system.temperature_c(&z, 0) - 26.5).abs() < 1e-12);
}

#[test]
fn a_held_element_gives_a_wind_what_it_takes() {
    let mut model = testing::model(&RATES, &R);
    testing::add_wind(&mut model, "gust", 0.002);
    let system = System::new(&model, Some(18.0)).unwrap();
    let gust = 1;
    let z = DVector::from_column_slice(&[3.0, 2.0, 1.0, 0.5]);
    let mut power = [[0.0], [0.0]];
    for (class, power) in power.iter_mut().enumerate() {
        system.motion(class, 1, 0.1).unwrap().equivalent_w(&z, power);
    }
    // 26.5 °C in a gas of 18 °C
    assert!((power[gust][0] - power[0][0] - 0.002 * 8.5).abs() < 1e-14);
    // In steady state open loop and held agree: T is where it is held.
    let steady = system.steady_state(gust, &[0.03]).unwrap();
    let mut held = [0.0];
    system.motion(gust, 1, 0.1).unwrap().equivalent_w(&steady, &mut held);
    assert!((held[0] - 0.03).abs() < 1e-15);
}

/// Two elements that warm each other: own pairs of two poles, cross pairs of one.
fn neighbours() -> Model {
    let mut model = testing::model(&[0.05, 2.0], &[300.0, 60.0]);
    let mut output = model.outputs[0].clone();
    output.name = "temperature_c_b".to_owned();
    output.offset_c = 18.0;
    model.outputs.push(output);
    model.inputs.push("power_w_b".to_owned());
    let pair = |input: &str, output: &str, mesh: &[f64], r: &[f64]| {
        let mut pair = testing::model(mesh, r).pairs.remove(0);
        pair.input = format!("power_w_{input}");
        pair.output = format!("temperature_c_{output}");
        pair
    };
    model.pairs = vec![
        pair("a", "a", &[0.05, 2.0], &[300.0, 60.0]),
        pair("b", "a", &[0.05], &[80.0]),
        pair("a", "b", &[0.05], &[70.0]),
        pair("b", "b", &[0.05, 1.0], &[250.0, 40.0]),
    ];
    model
}

/// Lets time pass and gives the powers at its end.
fn pass(system: &System, mask: usize, z: &mut DVector<f64>, mut power: [f64; 2], steps: usize) -> [f64; 2] {
    let motion = system.motion(0, mask, 0.1).unwrap();
    let mut scratch = z.clone();
    for _ in 0..steps {
        motion.equivalent_w(z, &mut power);
        motion.advance(z, &power, &mut scratch);
    }
    motion.equivalent_w(z, &mut power);
    power
}

#[test]
fn two_held_elements_stay_where_they_are_and_end_with_the_powers_that_solve_their_steady_state() {
    let system = System::new(&neighbours(), None).unwrap();
    let mut z = DVector::from_column_slice(&[8.0, 1.0, 1.0, 0.5, 6.0, 0.5]);
    let power = pass(&system, 0b11, &mut z, [f64::NAN; 2], 20_000);
    assert!((system.temperature_c(&z, 0) - 30.0).abs() < 1e-10 && (system.temperature_c(&z, 1) - 25.0).abs() < 1e-10);
    // 360 a + 80 b = 10, 70 a + 290 b = 7
    let determinant = 360.0 * 290.0 - 80.0 * 70.0;
    let exact = [(10.0 * 290.0 - 80.0 * 7.0) / determinant, (360.0 * 7.0 - 70.0 * 10.0) / determinant];
    assert!(power.iter().zip(exact).all(|(power, exact)| (power / exact - 1.0).abs() < 1e-10), "{power:?} {exact:?}");
}

#[test]
fn an_element_that_is_held_takes_less_beside_one_that_is_heated() {
    let system = System::new(&neighbours(), None).unwrap();
    let mut z = DVector::from_column_slice(&[9.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let power = pass(&system, 0b01, &mut z, [0.0, 0.02], 20_000);
    assert!((system.temperature_c(&z, 0) - 30.0).abs() < 1e-10);
    let exact_w = (10.0 - 80.0 * 0.02) / 360.0;
    assert!((power[0] / exact_w - 1.0).abs() < 1e-10 && power[1] == 0.02, "{power:?} {exact_w}");
    assert!((system.temperature_c(&z, 1) - (18.0 + 70.0 * exact_w + 290.0 * 0.02)).abs() < 1e-9);
}

#[test]
fn an_input_without_an_output_is_refused_and_never_regulated_by_that_of_another() {
    let mut model = neighbours();
    let refused = |model: &Model| System::new(model, None).err().unwrap().to_string();
    model.outputs.remove(0);
    let sentence = refused(&model);
    let input = &model.inputs[0];
    assert!(sentence.starts_with(&format!("the model has no output of the element that input `{input}` heats")));
    assert!(sentence.ends_with("identify it again with that temperature among its --output"), "{sentence}");
    // Names that are no elements' go by their order.
    model.outputs[0].name = "y".to_owned();
    assert!(refused(&model).contains(&format!("input `{}` heats", model.inputs[1])));
}

#[test]
fn a_gas_that_is_followed_moves_the_temperature_without_heating() {
    let mut model = testing::model(&RATES, &R);
    testing::add_wind(&mut model, "gust", 0.002);
    testing::follow_gas(&mut model, 20.0);
    let system = System::new(&model, Some(23.0)).unwrap();
    assert_eq!(system.temperature_c(&DVector::zeros(system.order()), 0), 23.0);
}

#[test]
fn the_end_of_a_record_decays_as_it_says_and_is_refused_where_there_is_none() {
    let mut model = testing::model(&RATES, &R);
    let mut system = System::new(&model, None).unwrap();
    assert!(system.end(&model).unwrap_err().to_string().contains("does not hold the state at the end of its record"));
    // The second rate is no pair's, the third stands still.
    let decays = vec![vec![(0.05, 3.0), (7.0, 1.0), (0.0, 0.5)]];
    model.end =
        Some(crate::model::RecordEnd { decays, pending: vec![Vec::new()], ..crate::model::RecordEnd::default() });
    let mut z = system.end(&model).unwrap();
    assert_eq!((system.order(), system.temperature_c(&z, 0)), (6, 24.5));
    let mut scratch = z.clone();
    system.motion(0, 0, 0.3).unwrap().advance(&mut z, &[0.0], &mut scratch);
    let exact = 20.0 + 3.0 * libm::exp(-0.05_f64 * 0.3) + libm::exp(-7.0_f64 * 0.3) + 0.5;
    assert!((system.temperature_c(&z, 0) - exact).abs() < 1e-12);
    // Held, it takes what those states leave to do.
    let mut power = [0.0];
    system.motion(0, 1, 0.1).unwrap().equivalent_w(&z, &mut power);
    assert!(power[0].is_finite() && power[0] > 0.0);
}

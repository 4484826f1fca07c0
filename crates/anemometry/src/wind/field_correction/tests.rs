//! Effect on slow errors of a stream that is not the wind: that of a head whose stem slows the wind
//! from below, and whose warm gas rises fast.

use std::path::Path;

use dr_core::wind::form::MOST_SURFACES;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{MeasuredConductance, WindEstimate, WindState, WindTick};
use nalgebra::{SMatrix, SVector, Vector3};
use recording::toml_file::TomlSource;

use crate::head::calibration::commands::WindOutput;
use crate::head::file::Head;
use crate::wind::field_correction::correction::by_errors;
use crate::wind::field_correction::halves::OverheatHalf;
use crate::wind::field_correction::halves::OverheatHalves;
use crate::wind::field_correction::halves::SurfaceCovariance;
use crate::wind::field_correction::halves::overheat_equations;
use crate::wind::field_correction::smoother::ERRORS;
use crate::wind::off_line::OffLineAnemometer;

const GAS_C: f32 = -53.0;
const OVERHEAT_K: f32 = 30.0;
const CONVECTION: &str = "
[calibration.convection]
properties = \"gas\"
nusselt_at_rest = 3.0
slowest_reynolds = 1.0
gas_c = [-53.0, -53.0]
speed_share_per_k = 0.0
direction_deg_per_k = 0.0
rise = { gravity_m_s2 = 9.81, up = [0.0, 0.0, 1.0], at_rest = 2.0, decay = 0.4 }

[calibration.convection.stem]
axis = [0.0, 0.0, -1.0]
unknown_deg = 0.0
factor = [0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99]
deflection = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
";

/// The sphere with such a stream.
fn in_a_stream() -> Head {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
    let mut source = TomlSource::read(&path).unwrap();
    source.text += CONVECTION;
    Head::from_source(source).unwrap()
}

fn anemometer(head: &Head) -> OffLineAnemometer<'_> {
    let output = WindOutput { bandwidth_hz: 1.0, interval_s: 0.1, fixed: false };
    let mut made = OffLineAnemometer::new(head, head.calibration.as_ref().unwrap(), &output, 1e-2).unwrap();
    made.gas(700.0, None).unwrap();
    made
}

fn conductances_w_k(of: &OffLineAnemometer<'_>, overheat_k: f32, wind_m_s: [f32; 3]) -> [f32; MOST_SURFACES] {
    let of = of.anemometer();
    let (free, rise_speed_m_s) = of.free_stream(GAS_C, overheat_k);
    let gas = of.gas_at(GAS_C, overheat_k).unwrap();
    of.vector().unwrap().conductances(&gas, free.met(wind_m_s, rise_speed_m_s)).map(|of| of.conductance_w_k)
}

#[test]
fn uncertain_heat_widens_by_what_it_does_to_the_wind_before_the_stem() {
    let head = in_a_stream();
    let off_line = anemometer(&head);
    let of = off_line.anemometer();
    let wind_m_s = [0.4, 0.2, 2.0];
    let variance_w2_k2 = 1e-12;
    let conductance_w_k = conductances_w_k(&off_line, OVERHEAT_K, wind_m_s);
    // A tenth of a mW on the first surface, ten times.
    let gain = of.gains().next().unwrap();
    let (free, rise_speed_m_s) = of.free_stream(GAS_C, OVERHEAT_K);
    let wind = |offset_w: f32| {
        let mut measured =
            conductance_w_k.map(|conductance_w_k| MeasuredConductance { conductance_w_k, variance_w2_k2 });
        measured[0].conductance_w_k += gain * offset_w / OVERHEAT_K;
        let measured: [_; SECTORS] = core::array::from_fn(|i| Some(measured[i]));
        let gas = of.gas_at(GAS_C, OVERHEAT_K).unwrap();
        let met = of.vector().unwrap().step(&mut WindState::default(), &gas, &measured);
        Vector3::from(free.wind(met.wind_m_s, rise_speed_m_s).map(f64::from))
    };
    let moved = 5.0 * (wind(1e-4) - wind(-1e-4));
    let estimate = WindTick {
        surfaces: 4,
        conductance_w_k,
        raw_w_k: [0.0; MOST_SURFACES],
        variance_w2_k2: [variance_w2_k2; SECTORS],
        overheat_k: [OVERHEAT_K; SECTORS],
        gas_c: GAS_C,
        wind: WindEstimate { wind_m_s, ..WindEstimate::none() },
        quality_flags: dr_core::wind::QualityFlags::default(),
    };
    let mut errors = SMatrix::<f64, ERRORS, ERRORS>::zeros();
    errors[(0, 0)] = 1.0;
    let added = by_errors(&errors, of, &estimate).unwrap();
    let off = (added - moved * moved.transpose()).norm() / added.norm();
    // Derivatives by steps of 1 %.
    assert!(off < 0.03, "{off}: {added} {moved}");
}

#[test]
fn gas_that_rises_faster_at_a_higher_overheat_is_no_heat() {
    let head = in_a_stream();
    let off_line = anemometer(&head);
    let half = |n: usize| {
        let overheat_k = if n.is_multiple_of(2) { 30.0 } else { 20.0 };
        let conductance_w_k = conductances_w_k(&off_line, overheat_k, [0.6, 0.3, 0.1]);
        OverheatHalf {
            is_high: n.is_multiple_of(2),
            slot: n,
            conductance_w_k: SVector::from_fn(|i, _| conductance_w_k[i].into()),
            per_overheat: SVector::repeat(1.0 / f64::from(overheat_k)),
            gas_c: GAS_C.into(),
            batches: 1.0,
        }
    };
    let halves = OverheatHalves {
        overheat_k: [30.0, 20.0],
        halves: (0..6).map(half).collect(),
        batch_w2_k2: SurfaceCovariance::identity(),
    };
    let equations = overheat_equations(&halves, off_line.anemometer(), |_| Default::default());
    assert_eq!(equations.len(), 2);
    for of in equations {
        let heat_mw = of.per_mw.try_inverse().unwrap() * of.value;
        // The inverse of an f32.
        assert!(heat_mw.amax() < 0.01, "{heat_mw}");
    }
}

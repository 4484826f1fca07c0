use super::*;
use dr_core::control::{
    Cause, Drive, ElementConfig, GuardConfig, Limits, PulseResponse, SelfTestFaults, SelfTestFinding,
};
use dr_core::model::{
    AlarmConfig, FasterGainsConfig, GainsConfig, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig, SelfHeatingConfig,
};
use dr_core::sensor::{Channel, Platinum};
use dr_core::wind::HeadForm;
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::{
    CalibrationUncertainty, CardConfig, ConvectionConfig, GasLawConfig, HeadSurface, RiseConfig, StemConfig,
    SurfaceConfig, WindCommand, WindOutputConfig,
};

extern crate std;
use std::vec::Vec;

const NAME: &str = "a name that has 32 characters ..";

const GAINS: GainsConfig =
    GainsConfig { correction_w_per_k: [1.0; 8], convection_w_per_k: 2.0, weights: [3.0; 2], variance_w2: 4.0 };

/// One command of each kind, all numbers plain.
fn one_of_each() -> Vec<Command> {
    let channel = Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), 5e-7, 0.003, 0.016).unwrap();
    let limits = Limits {
        resistance_min_ohm: 100.0,
        resistance_max_ohm: 300.0,
        temperature_max_c: 70.0,
        code_max: 8_388_607,
        energy: None,
    };
    let surface =
        SurfaceConfig { axis: [1.0; 3], corner: [2.0; 3], area_m2: 3.0, means: [4.0; 5], threefold: [5.0; 3] };
    let own = NetworkSelfHeatingConfig {
        mesh_rad_s: [1.0; 8],
        r_k_per_w: [2.0; 8],
        surface: [3.0; 8],
        rest_c: 4.0,
        gains: GAINS,
        alarm: Some(AlarmConfig { smoothing_s: 5.0, threshold_k: 6.0 }),
    };
    let cross =
        NetworkCrossHeatingConfig { from: 1, to: 2, mesh_rad_s: [1.0; 4], r_k_per_w: [2.0; 4], surface: [3.0; 4] };
    let card = CardConfig {
        mean: [1.0; 12],
        difference: [2.0; 12],
        along: [3.0; 8],
        around: [4.0; 8],
        seen: [5.0; 8],
        mean_share: 6.0,
        difference_share: 7.0,
    };
    let gas_law = GasLawConfig {
        gas_constant_j_kg_k: 1.0,
        least_c: 2.0,
        most_c: 3.0,
        viscosity_pa_s: [4.0; 7],
        conductivity_w_m_k: [5.0; 7],
    };
    let answer = WindOutputConfig {
        surfaces: 4,
        diameter_m: 1.0,
        reynolds: Some([2.0; 2]),
        direction_error_max_rad: 3.0,
        output_interval_ticks: 4,
        reference: Some(5),
        smoothing_s: [6.0; 2],
        reference_gas_c: 7.0,
    };
    let part = HeadSurface { element: 3, surface, gain: 1.0, windless_w_k: 2.0 };
    let model = SelfHeatingConfig { mesh_rad_s: [1.0; 8], r_k_per_w: [2.0; 8], reference_c: 3.0 };
    [
        Command::SamplePeriod { sample_period_s: 0.01 },
        Command::Guard(GuardConfig { missing_limit_ticks: 5, unreachable_limit_ticks: 3000, stuck_limit_ticks: 0 }),
        Command::Observe { on: true },
        Command::HostTimeout { timeout_s: 0.0 },
        Command::Fingerprint { resistance_ohm: [1000.0; 16] },
        Command::Element { element: 1, config: ElementConfig { channel, limits } },
        Command::Model { element: 2, model },
        Command::Drive { element: 3, drive: Drive::Passive },
        Command::Wind(WindCommand::Correction(
            [SurfaceCorrection { offset_w: 0.5, gain: 0.25, offset_u_w: 0.125, gain_u: 0.0625 }; 4],
        )),
        Command::Wind(WindCommand::Convection(ConvectionConfig {
            film_share: 0.5,
            nusselt_at_rest: 2.0,
            slowest_reynolds: 8.0,
            gas_c: [-64.0, -32.0],
            speed_share_per_k: 0.25,
            direction_rad_per_k: 0.5,
            rise: Some(RiseConfig { gravity_m_s2: 4.0, up: [1.0; 3], at_rest: 0.5, decay: 1.0 }),
            stem: Some(StemConfig { axis: [2.0; 3], unknown_chord: 0.25, factor: [0.75; 12], deflection: [0.125; 12] }),
        })),
        Command::Wind(WindCommand::Uncertainty(CalibrationUncertainty {
            conductance_share: [0.5; 4],
            speed_share: [0.25; 4],
            direction_rad: [0.125; 4],
            chi_square_most: 8.0,
        })),
        Command::Wind(WindCommand::Form(HeadForm::Cylinder)),
        Command::Wind(WindCommand::SelfHeating { element: 4, config: own }),
        Command::Wind(WindCommand::FasterGains(FasterGainsConfig { element: 1, set: 2, until_s: 3.0, gains: GAINS })),
        Command::Wind(WindCommand::CrossHeating(cross)),
        Command::Wind(WindCommand::NusseltPoint { point: 31, amplitudes: [1.0; 6] }),
        Command::Wind(WindCommand::Surface { surface: 3, config: part }),
        Command::Wind(WindCommand::Card(card)),
        Command::Wind(WindCommand::GasLaw(gas_law)),
        Command::Wind(WindCommand::Output(answer)),
        Command::Wind(WindCommand::Gas { pressure_pa: 700.0, temperature_c: Some(-53.0) }),
    ]
    .into()
}

fn preface() -> Preface {
    Preface { name: Name::try_from(NAME).unwrap(), telemetry_every: 10 }
}

/// The longest result of a self-test.
fn test() -> TestRecord {
    let response = PulseResponse { rise_k: 1.0, expected_k: Some(2.0), ratio: Some(3.0), gap_k: Some(4.0) };
    let finding = |element| SelfTestFinding {
        element,
        of: 16,
        faults: SelfTestFaults(7),
        offset_v: Some(8.0),
        reference: Some(9.0),
        cause: Some(Cause::Open),
        temperature_c: Some(10.0),
        noise_k: Some(11.0),
        response: Some(response),
    };
    let firmware = Name::try_from(NAME).unwrap();
    TestRecord { unix_s: Some(u32::MAX), firmware, starts: u32::MAX, findings: (0..16).map(finding).collect() }
}

/// Every so manieth of a long row is tried: an interpreter takes a hundred times as long.
const STEP: usize = if cfg!(miri) { 64 } else { 1 };

fn record() -> Vec<u8> {
    let mut record = preface().bytes().unwrap().to_vec();
    one_of_each().iter().for_each(|command| record.extend(command_bytes(command).unwrap()));
    record
}

#[test]
fn each_command_comes_out_as_it_went_in_and_fits_a_piece() {
    let record = record();
    let (read, mut rest) = Preface::take(&record).unwrap();
    assert_eq!(read, preface());
    for command in one_of_each() {
        let (read, after) = take_command(rest).unwrap();
        assert_eq!(read, command);
        let bytes = &rest[..rest.len() - after.len()];
        assert!(bytes.len() <= MOST_PIECE);
        for length in (0..bytes.len()).step_by(STEP) {
            assert_eq!(take_command(&bytes[..length]), Err(Unusable::Damaged), "{command:?} cut");
        }
        rest = after;
    }
    assert!(rest.is_empty());
    for format in (0..=255).filter(|format| *format != FORMAT).step_by(STEP) {
        let mut record = record.clone();
        record[0] = format;
        assert_eq!(Preface::take(&record), Err(Unusable::Format { found: format }));
    }
    assert_eq!(Preface::take(&[]), Err(Unusable::Damaged));
}

/// A record with `Arm` and `Start` would heat at each start of the board.
#[test]
fn a_command_that_sets_nothing_up_is_refused() {
    let others = [Command::Clear, Command::Start, Command::Stop, Command::Acknowledge, Command::Arm { window_s: 9.0 }];
    for command in others {
        assert_eq!(take_command(&command_bytes(&command).unwrap()), Err(Unusable::Damaged), "{command:?}");
    }
}

#[test]
fn the_longest_self_test_fits_its_record() {
    let test = test();
    let bytes = test.bytes().unwrap();
    assert_eq!(TestRecord::read(&bytes), Ok(test));
    for length in (1..bytes.len()).step_by(STEP) {
        assert_eq!(TestRecord::read(&bytes[..length]), Err(Unusable::Damaged));
    }
}

/// A record as a board stores it: its preface, then a command a line.
const OF_FORMAT: &str = include_str!("format3.txt");

/// A board that is updated goes on with its settings. A change of their bytes raises `FORMAT`.
#[test]
fn settings_that_a_board_has_stored_are_still_read() {
    let digits: Vec<u8> = OF_FORMAT.bytes().filter(u8::is_ascii_hexdigit).collect();
    let byte = |digits: &[u8]| u8::from_str_radix(core::str::from_utf8(digits).unwrap(), 16).unwrap();
    let stored: Vec<u8> = digits.chunks(2).map(byte).collect();
    assert_eq!(stored, record(), "the bytes of settings differ: raise FORMAT");
}

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
    SurfaceConfig, WindOutputConfig,
};

extern crate std;
use std::vec::Vec;

const GAINS: GainsConfig =
    GainsConfig { correction_w_per_k: [1.0; 8], convection_w_per_k: 2.0, weights: [3.0; 2], variance_w2: 4.0 };

/// One of each kind, all numbers plain.
fn one_of_each() -> Vec<Setting> {
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
    let commands = [
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
    ];
    let name = Name::try_from("a name that has all 32 characters").unwrap_or_default();
    let own = [Setting::Name(name), Setting::TelemetryEvery(10)];
    own.into_iter().chain(commands.map(Setting::Command)).collect()
}

/// What the board writes by itself.
fn records() -> Vec<Setting> {
    let response = PulseResponse { rise_k: 1.0, expected_k: Some(2.0), ratio: Some(3.0), gap_k: Some(4.0) };
    let finding = SelfTestFinding {
        element: 5,
        of: 6,
        faults: SelfTestFaults(7),
        offset_v: Some(8.0),
        reference: Some(9.0),
        cause: Some(Cause::Open),
        temperature_c: Some(10.0),
        noise_k: Some(11.0),
        response: Some(response),
    };
    let firmware = Name::try_from("anemo").unwrap_or_default();
    let record = |unix_s| Setting::Tested(TestRecord { unix_s, firmware: firmware.clone(), starts: 12, finding });
    [Some(1_800_000_000), None].map(record).into()
}

/// Every so manieth of a long row is tried: an interpreter takes a hundred times as long.
const STEP: usize = if cfg!(miri) { 64 } else { 1 };

#[test]
fn each_comes_out_as_it_went_in_and_nowhere_else() {
    let settings = [one_of_each(), records()].concat();
    let kinds: Vec<SettingKind> = (0..=u8::MAX).filter_map(SettingKind::from_repr).collect();
    assert_eq!(settings.len(), kinds.len());
    let mut before = 0;
    for (setting, kind) in settings.iter().zip(kinds) {
        let key = setting.key().unwrap();
        assert_eq!((key.kind, SettingKey::of_number(key.number())), (kind, Some(key)));
        assert!(key.number() > before, "in the order in which they are told");
        before = key.number();
        let value = setting.value().unwrap();
        assert_eq!(Setting::read(key.number(), &value).as_ref(), Ok(setting));
        for other in settings.iter().filter(|other| *other != setting).step_by(STEP) {
            let other = other.key().unwrap().number();
            assert_eq!(Setting::read(other, &value), Err(Unusable::Misplaced));
        }
        for length in (1..value.len()).step_by(STEP) {
            assert_eq!(Setting::read(key.number(), &value[..length]), Err(Unusable::Damaged), "{kind:?} cut");
        }
        for format in (0..=255).filter(|format| !(1..=FORMAT).contains(format)).step_by(STEP) {
            let mut value = value.clone();
            value[0] = format;
            assert_eq!(Setting::read(key.number(), &value), Err(Unusable::Format { found: format }));
        }
    }
    assert_eq!(Setting::read(0x7700, &[FORMAT, 1, 1]), Err(Unusable::UnknownKey));
    assert_eq!(Setting::Command(Command::Start).key(), None);
}

/// Values as a board keeps them, in each format that there has been: number of the key, format,
/// bytes. Lines are added for new kinds, and never changed.
const OF_FORMATS: [&str; FORMAT as usize] = [include_str!("format1.txt"), include_str!("format2.txt")];

/// A board that is updated goes on with what it has kept. Whoever changes what a value looks like
/// raises `FORMAT`, and converts these in `Setting::read`.
#[test]
fn values_that_an_older_board_has_kept_are_still_read() {
    let settings = [one_of_each(), records()].concat();
    assert!(OF_FORMATS.iter().all(|values| values.lines().count() == settings.len()), "a line of each kind");
    let formats =
        OF_FORMATS.iter().zip(1..).flat_map(|(values, format)| values.lines().map(move |line| (format, line)));
    for ((format, line), setting) in formats.zip(settings.iter().cycle()) {
        let (number, digits) = line.split_once(' ').unwrap();
        let number = KeyNumber::from_str_radix(number, 16).unwrap();
        let byte = |at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
        let value: Vec<u8> = (0..digits.len()).step_by(2).map(byte).collect();
        assert_eq!(value[0], format);
        assert_eq!(Setting::read(number, &value), Ok(setting.clone()), "{number:#06x}");
        if format == FORMAT {
            assert_eq!(setting.value().unwrap().as_slice(), value, "{number:#06x} looks otherwise: raise FORMAT");
        }
    }
}

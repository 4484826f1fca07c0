//! Whatever flips in what the anemometer has been told, the checksum of its piece is broken.

use super::balance::{ELEMENTS, GAS_C, PERIOD_S, config, follow, gas, own, sectors, tick};
use super::*;
use crate::model::{FasterGainsConfig, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig};
use crate::wind::anemometer::head_inverse::HeadInverse;
use std::vec::Vec;

const PIECES: u32 = (ConvectionObserver::<ELEMENTS>::PIECES + 3) as u32;

fn flipped(number: f32) -> f32 {
    f32::from_bits(number.to_bits() ^ 1)
}

/// The same with another element, pair and set of gains.
fn whole() -> Anemometer<ELEMENTS> {
    let mut anemometer = sectors(&config());
    for command in [WindCommand::CrossHeating(cross()), WindCommand::FasterGains(faster())] {
        anemometer.handle(&command, PERIOD_S).unwrap();
    }
    anemometer.handle(&WindCommand::Output(config()), PERIOD_S).unwrap();
    anemometer.handle(&gas(Some(GAS_C)), PERIOD_S).unwrap();
    anemometer
}

fn cross() -> NetworkCrossHeatingConfig {
    NetworkCrossHeatingConfig {
        from: 0,
        to: 1,
        mesh_rad_s: [0.1, 1.0, 10.0, 100.0],
        r_k_per_w: [10.0; 4],
        surface: [1.0; 4],
    }
}

fn faster() -> FasterGainsConfig {
    FasterGainsConfig { element: 0, set: 0, until_s: 0.5, gains: own(0).gains }
}

#[test]
fn what_nobody_has_changed_is_whole_in_every_tick() {
    let mut anemometer = whole();
    assert!(anemometer.is_whole());
    for n in 0..3 * PIECES {
        assert!(anemometer.is_intact_at(n), "{n}");
        follow(&mut anemometer, &tick(n));
    }
    assert!(Anemometer::<ELEMENTS>::default().is_whole());
}

#[test]
fn a_bit_anywhere_is_found_in_one_turn_and_in_one_piece() {
    let anemometer = whole();
    let mut bit_flips: Vec<Anemometer<ELEMENTS>> = Vec::new();
    let mut spoil = |change: &dyn Fn(&mut Anemometer<ELEMENTS>)| {
        let mut other = anemometer.clone();
        change(&mut other);
        assert!(other != anemometer, "nothing has changed");
        bit_flips.push(other);
    };
    // The network's numbers are its own: it is told others, and nobody checksums it.
    let changes: [fn(&mut NetworkSelfHeatingConfig); 7] = [
        |own| own.mesh_rad_s[7] *= 1.01,
        |own| own.r_k_per_w[3] += 1.0,
        |own| own.surface[2] += 0.5,
        |own| own.rest_c = flipped(own.rest_c),
        |own| own.gains.correction_w_per_k[5] += 1.0,
        |own| own.gains.convection_w_per_k = flipped(own.gains.convection_w_per_k),
        |own| own.gains.variance_w2 = flipped(own.gains.variance_w2),
    ];
    for change in changes {
        let mut config = own(1);
        change(&mut config);
        spoil(&|anemometer| anemometer.network.set_self_heating(1, &config, PERIOD_S).unwrap());
    }
    let crosses: [fn(&mut NetworkCrossHeatingConfig); 3] = [
        |cross| cross.mesh_rad_s[3] *= 1.01,
        |cross| cross.r_k_per_w[0] = flipped(cross.r_k_per_w[0]),
        |cross| cross.surface[3] += 0.5,
    ];
    for change in crosses {
        let mut config = cross();
        change(&mut config);
        spoil(&|anemometer| anemometer.network.set_cross_heating(&config, PERIOD_S).unwrap());
    }
    let mut quicker = faster();
    quicker.gains.weights[1] = flipped(quicker.gains.weights[1]);
    spoil(&|anemometer| anemometer.network.set_faster_gains(&quicker, PERIOD_S).unwrap());
    let mut later = faster();
    later.until_s += 0.1;
    spoil(&|anemometer| anemometer.network.set_faster_gains(&later, PERIOD_S).unwrap());

    // Commands that it was sent, and their outcomes.
    let mut amplitudes = nusselt().amplitudes[31];
    amplitudes[5] = flipped(amplitudes[5]);
    spoil(&|anemometer| anemometer.setup.set_point(31, amplitudes).unwrap());
    for bit in [0, 13, 22, 30] {
        let flip = move |number: f32| f32::from_bits(number.to_bits() ^ 1 << bit);
        spoil(&|anemometer| anemometer.pressure_pa = anemometer.pressure_pa.map(flip));
        spoil(&|anemometer| anemometer.given_gas_c = anemometer.given_gas_c.map(flip));
        spoil(&|anemometer| {
            let output = anemometer.output.as_mut().unwrap();
            output.power_share = flip(output.power_share);
        });
        spoil(&|anemometer| {
            let output = anemometer.output.as_mut().unwrap();
            output.config.diameter_m = flip(output.config.diameter_m);
        });
        spoil(&|anemometer| {
            let output = anemometer.output.as_mut().unwrap();
            output.starting_ticks ^= 1 << bit;
        });
    }
    spoil(&|anemometer| anemometer.pressure_pa = None);
    spoil(&|anemometer| anemometer.corrections = Some([SurfaceCorrection::default(); SECTORS]));
    spoil(&|anemometer| {
        let head = HeadInverse::Surfaces(
            WindVector::new(
                HeadForm::Sphere,
                &nusselt(),
                &sphere::tetrahedral_sectors(DIAMETER_M),
                flipped(DIAMETER_M),
                0.5,
            )
            .unwrap(),
        );
        anemometer.output.as_mut().unwrap().head = Some(head);
    });
    spoil(&|anemometer| anemometer.output.as_mut().unwrap().head = None);
    assert_eq!(bit_flips.len(), 37);
    for (n, anemometer) in bit_flips.iter().enumerate() {
        assert!(!anemometer.is_whole(), "{n}");
        let found = (0..PIECES).filter(|&tick| !anemometer.is_intact_at(tick)).count();
        // New gains of an element empty its set of quicker ones, too.
        assert!((1..=2).contains(&found), "{n}: in {found} pieces");
    }
}

#[test]
fn what_is_not_in_use_is_not_verified_in_a_tick_but_before_a_checksum_update() {
    let mut anemometer = Anemometer::<ELEMENTS>::default();
    anemometer.handle(&gas(Some(GAS_C)), PERIOD_S).unwrap();
    anemometer.network.set_self_heating(0, &own(0), PERIOD_S).unwrap();
    assert!((0..PIECES).all(|tick| anemometer.is_intact_at(tick)));
    assert!(!anemometer.is_whole());
}

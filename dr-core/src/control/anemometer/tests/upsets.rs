//! Whatever flips in what the anemometer has been told, the seal of its piece is broken.

use super::balance::{ELEMENTS, GAS_C, PERIOD_S, config, follow, gas, own, sectors, tick};
use super::*;
use crate::model::{CrossConfig, FasterConfig, OwnConfig};
use std::vec::Vec;

const PIECES: u32 = (Network::<ELEMENTS>::PIECES + 3) as u32;

fn flipped(number: f32) -> f32 {
    f32::from_bits(number.to_bits() ^ 1)
}

/// The same with another element, pair and set of gains.
fn whole() -> Anemometer<ELEMENTS> {
    let mut anemometer = sectors(&config());
    for command in [WindCommand::Cross(cross()), WindCommand::Faster(faster())] {
        anemometer.handle(&command, PERIOD_S).unwrap();
    }
    anemometer.handle(&WindCommand::Answer(config()), PERIOD_S).unwrap();
    anemometer.handle(&gas(Some(GAS_C)), PERIOD_S).unwrap();
    anemometer
}

fn cross() -> CrossConfig {
    CrossConfig { from: 0, to: 1, mesh_rad_s: [0.1, 1.0, 10.0, 100.0], r_k_per_w: [10.0; 4], surface: [1.0; 4] }
}

fn faster() -> FasterConfig {
    FasterConfig { element: 0, set: 0, until_s: 0.5, gains: own(0).gains }
}

#[test]
fn what_nobody_has_changed_is_whole_in_every_tick() {
    let mut anemometer = whole();
    assert!(anemometer.is_whole());
    for n in 0..3 * PIECES {
        assert!(anemometer.is_whole_at(n), "{n}");
        follow(&mut anemometer, &tick(n));
    }
    assert!(Anemometer::<ELEMENTS>::new().is_whole());
}

#[test]
fn a_bit_anywhere_is_found_in_one_turn_and_in_one_piece() {
    let anemometer = whole();
    let mut upsets: Vec<Anemometer<ELEMENTS>> = Vec::new();
    let mut upset = |change: &dyn Fn(&mut Anemometer<ELEMENTS>)| {
        let mut other = anemometer.clone();
        change(&mut other);
        assert!(other != anemometer, "nothing has changed");
        upsets.push(other);
    };
    // The network's numbers are its own: it is told others, and nobody seals it.
    let changes: [fn(&mut OwnConfig); 7] = [
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
        upset(&|anemometer| anemometer.network.set_own(1, &config, PERIOD_S).unwrap());
    }
    let crosses: [fn(&mut CrossConfig); 3] = [
        |cross| cross.mesh_rad_s[3] *= 1.01,
        |cross| cross.r_k_per_w[0] = flipped(cross.r_k_per_w[0]),
        |cross| cross.surface[3] += 0.5,
    ];
    for change in crosses {
        let mut config = cross();
        change(&mut config);
        upset(&|anemometer| anemometer.network.set_cross(&config, PERIOD_S).unwrap());
    }
    let mut quicker = faster();
    quicker.gains.weights[1] = flipped(quicker.gains.weights[1]);
    upset(&|anemometer| anemometer.network.set_faster(&quicker, PERIOD_S).unwrap());
    let mut later = faster();
    later.until_s += 0.1;
    upset(&|anemometer| anemometer.network.set_faster(&later, PERIOD_S).unwrap());

    // What it has been told, and what was made of it.
    let mut amplitudes = nusselt().amplitudes[31];
    amplitudes[5] = flipped(amplitudes[5]);
    upset(&|anemometer| anemometer.setup.set_point(31, amplitudes).unwrap());
    for bit in [0, 13, 22, 30] {
        let flip = move |number: f32| f32::from_bits(number.to_bits() ^ 1 << bit);
        upset(&|anemometer| anemometer.pressure_pa = anemometer.pressure_pa.map(flip));
        upset(&|anemometer| anemometer.told_gas_c = anemometer.told_gas_c.map(flip));
        upset(&|anemometer| {
            let answer = anemometer.answer.as_mut().unwrap();
            answer.power_share = flip(answer.power_share);
        });
        upset(&|anemometer| {
            let answer = anemometer.answer.as_mut().unwrap();
            answer.config.diameter_m = flip(answer.config.diameter_m);
        });
        upset(&|anemometer| {
            let answer = anemometer.answer.as_mut().unwrap();
            answer.starting_ticks ^= 1 << bit;
        });
    }
    upset(&|anemometer| anemometer.pressure_pa = None);
    upset(&|anemometer| {
        let head = Head::Sectors(
            WindVector::new(&nusselt(), &sphere::tetrahedral_sectors(DIAMETER_M), flipped(DIAMETER_M), 0.5).unwrap(),
        );
        anemometer.answer.as_mut().unwrap().head = Some(head);
    });
    upset(&|anemometer| anemometer.answer.as_mut().unwrap().head = None);
    assert_eq!(upsets.len(), 36);
    for (n, anemometer) in upsets.iter().enumerate() {
        assert!(!anemometer.is_whole(), "{n}");
        let found = (0..PIECES).filter(|&tick| !anemometer.is_whole_at(tick)).count();
        // New gains of an element empty its set of quicker ones, too.
        assert!((1..=2).contains(&found), "{n}: in {found} pieces");
    }
}

#[test]
fn what_is_not_in_use_is_not_looked_at_in_a_tick_but_before_it_is_sealed() {
    let mut anemometer = Anemometer::<ELEMENTS>::new();
    anemometer.handle(&gas(Some(GAS_C)), PERIOD_S).unwrap();
    anemometer.network.set_own(0, &own(0), PERIOD_S).unwrap();
    assert!((0..PIECES).all(|tick| anemometer.is_whole_at(tick)));
    assert!(!anemometer.is_whole());
}

//! Parts of an anemometer in a digest.

use super::balance::{ELEMENTS, config, follow, sectors, tick};
use super::*;
use crate::wind::WindEstimate;

fn digest(anemometer: &Anemometer<ELEMENTS>, told: Option<&WindTick>) -> u64 {
    let mut digest = Digest::default();
    anemometer.digest(ELEMENTS as u8, told, &mut digest);
    digest.value()
}

#[test]
fn one_that_does_not_answer_leaves_no_trace() {
    let mut anemometer = balance::told_of(&sphere::tetrahedral_sectors(DIAMETER_M));
    anemometer.state.gas_c = Some(-50.0);
    assert_eq!(digest(&anemometer, None), Digest::default().value());
}

#[test]
fn the_digest_covers_every_number_that_is_reported_and_every_state() {
    let mut anemometer = sectors(&config());
    let told = follow(&mut anemometer, &tick(0)).unwrap();
    let mut seen = std::vec![digest(&anemometer, None), digest(&anemometer, Some(&told))];
    let changes: [fn(&mut WindTick); 7] = [
        |told| told.quality_flags = QualityFlags(told.quality_flags.0 ^ 1),
        |told| told.conductance_w_k[3] += 1e-6,
        |told| told.raw_w_k[0] += 1e-6,
        |told| told.wind.wind_m_s[2] += 1e-3,
        |told| told.wind.covariance_m2_s2[2][2] += 1e-3,
        |told| told.wind.speed_m_s += 1e-3,
        |told| told.wind = WindEstimate::none(),
    ];
    for change in changes {
        let mut other = told;
        change(&mut other);
        seen.push(digest(&anemometer, Some(&other)));
    }
    let kept: [fn(&mut Anemometer<ELEMENTS>); 3] = [
        |anemometer| anemometer.state.gas_c = Some(-50.0),
        |anemometer| anemometer.state.power_w[4] += 1e-3,
        // The network's numbers change with one more tick of another temperature.
        |anemometer| {
            let mut warmer = tick(1);
            warmer.temperature_c[3] += 0.1;
            let power_w = anemometer.state.power_w;
            follow(anemometer, &warmer);
            anemometer.state.power_w = power_w;
        },
    ];
    for change in kept {
        let mut other = anemometer.clone();
        change(&mut other);
        seen.push(digest(&other, Some(&told)));
    }
    let different: std::collections::BTreeSet<_> = seen.iter().collect();
    assert_eq!(different.len(), seen.len());
    assert_eq!(digest(&anemometer.clone(), Some(&told)), seen[1]);
}

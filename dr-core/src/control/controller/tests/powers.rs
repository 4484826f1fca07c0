//! Mean powers that may be asked for, and what the digest sees of a drive.

use super::*;

#[test]
fn a_mean_power_must_be_one_that_some_plausible_resistance_gives_off() {
    let mut controller = Controller::<1>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Element { element: 0, config: element() }).unwrap();
    // (3 mA)² of 50 Ω, and (16 mA)² of 260 Ω.
    let (least_w, most_w) = (4.5e-4, 6.656e-2);
    for (power_w, is_possible) in
        [(0.999 * least_w, false), (1.001 * least_w, true), (0.999 * most_w, true), (1.001 * most_w, false)]
    {
        let answer = controller.handle(Command::Drive { element: 0, drive: Drive::Power { power_w } });
        let refused =
            matches!(answer, Err(Refusal::Invalid { element: Some(0), error }) if error.parameter == Parameter::PowerW);
        assert_eq!(answer.is_ok(), is_possible, "{power_w} W");
        assert_eq!(refused, !is_possible, "{power_w} W: {answer:?}");
    }
}

#[test]
fn the_digest_covers_the_level_that_a_drive_requests() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    let tick = controller.tick(&[code(-40.0, false); 2]);
    let mut digests = std::collections::BTreeSet::new();
    for bits in 0..8_u32 {
        let mut changed = controller;
        let drive = &mut changed.states[1].drive;
        let level = |is_high: bool| if is_high { Level::High } else { Level::Low };
        (drive.level, drive.saturated) = (level(bits & 1 > 0), bits & 2 > 0);
        changed.levels = Heaters((bits & 4) as usize >> 1);
        let mut digest = Digest::default();
        changed.digest(&tick, &mut digest);
        digests.insert(digest.value());
    }
    assert_eq!(digests.len(), 8);
}

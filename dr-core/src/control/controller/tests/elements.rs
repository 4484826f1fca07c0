//! Number of elements; room for more changes nothing.

use super::*;

#[test]
fn elements_are_configured_without_gaps() {
    let mut controller = Controller::<4>::new(&HardwareLimits::SIMULATED);
    let configure = |index| Command::Element { element: index, config: element() };
    controller.handle(configure(0)).unwrap();
    let before = controller;
    assert_eq!(controller.handle(configure(2)), Err(Refusal::NotConfigured { element: 1 }));
    assert_eq!(controller.handle(configure(4)), Err(Refusal::NoSuchElement { element: 4 }));
    assert_eq!(controller, before);
    controller.handle(configure(1)).unwrap();
    // Once more is a change of what is there, not another one.
    controller.handle(configure(0)).unwrap();
    assert_eq!(controller.elements(), 2);
    assert_eq!(controller.tick(&[code(0.0, false); 4]).elements, 2);
}

/// Three drives on three elements, whatever room there is: all bits that the ticks say, and the
/// digest.
fn three_of<const N: usize>(observe: bool) -> (Vec<u32>, u64) {
    let mut controller = Controller::<N>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Observe { on: observe }).unwrap();
    let drives = [
        Drive::Temperature { target_c: -30.0 },
        Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 },
        Drive::Power { power_w: 0.02 },
    ];
    for (index, drive) in (0..).zip(drives) {
        controller.handle(Command::Element { element: index, config: element() }).unwrap();
        controller.handle(Command::Model { element: index, model: model() }).unwrap();
        controller.handle(Command::Drive { element: index, drive }).unwrap();
    }
    start(&mut controller).unwrap();
    let (mut temperature_c, mut heaters) = ([-50.0_f32; 3], Heaters::default());
    let (mut said, mut digest) = (Vec::new(), Digest::default());
    for n in 0..2000 {
        // Statements about absent elements must not matter: here they are cut.
        let mut readings = [Reading::Code(i32::MAX); N];
        for (i, (reading, &temperature_c)) in readings.iter_mut().zip(&temperature_c).enumerate() {
            *reading = if n % 97 == 96 { Reading::Missing } else { code(temperature_c, heaters.is_high(i)) };
        }
        let tick = controller.tick(&readings);
        assert_eq!(tick.state, RunState::Running);
        controller.digest(&tick, &mut digest);
        heaters = tick.heaters;
        said.extend([tick.heaters.0 as u32, tick.valid as u32]);
        for list in [Some(tick.temperature_c), Some(tick.power_w), tick.equivalent_power_w].iter().flatten() {
            said.extend(list[..3].iter().map(|number| number.to_bits()));
            assert!(list[3..].iter().all(|&number| number == 0.0));
        }
        for (temperature_c, power_w) in temperature_c.iter_mut().zip(tick.power_w) {
            *temperature_c += 0.005 * (-50.0 + 600.0 * power_w - *temperature_c);
        }
    }
    (said, digest.value())
}

#[test]
fn room_for_more_elements_changes_nothing() {
    for observe in [false, true] {
        let three = three_of::<3>(observe);
        assert_eq!(three, three_of::<4>(observe));
        assert_eq!(three, three_of::<16>(observe));
    }
}

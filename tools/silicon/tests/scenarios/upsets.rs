//! Bits that flip in the RAM of a board that heats, one a board: no heater is high against the
//! invariant, whatever else becomes of it. `ANEMO_FLIPS` asks for more.

use crate::crashes::{heat, heating};
use crate::lives::{Chance, number};
use crate::rig::Rig;
use silicon::complaint::BrokenRule;
use silicon::time::{ms, us};
use std::ops::Range;

const FLIPS: u64 = 20;
const RAM_END: u32 = 0x2002_0000;
/// Part of the stack that may be in use at any moment.
const STACK_BYTES: u32 = 2_048;

#[test]
fn a_bit_that_flips_in_ram_leaves_no_heater_high() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let heated = rig.machine().snapshot().unwrap();
    // Statics lie above the stack.
    let used: Range<u32> = Rig::function("_stack_start") - STACK_BYTES..RAM_END;
    let (mut ended, mut deaf) = (0, 0);
    let flips = number("ANEMO_FLIPS").unwrap_or(FLIPS);
    for seed in 1..=flips {
        let mut chance = Chance::of(seed);
        rig.machine().restore(&heated).unwrap();
        rig.machine().run_for(us(chance.below(10_000))).unwrap();
        let (address, bit) = (used.start + chance.below(used.len() as u64) as u32, chance.below(8));
        let mut byte = [0];
        rig.machine().core_mut().read_memory(address, &mut byte).unwrap();
        rig.machine().core_mut().write_memory(address, &[byte[0] ^ 1 << bit]).unwrap();
        rig.machine().run_for(ms(1_000)).unwrap();
        ended += u32::from(rig.machine().board().heaters() == 0);
        deaf += u32::from(rig.try_instrument().is_err());
        let complaints = rig.complaints();
        let heats = |rule| matches!(rule, BrokenRule::HeaterHigh | BrokenRule::HeaterUnread);
        let wrong: Vec<String> = complaints.iter().filter(|of| heats(of.rule)).map(ToString::to_string).collect();
        assert!(wrong.is_empty(), "bit {bit} at {address:#x}, number {seed}: {wrong:?}");
    }
    println!(
        "{flips} flips: {ended} with heaters low after a second, {deaf} deaf, no heater high against the invariant"
    );
    assert!(10 * u64::from(deaf) <= flips, "{deaf}");
}

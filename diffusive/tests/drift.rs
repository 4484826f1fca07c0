//! A heater of known gain in a room that moves, identified without options: fifty records of every
//! kind of drift. `anemo benchmark drift` has a thousand.

use diffusive::identify::rig::{DriftFigures, DriftReport, RoomDrift, campaign};

const RECORDS: u64 = 50;

#[test]
fn two_standard_errors_hold_the_gain_in_every_room() {
    let of = |room: RoomDrift| DriftFigures::of(room, &campaign(room, RECORDS, &|_| {}).unwrap());
    let kinds: Vec<DriftFigures> = RoomDrift::ALL.into_iter().map(of).collect();
    let report = DriftReport { kinds };
    println!("{report}");
    for of in &report.kinds {
        // Of fifty, 95 % are 47.5 ± 1.5: three of these errors below.
        assert!(of.within_2_se_percent >= 86.0, "{of:?}");
        if let Some(known) = of.median_known_error_k_per_w {
            assert!(of.median_error_k_per_w <= 1.5 * known, "{of:?}");
        }
    }
    // A room that stands still costs nothing: the gain of 213 K/W is right to some 1e-5.
    let still = &report.kinds[0];
    assert!(still.median_error_k_per_w < 0.01 && still.found_percent <= 20.0, "{still:?}");
}

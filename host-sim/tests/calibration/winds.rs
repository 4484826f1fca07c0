//! Least number of winds that suffices.

use crate::tunnel::{Tunnel, speeds};
use anemometry::calibrate::{CalibrateError, ComparisonSummary, calibrate, compare};

#[test]
fn few_winds_suffice() {
    for (name, tunnel) in [("sectors", Tunnel::sectors()), ("hemispheres", Tunnel::hemispheres())] {
        let unseen = tunnel.readings(&speeds(0.55, 13.5, 15), 29, 1e-6, 9);
        for (count, directions) in [(5, 4), (6, 4), (6, 6), (6, 8), (8, 5), (8, 6), (8, 8), (12, 6), (12, 10), (24, 20)]
        {
            match calibrate(&tunnel.head(), &tunnel.readings(&speeds(0.5, 14.0, count), directions, 1e-3, 5)) {
                Ok(found) => {
                    let errors: Vec<_> = unseen[1..].iter().filter_map(|r| compare(&found, r).unwrap()).collect();
                    let all = ComparisonSummary::of(errors.iter());
                    println!(
                        "{name}: {count} speeds × {directions} directions: direction {:.2}° rms, {:.2}° worst, speed {:.2} % rms, {:.2} % worst",
                        all.direction_rms_deg,
                        all.direction_worst_deg,
                        100.0 * all.speed_rms,
                        100.0 * all.speed_worst
                    );
                    assert_eq!(errors.len(), unseen.len() - 1);
                }
                Err(CalibrateError::Spread(lacking)) => {
                    println!("{name}: {count} speeds × {directions} directions: refused, {}", lacking.join("; "));
                }
                Err(other) => panic!("{other}"),
            }
        }
    }
}

//! Whether a set of winds can determine a card, before anything is fitted; and if not, which winds
//! are missing.

use recording::text::count;

use super::drawn::CardWind;

/// Sectors of directions of which each needs a wind.
const SECTORS: usize = 12;
/// Fewest winds: some for every unknown.
const LEAST_WINDS: usize = 40;
/// Least ratio of the greatest to the least speed.
const LEAST_RATIO: f64 = 3.0;
/// Which winds are missing, a sentence each.
pub fn lacking(winds: &[CardWind]) -> Vec<String> {
    let mut lacking = Vec::new();
    if winds.len() < LEAST_WINDS {
        lacking.push(format!("{} given, at least {LEAST_WINDS} are needed", count(winds.len(), "wind")));
    }
    let (least, most) = ends(winds);
    if most < LEAST_RATIO * least {
        lacking.push(format!(
            "the fastest wind is {:.1} times as fast as the slowest; {LEAST_RATIO} times are needed at least",
            most / least
        ));
    }
    let width = 360 / SECTORS;
    let sector = |wind: &CardWind| (wind.angle.to_degrees().rem_euclid(360.0) as usize / width).min(SECTORS - 1);
    for empty in (0..SECTORS).filter(|&n| winds.iter().all(|wind| sector(wind) != n)) {
        lacking.push(format!(
            "no wind goes towards {} to {}° from the tip around the boom",
            empty * width,
            (empty + 1) * width
        ));
    }
    lacking
}

/// Least and greatest Reynolds number.
pub fn ends(winds: &[CardWind]) -> (f64, f64) {
    winds.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), wind| {
        (least.min(wind.root * wind.root), most.max(wind.root * wind.root))
    })
}

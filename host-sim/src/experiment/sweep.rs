//! Many winds of all directions and speeds, one after the other: what a calibration needs, and what
//! it is judged by.
//!
//! `[sweep]` stands in place of `[[wind]]`:
//!
//! | key | unit | meaning |
//! |---|---|---|
//! | `winds` | | how many |
//! | `least_m_s`, `most_m_s` | m/s | speeds between these, evenly by their logarithm |
//! | `hold_s` | s | each wind |
//! | `still_s` | s | still gas before the first; 0 if not given |
//! | `stem_cone_deg` | ° | winds that come from within this angle of the stem, which is along −z, are left out; 0 if not given |
//! | `plane` | | `level`: winds in the horizontal plane, in all its directions, as for a card that lies in it; `upright`: in that of y and z, across a boom along x; or the plane across a normal `[x, y, z]` |
//! | `facing_deg` | ° | with `plane`: only winds that come from within this angle of `facing_azimuth_deg`; 180 if not given |
//! | `facing_azimuth_deg` | ° | from x towards y, of a normal from the part of x in the plane around the normal; 0 if not given |
//! | `seed` | | another seed, other winds; the experiment's if not given |
//!
//! Directions are drawn evenly over the sphere, or the plane. It becomes ordinary entries with the
//! labels `still`, `wind 1`, `wind 2` …

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::Deserialize;

use super::grid::TickGrid;
use crate::sensor::WindEntry;
use anemometry::vector::{self, length, unit};
use recording::toml_file::FileError;

const SPEEDS_M_S: std::ops::RangeInclusive<f64> = 0.01..=100.0;
const MOST_WINDS: u32 = 10_000;
const STILL: &str = "still";
/// Cosine of a normal to x from which x has no part in the plane.
const ALONG_X: f64 = 0.999;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepTable {
    winds: u32,
    least_m_s: f64,
    most_m_s: f64,
    hold_s: f64,
    #[serde(default)]
    still_s: f64,
    #[serde(default)]
    stem_cone_deg: f64,
    plane: Option<SweepPlane>,
    facing_deg: Option<f64>,
    #[serde(default)]
    facing_azimuth_deg: f64,
    seed: Option<u64>,
}

/// In which the winds lie.
#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(untagged, expecting = "a plane is `level`, `upright` or a normal [x, y, z]")]
enum SweepPlane {
    Named(NamedPlane),
    /// Across a normal of any length.
    Across([f64; 3]),
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum NamedPlane {
    Level,
    Upright,
}

/// A direction in the plane across a normal as azimuth and elevation, °: at an angle from the part
/// of x in it, or of y where the normal is along x.
fn across(normal: [f64; 3], angle_deg: f64) -> (f64, f64) {
    let normal = unit(normal);
    let along = if normal[0].abs() < ALONG_X { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let first = unit(vector::across(along, normal));
    let second = vector::cross(normal, first);
    let (sine, cosine) = libm::sincos(angle_deg.to_radians());
    let [x, y, z]: [f64; 3] = std::array::from_fn(|k| cosine * first[k] + sine * second[k]);
    (libm::atan2(y, x).to_degrees(), libm::asin(z.clamp(-1.0, 1.0)).to_degrees())
}

/// The entries of an experiment; `seed` is that of the experiment.
pub(super) fn entries(grid: &TickGrid, table: &SweepTable, seed: u64) -> Result<Vec<WindEntry>, FileError> {
    let source = grid.source;
    source.within("sweep.winds", f64::from(table.winds), 1.0..=f64::from(MOST_WINDS), "")?;
    source.within("sweep.least_m_s", table.least_m_s, SPEEDS_M_S, "m/s")?;
    source.within("sweep.most_m_s", table.most_m_s, table.least_m_s..=*SPEEDS_M_S.end(), "m/s")?;
    source.within("sweep.stem_cone_deg", table.stem_cone_deg, 0.0..=90.0, "°")?;
    if let Some(facing_deg) = table.facing_deg {
        source.within("sweep.facing_deg", facing_deg, 1.0..=180.0, "°")?;
        if table.plane.is_none() {
            return Err(source.refuse("sweep.facing_deg", "is of winds in a plane: `plane` belongs to it"));
        }
    }
    if let Some(SweepPlane::Across(normal)) = table.plane
        && !(length(normal).is_finite() && length(normal) > 0.0)
    {
        return Err(
            source.refuse("sweep.plane", "is a normal without a direction: [0.0, 0.0, 1.0] is the level plane's")
        );
    }
    source.within("sweep.facing_azimuth_deg", table.facing_azimuth_deg, -360.0..=360.0, "°")?;
    let hold = grid.whole_ticks("sweep.hold_s", table.hold_s)?;
    let still = grid.pause_ticks("sweep.still_s", table.still_s)?;
    let wanted = u64::from(still) + u64::from(table.winds) * u64::from(hold);
    if wanted > u64::from(grid.ticks) {
        let (needed_s, has_s) = (wanted as f64 * grid.sample_period_s, grid.end_s());
        let sentence = format!(
            "needs {needed_s} s, but the experiment is over at {has_s} s: a greater duration_s, or fewer winds"
        );
        return Err(source.refuse("sweep", sentence));
    }
    let mut random = ChaCha8Rng::seed_from_u64(table.seed.unwrap_or(seed));
    // Evenly between 0 and 1.
    let mut share = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut entries = Vec::with_capacity(table.winds as usize + 1);
    if still > 0 {
        entries.push(WindEntry { label: STILL.to_owned(), ..WindEntry::default() });
    }
    let lowest = libm::cos(table.stem_cone_deg.to_radians());
    for n in 0..table.winds {
        let speed_m_s = table.least_m_s * libm::pow(table.most_m_s / table.least_m_s, share());
        // A wind that comes from the stem goes to +z.
        let upwards = loop {
            if table.plane.is_some() {
                break 0.0;
            }
            let z = 2.0 * share() - 1.0;
            if table.stem_cone_deg == 0.0 || z < lowest {
                break z;
            }
        };
        // A wind from +x goes to 180°.
        let angle_deg = match table.facing_deg {
            Some(facing_deg) => 180.0 + table.facing_azimuth_deg + facing_deg * (2.0 * share() - 1.0),
            None => 360.0 * share(),
        };
        let (azimuth_deg, elevation_deg) = match table.plane {
            Some(SweepPlane::Across(normal)) => across(normal, angle_deg),
            Some(SweepPlane::Named(NamedPlane::Upright)) => {
                let (up, along_y) = libm::sincos(angle_deg.to_radians());
                (if along_y < 0.0 { 270.0 } else { 90.0 }, libm::asin(up).to_degrees())
            }
            _ => (angle_deg, libm::asin(upwards).to_degrees()),
        };
        entries.push(WindEntry {
            start_s: grid.time_s(still + n * hold),
            label: format!("wind {}", n + 1),
            speed_m_s,
            azimuth_deg,
            elevation_deg,
            ..WindEntry::default()
        });
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use anemometry::vector::{angle_deg, dot};
    use recording::toml_file::TomlSource;

    fn with(sweep: &str) -> Result<Experiment, String> {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/still-gas.toml");
        let mut source = TomlSource::read(&path).unwrap();
        let wind = source.text.find("[[wind]]").unwrap();
        source.text = format!("{}[sweep]\n{sweep}\n", &source.text[..wind]);
        Experiment::from_source(source).map_err(|error| error.to_string())
    }

    #[test]
    fn winds_come_from_everywhere_but_the_stem() {
        let experiment =
            with("winds = 500\nleast_m_s = 1.0\nmost_m_s = 13.0\nhold_s = 0.1\nstill_s = 1.0\nstem_cone_deg = 20.0")
                .unwrap();
        assert_eq!((experiment.wind.len(), experiment.wind[0].speed_m_s), (501, 0.0));
        let winds = &experiment.wind[1..];
        assert!((winds[0].start_s - 1.0).abs() < 1e-12 && (winds[499].start_s - 50.9).abs() < 1e-9);
        let mut mean = [0.0; 3];
        for wind in winds {
            assert!((1.0..=13.0).contains(&wind.speed_m_s) && wind.elevation_deg < 70.0);
            for (mean, v) in mean.iter_mut().zip(wind.mean_m_s()) {
                *mean += v / wind.speed_m_s / winds.len() as f64;
            }
        }
        // Three standard errors of a mean of components; what is left out above pulls z down by
        // 0.03.
        assert!(mean.iter().all(|mean| mean.abs() < 3.0 / (3.0 * 500.0_f64).sqrt() + 0.03), "{mean:?}");
        let slow = winds.iter().filter(|wind| wind.speed_m_s < 13.0_f64.sqrt()).count();
        assert!((200..300).contains(&slow), "half of them are below the geometric mean: {slow}");
    }

    #[test]
    fn winds_of_a_plane_lie_in_it_and_go_everywhere() {
        let experiment =
            with("winds = 200\nleast_m_s = 0.5\nmost_m_s = 10.0\nhold_s = 0.1\nplane = \"level\"").unwrap();
        let mut quarters = [0; 4];
        for wind in &experiment.wind {
            assert_eq!(wind.elevation_deg, 0.0);
            quarters[(wind.azimuth_deg / 90.0) as usize % 4] += 1;
        }
        assert!(quarters.iter().all(|&count| count > 30), "{quarters:?}");
    }

    #[test]
    fn winds_that_face_a_probe_come_from_its_side() {
        let sweep = "winds = 100\nleast_m_s = 0.5\nmost_m_s = 10.0\nhold_s = 0.1\nfacing_deg = 40.0";
        let experiment = with(&format!("{sweep}\nplane = \"level\"")).unwrap();
        let cosine = libm::cos(40_f64.to_radians());
        assert!(experiment.wind.iter().all(|wind| -wind.mean_m_s()[0] >= wind.speed_m_s * (cosine - 1e-9)));
        assert!(experiment.wind.iter().any(|wind| -wind.mean_m_s()[0] < 0.8 * wind.speed_m_s));
        assert!(with(sweep).unwrap_err().contains("`sweep.facing_deg` is of winds in a plane"));
    }

    #[test]
    fn a_sweep_that_cannot_be_is_refused_by_name() {
        let good = "winds = 5\nleast_m_s = 1.0\nmost_m_s = 13.0\nhold_s = 1.0";
        assert!(with(good).is_ok());
        for (from, to, expected) in [
            ("winds = 5", "winds = 0", "`sweep.winds` is 0"),
            ("winds = 5", "winds = 5000", "`sweep` needs 5000 s"),
            ("most_m_s = 13.0", "most_m_s = 0.5", "`sweep.most_m_s` is 0.5 m/s: it must lie between 1 and 100 m/s"),
            ("hold_s = 1.0", "hold_s = 0.0001", "`sweep.hold_s`"),
            ("hold_s = 1.0", "hold_s = 1.0\nstem = 1.0", "unknown key `stem`"),
            ("hold_s = 1.0", "hold_s = 1.0\nplane = \"slanted\"", "a plane is `level`, `upright` or a normal"),
        ] {
            let error = with(&good.replace(from, to)).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_plane_across_a_normal_is_the_named_one_of_that_normal() {
        let sweep = |plane: &str| {
            with(&format!("winds = 200\nleast_m_s = 1.0\nmost_m_s = 2.0\nhold_s = 0.1\nplane = {plane}")).unwrap().wind
        };
        for (named, normal) in [("\"level\"", "[0.0, 0.0, 2.0]"), ("\"upright\"", "[1.0, 0.0, 0.0]")] {
            for (a, b) in sweep(named).iter().zip(sweep(normal)) {
                assert!(angle_deg(a.mean_m_s(), b.mean_m_s()) < 1e-9, "{named}");
            }
        }
        let normal = [0.0, -0.75_f64.sqrt(), -0.5];
        let tilted = sweep("[0.0, -0.8660254037844386, -0.5]");
        assert!(tilted.iter().all(|wind| dot(wind.mean_m_s(), normal).abs() < 1e-9));
        let quadrant = |wind: &WindEntry| (wind.mean_m_s()[0] > 0.0, wind.mean_m_s()[2] > 0.0);
        for of in [(false, false), (false, true), (true, false), (true, true)] {
            assert!(tilted.iter().filter(|wind| quadrant(wind) == of).count() > 30);
        }
        let none =
            with("winds = 2\nleast_m_s = 1.0\nmost_m_s = 2.0\nhold_s = 0.1\nplane = [0.0, 0.0, 0.0]").unwrap_err();
        assert!(none.contains("sweep.plane"), "{none}");
    }

    #[test]
    fn an_upright_plane_is_that_of_y_and_z() {
        let sweep = "winds = 200\nleast_m_s = 1.0\nmost_m_s = 2.0\nhold_s = 0.1\nplane = \"upright\"";
        let winds = with(sweep).unwrap().wind;
        assert!(winds.iter().all(|wind| wind.mean_m_s()[0].abs() < 1e-12));
        let quarter =
            |y: f64, z: f64| winds.iter().filter(move |of| of.mean_m_s()[1] * y > 0.0 && of.mean_m_s()[2] * z > 0.0);
        for (y, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            // Three standard errors of a quarter of 200.
            assert!((32..=68).contains(&quarter(y, z).count()), "{y} {z}");
        }
    }

    #[test]
    fn winds_face_where_they_are_said_to() {
        let sweep = "winds = 50\nleast_m_s = 1.0\nmost_m_s = 2.0\nhold_s = 0.1\nplane = \"level\"\nfacing_deg = 20.0\nfacing_azimuth_deg = 45.0";
        for wind in with(sweep).unwrap().wind {
            let [x, y, _] = wind.mean_m_s();
            // From +x and +y it goes to -x and -y.
            assert!((libm::atan2(-y, -x).to_degrees() - 45.0).abs() < 20.0 + 1e-9);
        }
    }
}

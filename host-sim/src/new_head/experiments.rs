//! The first experiments of a new head: long enough for its slowest and its usual time constants.

use super::limits::NewHeadError;
use crate::head_check::{ElementCheck, GivenConditions, HeadCheckReport, check};
use anemometry::calibrate::drawn::drawn;
use anemometry::calibrate::{DrawnOptions, LossLaw};
use anemometry::head::body::BodyLink;
use anemometry::head::{Head, HeadElement};
use dr_core::wind::HeadForm;
use recording::text::short;

/// Usual overheat of the experiments, K.
pub const OVERHEAT_K: f64 = 20.0;
/// Usual sample period of a closed loop, s.
const HELD_PERIOD_S: f64 = 0.002;
/// Shortest sample period, s.
const SHORTEST_S: f64 = 0.001;
/// Change of a bare element's temperature by one bit, as a share of the overheat.
const MOST_RIPPLE: f64 = 0.005;

/// Greatest wind, m/s.
const MOST_M_S: f64 = 10.0;
/// Least ratio of the currents by which an element is identified: a little more than boards take.
const LEAST_RATIO: f64 = 1.6;

/// For winds across a head.
const LEVEL: &str = "plane = \"level\" # of x and y: along its axis such a head tells nothing\n";

/// Experiments of a new head.
pub struct NewExperiments {
    /// Names and texts of the files.
    pub files: Vec<(String, String)>,
    /// Names of the elements that are identified.
    pub identified: Vec<String>,
    /// There are others that might be driven, and only sense at this overheat.
    pub is_part: bool,
    /// Why the head cannot be calibrated so.
    pub uncalibrated: Option<String>,
    /// Fate of winds that are too strong.
    pub too_strong: Option<String>,
    /// Quiescent gas before the first wind, s.
    pub still_s: f64,
}

/// Sample period of a closed loop, s: short enough that a bit changes the temperature of an element
/// that is itself the surface by a small share of its overheat.
fn held_period_s(head: &Head, report: &HeadCheckReport) -> f64 {
    let overheat_k = report.conditions.overheat_k;
    let bare = report.elements.iter().zip(&head.elements).filter(|(of, element)| of.held && element.is_surface());
    let bare = bare.filter(|(_, element)| element.layers == 0);
    let mut each_s = bare.map(|(of, _)| MOST_RIPPLE * overheat_k * of.capacity_j_k / of.level_w[1]);
    if each_s.any(|fastest_s| fastest_s < HELD_PERIOD_S) { SHORTEST_S } else { HELD_PERIOD_S }
}

/// Currents at which pseudo-random bits warm an element in quiescent gas by about the overheat, if
/// its own make more, as a table of an experiment.
fn gentle_currents(element: &HeadElement, of: &ElementCheck, overheat_k: f64) -> Option<String> {
    let share = 2.0 * overheat_k / of.own_gain_k_per_w / of.level_w[1];
    let low_a = element.nominal.current_low_a;
    let high_a = (element.nominal.current_high_a * share.sqrt()).max(LEAST_RATIO * low_a);
    (high_a < element.nominal.current_high_a).then(|| {
        format!(
            "[currents] # so that half of the time at high makes about {overheat_k} K\n{} = {{ low_a = {}, high_a = {} }}\n\n",
            of.name,
            short(low_a, 4),
            short(high_a, 2)
        )
    })
}

/// Winds that a head can tell, by what its surfaces belong to.
fn plane(head: &Head) -> String {
    let Ok((_, drawn)) = drawn(head, &DrawnOptions::default(), LossLaw::Spline) else { return LEVEL.to_owned() };
    match drawn.form {
        HeadForm::Sphere | HeadForm::Cube => String::new(),
        HeadForm::Wires => {
            let middle = drawn.surfaces.iter().fold([0.0; 2], |[x, y], of| {
                let [nx, ny, _] = of.config.axis.map(f64::from);
                [x + nx, y + ny]
            });
            let middle_deg = short(libm::atan2(middle[1], middle[0]).to_degrees(), 4);
            format!(
                "plane = \"level\" # of the wires\nfacing_deg = 40.0 # of the middle of their normals\nfacing_azimuth_deg = {middle_deg}\n"
            )
        }
        HeadForm::Cylinder if drawn.surfaces.iter().all(|of| of.config.corner[0].abs() > 0.5) => {
            "plane = \"upright\" # of y and z: along x such a head tells nothing\n".to_owned()
        }
        HeadForm::Cylinder | HeadForm::Single => LEVEL.to_owned(),
    }
}

/// The experiments of a head at an overheat, with so many winds to estimate.
///
/// # Errors
/// If the head cannot be simulated, or not operated so.
pub fn experiments(head: &Head, overheat_k: f64, count: u32) -> Result<NewExperiments, NewHeadError> {
    let report = check(head, GivenConditions::default(), |conditions| conditions.overheat_k = overheat_k)?;
    let held: Vec<&str> = report.elements.iter().filter(|of| of.held).map(|of| of.name.as_str()).collect();
    let slowest_s = report.time_constants_s.first().copied().unwrap_or(1.0);
    let record_s = (12.0 * slowest_s / 600.0).ceil() * 600.0;
    super::limits::refuse(head, &report, record_s)?;
    let conditions = report.conditions;
    let set_point_c = short(conditions.set_point_c(), 4);
    let held_period_s = held_period_s(head, &report);
    let start = |title: &str, period_s: f64, duration_s: f64, seed: u64| {
        format!(
            "title = \"{}: {title}\"\nhead = \"head.toml\"\nsample_period_s = {period_s}\nduration_s = {duration_s:.1}\n\
             seed = {seed} # of noise, and of the specimen where head.toml states tolerances\n\n[gas]\nspecies = \"{}\"\n\
             pressure_pa = {:.1}\ntemperature_c = {:.2}\n\n[front_end]\nnoise_v_rms = 4e-6\n\n",
            head.name,
            conditions.species.name(),
            conditions.pressure_pa,
            conditions.temperature_c
        )
    };
    let mut drives = "[drives]\n".to_owned();
    held.iter().for_each(|name| drives += &format!("{name} = {{ temperature_c = {set_point_c} }}\n"));
    let rods = head.body.iter().flat_map(|body| &body.links).any(|link| matches!(link, BodyLink::Rod { .. }));
    let warm_s = (if rods { 2.0 } else { 5.0 } * slowest_s / 60.0).ceil() * 60.0;
    let winds = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0];
    let each_s = 60.0;
    let mut text = start("held in winds", held_period_s, warm_s + each_s * winds.len() as f64, 1);
    text += &drives;
    for (i, speed) in winds.iter().enumerate() {
        let start_s = if i == 0 { 0.0 } else { warm_s + each_s * i as f64 };
        text += &format!(
            "\n[[wind]]\nstart_s = {start_s:.1}\nlabel = \"{speed} m/s\"\nspeed_m_s = {speed:.1}\nazimuth_deg = 200.0\n"
        );
    }
    let mut all = vec![("held.toml".to_owned(), text)];
    // A calibration, and winds that it has not seen.
    let plane = plane(head);
    for (file, title, winds, [least_m_s, most_m_s], hold_s, seed) in [
        ("tunnel.toml", "calibration in a tunnel", 60, [0.5, MOST_M_S], 20.0, 1),
        ("winds.toml", "winds to estimate", count, [0.7, 9.0], 10.0, 7),
    ] {
        let mut text = start(title, held_period_s, warm_s + hold_s * f64::from(winds), 41);
        text += &drives;
        text += &format!(
            "\n[sweep]\nwinds = {winds}\nleast_m_s = {least_m_s:.1}\nmost_m_s = {most_m_s:.1}\nhold_s = {hold_s:.1}\nstill_s = \
             {warm_s:.1}\nseed = {seed}\n"
        );
        text += &plane;
        all.push((file.to_owned(), text));
    }
    let checked = head.elements.iter().zip(&report.elements).filter(|(_, of)| of.held);
    for (i, (element, of)) in checked.enumerate() {
        let name = &of.name;
        let mut text = start(&format!("what {name} heats, in quiescent gas"), 0.01, record_s, 41);
        text += &gentle_currents(element, of, conditions.overheat_k).unwrap_or_default();
        text += &format!(
            "[drives]\n{name} = {{ level = \"low\" }}\n\n# Half a minute of rest: the record begins in a steady state.\n[[changes]]\n\
             start_s = 30.0\ndrives = {{ {name} = {{ prbs = {{ order = 18, bit_time_s = 0.02, seed = {} }} }} }}\n\n\
             [[wind]]\nstart_s = 0.0\nlabel = \"still\"\nspeed_m_s = 0.0\n",
            5 + i
        );
        all.push((format!("identify-{name}.toml"), text));
    }
    let identified = held.iter().map(|&name| name.to_owned()).collect();
    let drivable = head.elements.iter().filter(|of| of.may_be_driven());
    Ok(NewExperiments {
        files: all,
        identified,
        is_part: held.len() < drivable.count(),
        uncalibrated: super::limits::uncalibrated(head, &report),
        too_strong: super::limits::too_strong(head, &report, MOST_M_S),
        still_s: warm_s,
    })
}

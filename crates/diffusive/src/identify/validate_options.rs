//! Checks of the options against a record's length, sample period and columns, before its rows are
//! read.

use std::f64::consts::PI;

use super::options::IdentifyOptions;
use super::record::{RecordError, Survey};
use super::{refine, tied};
use recording::text::tidy;

/// A mesh's last rate in units of π/Ts, the record's fastest, beyond which it is marked, or
/// refused.
const MARKED: f64 = 10.0;
const REFUSED: f64 = 1e3 / PI;

/// The least number of rows that anything is made of.
pub const LEAST_ROWS: u64 = 20;

/// Refuses options that this record cannot meet.
pub fn refuse(survey: &Survey, options: &IdentifyOptions) -> Result<(), RecordError> {
    let (rows, period_s) = (survey.rows, survey.sample_period_s);
    survey.refuse_if(rows < LEAST_ROWS, format_args!("has {rows} rows: a model takes at least {LEAST_ROWS}"))?;
    if options.tie {
        tied::refuse(survey, options)?;
    }
    let fixed = [(options.tie, "--tie"), (options.free_poles.is_some(), "--free-poles")];
    for (_, name) in fixed.iter().filter(|(is_given, _)| *is_given) {
        survey.refuse_if(
            options.follow_ambient,
            format_args!(
                "cannot be identified with measured surroundings and {name} at once: leave out {name} or --ambient"
            ),
        )?;
    }
    if let Some(poles) = options.free_poles {
        refine::refuse(survey, poles, options)?;
    }
    let delay = options.constraints.delay.unwrap_or(0);
    survey.refuse_if(
        delay as u64 > rows / 4,
        format_args!(
            "has {rows} rows: a dead time of {delay} samples leaves too few to learn from (at most a quarter)"
        ),
    )?;
    if let Some((first, last)) = options.constraints.edges_rad_s {
        // Far beyond what the record shows, rates cannot be told from feed-through or from an
        // offset.
        let (least, most) = (1e-4 / (rows as f64 * period_s), REFUSED * PI / period_s);
        let duration_s = rows as f64 * period_s;
        survey.refuse_if(
            first < least || last > most,
            format_args!("lasts {duration_s:.4} s in steps of {period_s:.4} s: a mesh from {first:e} to {last:e} rad/s reaches far beyond what it shows; stay within {least:.1e} to {most:.1e}"),
        )?;
    }
    Ok(())
}

/// Warns of options that this record meets badly.
pub fn warnings(survey: &Survey, options: &IdentifyOptions) -> Vec<String> {
    let fastest = PI / survey.sample_period_s;
    let far = options.constraints.edges_rad_s.filter(|(_, last)| *last > MARKED * fastest);
    let sentence = |(_, last): (f64, f64)| {
        format!(
            "the mesh reaches to {last:.1e} rad/s, but samples every {} s show nothing beyond {fastest:.1e} (π/Ts): its fastest resistances are hardly more than the prior's; lower the last edge",
            tidy(survey.sample_period_s)
        )
    };
    far.map(sentence).into_iter().collect()
}

/// Which input is whose own, where that matters: the order of the columns decides it.
pub fn pairing(survey: &Survey, options: &IdentifyOptions) -> Option<String> {
    let own: Vec<String> =
        survey.inputs.iter().zip(&survey.outputs).map(|(input, output)| format!("`{input}` → `{output}`")).collect();
    options.tie.then(|| {
        format!("own heat, by the order of the columns: {}; every other pair is cross-heating", own.join(", "))
    })
}

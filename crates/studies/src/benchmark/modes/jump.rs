//! A run in which the wind steps, in one operating mode.

use anyhow::{Result, anyhow};
use std::fmt::Write as _;

use host_sim::experiment::Experiment;
use host_sim::instrument::in_process;
use host_sim::run::run;
use recording::toml_file::TomlSource;

use super::compared::{ComparedHead, OperatingMode, WINDS_M_S};

/// Averaged over, s: bits are no reading.
const MEAN_S: f64 = 0.5;
/// Noise of a reading, in codes of the converter.
const NOISE_CODES: f64 = 4.0;
/// Share of the converter's range that a reading at the high level takes at most.
const CONVERTER: f64 = 0.95;
/// Ratio of the high level to what is needed.
const TO_SPARE: f64 = 1.5;
/// Share of the change that counts as there.
const THERE: f64 = 0.9;
/// Means on either side of a time that are averaged again, as a share of the time: bits are noisy,
/// and what is slow can wait.
const EITHER_SIDE: f64 = 0.1;

/// r after the step, and at its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct JumpCourse {
    /// Means of `MEAN_S` from the step on, W/K.
    pub after_w_k: Vec<f64>,
    /// Before the step, W/K.
    pub before_w_k: f64,
}

impl JumpCourse {
    fn change_w_k(&self) -> f64 {
        self.end_w_k() - self.before_w_k
    }

    fn end_w_k(&self) -> f64 {
        let tail = &self.after_w_k[self.after_w_k.len() - self.after_w_k.len() / 10 - 1..];
        tail.iter().sum::<f64>() / tail.len() as f64
    }

    /// Until r, as a mean over a second or a fifth of the time, has made nine tenths of its change,
    /// s.
    pub fn response_s(&self) -> f64 {
        let count = self.after_w_k.len();
        let there = |&k: &usize| {
            let half = 1 + (EITHER_SIDE * k as f64) as usize;
            self.share(&self.after_w_k[k.saturating_sub(half)..(k + half).min(count)]) >= THERE
        };
        MEAN_S * (1..count).find(there).unwrap_or(count) as f64
    }

    /// Rest of the change at a time after the step, as a mean over a third of that time, %.
    pub fn left_percent(&self, time_s: f64) -> f64 {
        let from = ((time_s / MEAN_S) as usize).min(self.after_w_k.len() - 1);
        let to = (from + from / 3 + 1).min(self.after_w_k.len());
        100.0 * (1.0 - self.share(&self.after_w_k[from..to]))
    }

    /// Share of the change that some means have made.
    fn share(&self, means: &[f64]) -> f64 {
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        (mean - self.before_w_k) / self.change_w_k()
    }
}

/// Runs a head in a mode over the step.
///
/// # Errors
/// If it does not run to its end.
pub fn course(compared: &ComparedHead, mode: OperatingMode) -> Result<JumpCourse> {
    let overheat_k = compared.conditions.overheat_k;
    let refuse = |sentence: String| anyhow!("{} at {overheat_k} K: {sentence}", mode.name());
    let source =
        TomlSource { path: compared.head.source.path.with_file_name("modes.toml"), text: text(compared, mode) };
    let experiment = Experiment::of_head(source, compared.head.clone())?;
    let sensor = experiment.sensor().map_err(|error| refuse(error.to_string()))?;
    let instrument = in_process::of_head(compared.head.elements.len(), sensor);
    let gas_c = compared.conditions.temperature_c;
    let mut means: Vec<(f64, f64)> = Vec::new();
    let mut sums = (0.0, vec![(0.0, 0.0); compared.held.len()]);
    let per_mean = (MEAN_S / experiment.sample_period_s).round();
    let summary = run(&experiment, instrument, &mut |row| {
        sums.0 += 1.0;
        for (sum, &i) in sums.1.iter_mut().zip(&compared.held) {
            sum.0 += f64::from(row.power_w[i]);
            sum.1 += f64::from(row.temperature_c[i]) - gas_c;
        }
        if sums.0 >= per_mean {
            means.push((row.time_s, sums.1.iter().map(|(power, rise)| power / rise).sum()));
            sums = (0.0, vec![(0.0, 0.0); compared.held.len()]);
        }
        Ok(())
    });
    let summary = summary.map_err(|error| refuse(error.to_string()))?;
    if let Some(trip) = summary.trips.first() {
        let (time_s, cause, element) = (trip.time_s, trip.cause, &trip.element);
        return Err(refuse(format!("the run tripped after {time_s:.0} s by `{cause}` of {element}")));
    }
    let (before, after): (Vec<_>, Vec<_>) = means.into_iter().partition(|(time_s, _)| *time_s < compared.settle_s);
    let tail = &before[before.len() - before.len() / 10 - 1..];
    Ok(JumpCourse {
        before_w_k: tail.iter().map(|(_, r)| r).sum::<f64>() / tail.len() as f64,
        after_w_k: after.into_iter().map(|(_, r)| r).collect(),
    })
}

/// The experiment.
fn text(compared: &ComparedHead, mode: OperatingMode) -> String {
    let ComparedHead { head, conditions, held, power_w, power_after_w, settle_s, .. } = compared;
    let set_point_c = conditions.set_point_c();
    let mut text = format!(
        "title = \"{}\"\nhead = \"head.toml\"\nsample_period_s = {}\nduration_s = {}\n[gas]\nspecies = \"{}\"\n\
         pressure_pa = {:.3}\ntemperature_c = {:.3}\n[front_end]\nnoise_v_rms = {}\n[drives]\n",
        mode.name(),
        conditions.sample_period_s,
        2.0 * settle_s,
        conditions.species.name(),
        conditions.pressure_pa,
        conditions.temperature_c,
        // A converter that reads the very same code for long counts as broken.
        NOISE_CODES * head.volt_per_code
    );
    let mut currents = String::from("[currents]\n");
    for &i in held {
        let (name, element) = (&head.elements[i].name, &head.elements[i]);
        let resistance_ohm = f64::from(element.config.channel.platinum().resistance_ohm(set_point_c as f32));
        // More than the converter can read would be refused.
        let most_a = CONVERTER * head.full_scale_v / resistance_ohm;
        let current_a = |power_w: f64| (power_w / resistance_ohm).sqrt().min(most_a);
        let (low_a, high_a) = (element.nominal.current_low_a, element.nominal.current_high_a);
        let (drive, [low_a, high_a]) = match mode {
            OperatingMode::Cca => {
                let own_a = current_a(power_w[i]);
                ("{ level = \"high\" }".to_owned(), [low_a.min(0.5 * own_a), own_a])
            }
            // A loop needs some power to spare in the stronger wind, whatever the head was made
            // for.
            OperatingMode::Cta => {
                let enough_a = current_a(TO_SPARE * power_after_w[i]);
                (format!("{{ temperature_c = {set_point_c} }}"), [low_a, high_a.max(enough_a)])
            }
            OperatingMode::Cpa => {
                let enough_a = current_a(TO_SPARE * power_w[i]);
                (format!("{{ power_w = {} }}", power_w[i]), [low_a, high_a.max(enough_a)])
            }
        };
        let _ = writeln!(text, "{name} = {drive}");
        let _ = writeln!(currents, "{name} = {{ low_a = {low_a}, high_a = {high_a} }}");
    }
    text += &currents;
    for (start_s, speed_m_s) in [0.0, *settle_s].into_iter().zip(WINDS_M_S) {
        let _ = write!(
            text,
            "[[wind]]\nstart_s = {start_s:.1}\nlabel = \"{speed_m_s} m/s\"\nspeed_m_s = {speed_m_s}\nazimuth_deg = 180.0\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_order_course_has_its_own_response_and_what_it_leaves() {
        // A time constant of 20 s, and a creep of 10 % with 400 s: 90 % is reached where 0.9 (1 −
        // e^(−t/20)) + 0.1 (1 − e^(−t/400)) is 0.9, at 78.5 s.
        let r = |t: f64| 1.0 + 0.9 * (1.0 - libm::exp(-t / 20.0)) + 0.1 * (1.0 - libm::exp(-t / 400.0));
        let after_w_k: Vec<f64> = (0..8000).map(|k| r(MEAN_S * (f64::from(k) + 0.5))).collect();
        let course = JumpCourse { after_w_k, before_w_k: 1.0 };
        assert!((course.response_s() - 78.5).abs() < 1.0, "{}", course.response_s());
        // From 480 to 640 s 10 % · e^(−1.2 … −1.6) are left, 2.48 % in the mean.
        assert!((course.left_percent(480.0) - 2.48).abs() < 0.05, "{}", course.left_percent(480.0));
    }
}

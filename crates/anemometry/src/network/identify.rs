//! Identification of the whole network from records that drive one element each: every pair with as
//! many free rates as its record can tell apart.
//!
//! In two rounds. The power of the other elements at their low level is little, but not constant:
//! it changes with their resistance, and so with the temperature that the driven element gives
//! them. Left alone it would count as heating by the driven element (0.6 % of the steady gain of a
//! hemisphere of sphere A). So the temperatures that the models of the first round predict for
//! these powers are subtracted before the second:
//!
//! ```text
//! y_j − Σ_{l ≠ i} (H_lj P_l)  =  rest_j + (H_ij P_i) + noise
//! ```
//!
//! whose offset is then the temperature with no heating at all: one value a record, of which the
//! mean is taken.
//!
//! | decided | how |
//! |---|---|
//! | initial state | settled: a record begins with half a minute or so of all elements at their low level |
//! | mesh for the start | 20 rates from 2π/T to 2π/Ts |
//! | rates a pair | the most, up to 4, of which each is known within its half and stands apart from the next by two standard errors; self-heating with no negative resistance, as its ladder needs |
//! | no heating | an element that the driven one moves by less than the noise of a reading, at a rate that cannot be known |
//! | noise of readings | residuals of an element in the records of the others, in which it is at its low level |

use std::path::Path;

use diffusive::identify::record::RecordTable;
use diffusive::identify::{Constraints, DriftGiven, IdentifyOptions, InitialState, Progress, Signs, refine, symbol};
use diffusive::model::merge::merge;
use diffusive::model::{Model, Pair};
use dr_core::model::mesh;
use rayon::prelude::*;
use recording::{POWER, RecordingError, TEMPERATURE};

use super::from_model::residuals;
use super::parameters::NetworkError;
use super::record::QuiescentRecord;

/// Rates of the mesh from which free ones start.
const MESH: usize = 20;
/// A rate of a greater standard error, in units of itself, is not known.
const KNOWN: f64 = 0.5;

/// Greatest numbers of free rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PolesPerPair {
    /// Number of poles of self-heating.
    pub own: usize,
    /// Number of poles of cross-heating.
    pub cross: usize,
}

impl Default for PolesPerPair {
    fn default() -> Self {
        Self { own: 4, cross: 4 }
    }
}

/// Reads record number n.
pub type ReadRecord<'a> = dyn Fn(usize) -> Result<QuiescentRecord, RecordingError> + 'a;

/// Pairs of one record: all temperatures by the driven element's power.
struct IdentificationRound {
    name: String,
    driven: String,
    /// By element.
    models: Vec<Model>,
}

/// Identifies all records and merges their models. `read` reads record number n; it is called
/// several times for each, so that only one record is in memory. The pairs of a record are found
/// side by side on all processors. `progress` counts the pairs of both rounds in place of rows,
/// record by record.
///
/// # Errors
/// Which record or pair has no model, and why.
pub fn identify(
    records: usize,
    read: &ReadRecord<'_>,
    poles: PolesPerPair,
    progress: &mut Progress<'_>,
) -> anyhow::Result<Model> {
    let first = read(0)?;
    all_driven_once(records, read, &first)?;
    let mut rounds: Vec<IdentificationRound> = Vec::new();
    let pairs = |rounds: usize| (rounds * first.elements.len()) as u64;
    for n in 0..records {
        progress("each pair alone", pairs(n), pairs(2 * records));
        rounds.push(first_round(&read(n)?, poles)?);
    }
    let place = |driven: &str| first.elements.iter().position(|name| name == driven);
    let mut second = Vec::new();
    for n in 0..records {
        progress("without others", pairs(records + n), pairs(2 * records));
        second.push(second_round(&read(n)?, &rounds[n], &rounds, poles)?);
    }
    // In the head's order, whatever that of the files was.
    second.sort_by_key(|round| place(&round.driven));
    let mut model = network(&first.elements, second)?;
    model.provenance.conditions = first.conditions;
    Ok(model)
}

/// Checks all records before anything is computed.
fn all_driven_once(records: usize, read: &ReadRecord<'_>, first: &QuiescentRecord) -> anyhow::Result<()> {
    let mut driven: Vec<(String, String)> = Vec::new();
    for n in 0..records {
        let record = read(n)?;
        record.alike(first)?;
        if let Some((first, element)) = driven.iter().find(|(_, element)| element == record.driven_name()) {
            let both = format!("{first} and {} both drive `{element}`", record.name);
            return Err(NetworkError::new(format!("{both}: one of them is enough")).into());
        }
        driven.push((record.name.clone(), record.driven_name().to_owned()));
    }
    let missing = first.elements.iter().filter(|name| driven.iter().all(|(_, element)| element != *name));
    let missing: Vec<&str> = missing.map(String::as_str).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let missing = missing.join(", ");
    Err(NetworkError::new(format!("no record drives {missing}: the network needs one record an element")).into())
}

fn options() -> IdentifyOptions {
    let given = Constraints {
        initial_state: Some(InitialState::Settled),
        feed_through: Some(false),
        delay: Some(0),
        ..Constraints::default()
    };
    // Free rates hold no drift; a mesh with one would only be another start.
    IdentifyOptions { constraints: given, signs: Signs::Any, drift: DriftGiven::None, ..IdentifyOptions::default() }
}

/// A mesh for all temperatures at once, and free rates from it.
fn first_round(record: &QuiescentRecord, poles: PolesPerPair) -> anyhow::Result<IdentificationRound> {
    let mut table = table(record, &(0..record.elements.len()).collect::<Vec<_>>(), &record.temperature_c)?;
    let rows = record.power_w[record.driven].len() as f64;
    let (first, last) = mesh::thesis_edges_rad_s(rows * record.sample_period_s, record.sample_period_s, 1);
    let mut given = options();
    (given.constraints.order, given.constraints.edges_rad_s) = (Some(MESH), Some((first, 2.0 * last)));
    let whole = symbol::identify(&mut table, &given, &mut |_, _, _| {}, &mut |_| {}).map_err(NetworkError::new)?;
    let models = side_by_side(whole.outputs.len(), |output| {
        let of = &whole.outputs[output];
        let pairs = whole.pairs.iter().filter(|pair| pair.output == of.name).cloned().collect();
        let start = Model { outputs: vec![of.clone()], pairs, end: None, warnings: Vec::new(), ..whole.clone() };
        free(record, output, &record.temperature_c[output], &start, poles)
    })?;
    Ok(IdentificationRound { name: record.name.clone(), driven: record.driven_name().to_owned(), models })
}

/// Free rates again, from those of the record's own first round, with the heating by the others'
/// powers subtracted.
fn second_round(
    record: &QuiescentRecord,
    own: &IdentificationRound,
    rounds: &[IdentificationRound],
    poles: PolesPerPair,
) -> anyhow::Result<IdentificationRound> {
    let models = side_by_side(record.elements.len(), |output| {
        let mut alone_c = record.temperature_c[output].clone();
        for round in rounds.iter().filter(|round| round.driven != record.driven_name()) {
            let Some(element) = record.elements.iter().position(|name| *name == round.driven) else { continue };
            let pair = &round.models[output].pairs[0];
            subtract_heating(&mut alone_c, pair, &record.power_w[element], record.sample_period_s);
        }
        let start = &own.models[output];
        let most = start.pairs[0].mesh_rad_s.len();
        let poles = PolesPerPair { own: poles.own.min(most), cross: poles.cross.min(most) };
        free(record, output, &alone_c, start, poles)
    })?;
    Ok(IdentificationRound { name: record.name.clone(), driven: record.driven_name().to_owned(), models })
}

/// A model of every output, on all processors; of several errors the first by output.
fn side_by_side(
    outputs: usize,
    model: impl Fn(usize) -> anyhow::Result<Model> + Sync + Send,
) -> anyhow::Result<Vec<Model>> {
    let found: Vec<_> = (0..outputs).into_par_iter().map(model).collect();
    found.into_iter().collect()
}

/// Subtracts the heating by a power, settled at first.
fn subtract_heating(temperature_c: &mut [f64], pair: &Pair, power_w: &[f64], sample_period_s: f64) {
    let Some(class) = pair.classes.values().next() else { return };
    for (&rate, r) in pair.mesh_rad_s.iter().zip(&class.r_k_per_w) {
        let gain = mesh::gain(rate, sample_period_s);
        let mut x = power_w.first().copied().unwrap_or(0.0);
        for (temperature_c, power_w) in temperature_c.iter_mut().zip(power_w) {
            *temperature_c -= r * x;
            x += gain * (power_w - x);
        }
    }
}

/// Free rates of one temperature: as many as the record can tell apart.
fn free(
    record: &QuiescentRecord,
    output: usize,
    temperature_c: &[f64],
    start: &Model,
    poles: PolesPerPair,
) -> anyhow::Result<Model> {
    let is_own = output == record.driven;
    let most = if is_own { poles.own } else { poles.cross };
    let mut table = table(record, &[output], &[temperature_c.to_vec()])?;
    let accepted = |mut model: Model, reason: String| {
        model.chosen.reasons = vec![reason];
        model.warnings.clear();
        model.supported = true;
        Ok(model)
    };
    let mut why = String::new();
    for count in (1..=most).rev() {
        let found = refine::refine(&mut table, start, count, &options(), &mut |_, _, _| {}, &mut |_| {});
        let problem = match &found {
            Ok(model) => unresolved(&model.pairs[0], is_own),
            Err(error) => Some(error.to_string()),
        };
        match (found, problem) {
            (Ok(model), None) => {
                let (pair, left_mk) = (&model.pairs[0], 1e3 * model.outputs[0].residual_rms);
                let reason = format!("{} → {}: {count} rates, {left_mk:.3} mK left", pair.input, pair.output);
                let reason = if why.is_empty() { reason } else { format!("{reason}; {why}") };
                return accepted(model, reason);
            }
            (Ok(mut model), Some(_))
                if count == 1 && !is_own && swing_k(record, &model) < model.outputs[0].residual_rms =>
            {
                let pair = &mut model.pairs[0];
                pair.classes.values_mut().for_each(|class| class.r_k_per_w.fill(0.0));
                let (from, to) = (&pair.input, &pair.output);
                let reason = format!("{from} → {to}: none, as it is less than the noise of a reading");
                return accepted(model, reason);
            }
            (_, Some(sentence)) => why = format!("not {count}: {sentence}"),
            (Err(error), None) => why = error.to_string(),
        }
    }
    let (from, to) = (record.driven_name(), &record.elements[output]);
    let sentence = format!("how `{from}` heats `{to}` cannot be identified: {why}");
    Err(RecordingError::new(Path::new(&record.name), sentence).into())
}

/// By how much the driven element moves a temperature at most, K.
fn swing_k(record: &QuiescentRecord, model: &Model) -> f64 {
    let powers_w = record.power_w[record.driven].iter();
    let (least_w, most_w) = powers_w.fold((f64::MAX, f64::MIN), |(least, most), w| (least.min(*w), most.max(*w)));
    let resistances = model.pairs[0].classes.values().flat_map(|class| &class.r_k_per_w);
    (most_w - least_w) * resistances.map(|r| r.abs()).sum::<f64>()
}

/// Why the rates of a pair are not resolved; `None` if they are.
fn unresolved(pair: &Pair, is_own: bool) -> Option<String> {
    let rates = &pair.mesh_rad_s;
    let resistances = &pair.classes.values().next()?.r_k_per_w;
    if is_own && let Some(k) = resistances.iter().position(|r| *r <= 0.0) {
        return Some(format!("R_{} is {:.3} K/W", k + 1, resistances[k]));
    }
    let Some(se) = &pair.se_rate_rad_s else { return None };
    let relative: Vec<f64> = se.iter().zip(rates).map(|(se, rate)| se / rate).collect();
    if let Some(k) = relative.iter().position(|relative| relative.is_nan() || *relative >= KNOWN) {
        return Some(format!("the rate at {:.3e} rad/s is known to ±{:.0} % only", rates[k], 100.0 * relative[k]));
    }
    let close = |k: &usize| libm::log(rates[k + 1] / rates[*k]) < 2.0 * libm::hypot(relative[*k], relative[k + 1]);
    let k = (0..rates.len().saturating_sub(1)).find(close)?;
    Some(format!("rates at {:.3e} and {:.3e} rad/s are within twice their standard errors", rates[k], rates[k + 1]))
}

fn table(record: &QuiescentRecord, outputs: &[usize], temperature_c: &[Vec<f64>]) -> Result<RecordTable, NetworkError> {
    let input = (recording::column_name(POWER, record.driven_name()), record.power_w[record.driven].clone());
    let names = outputs.iter().map(|&output| recording::column_name(TEMPERATURE, &record.elements[output]));
    let table =
        RecordTable::new(record.sample_period_s, vec![input], names.zip(temperature_c.iter().cloned()).collect());
    Ok(table.map_err(NetworkError::new)?.named(Path::new(&record.name)))
}

/// One model of all pairs, with the temperatures at rest and the noise of readings at the low
/// level.
fn network(elements: &[String], rounds: Vec<IdentificationRound>) -> Result<Model, NetworkError> {
    let mut pairs = Vec::new();
    for round in &rounds {
        pairs.extend(round.models.iter().map(|model| (round.name.clone(), model.clone())));
    }
    // A head of one element has one pair.
    let mut model = match &pairs[..] {
        [(_, only)] => only.clone(),
        pairs => merge(pairs).map_err(NetworkError::new)?,
    };
    for (j, name) in elements.iter().enumerate() {
        let column = recording::column_name(TEMPERATURE, name);
        let Some(output) = model.outputs.iter_mut().find(|output| output.name == column) else { continue };
        let rests: Vec<f64> = rounds.iter().map(|round| round.models[j].outputs[0].offset_c).collect();
        let mean = rests.iter().sum::<f64>() / rests.len() as f64;
        let apart = rests.iter().map(|rest| (rest - mean).abs()).fold(0.0, f64::max);
        let others = rounds.iter().filter(|round| round.driven != *name);
        let others: Vec<f64> = others.map(|round| round.models[j].outputs[0].residual_rms).collect();
        output.offset_c = mean;
        output.se_offset_c = apart;
        if !others.is_empty() {
            output.residual_rms = (others.iter().map(|rms| rms * rms).sum::<f64>() / others.len() as f64).sqrt();
            let own = rounds.iter().find(|round| round.driven == *name).map(|round| &round.models[j].outputs[0]);
            model.warnings.extend(own.and_then(|own| residuals(name, own.residual_rms, output.residual_rms)));
        }
    }
    model.supported &= model.warnings.is_empty();
    model.offset_c = model.outputs[0].offset_c;
    model.residual_rms = model.outputs[0].residual_rms;
    model.chosen.reasons = pairs.iter().flat_map(|(_, model)| model.chosen.reasons.clone()).collect();
    // A record counts once, not once a pair.
    model.provenance.records = rounds.iter().map(|round| round.name.clone()).collect();
    let per_record =
        |of: &dyn Fn(&Model) -> f64| rounds.iter().filter_map(|round| round.models.first()).map(of).sum::<f64>();
    model.provenance.rows = per_record(&|model| model.provenance.rows as f64) as u64;
    model.provenance.duration_s = per_record(&|model| model.provenance.duration_s);
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body of 1 K/W and 5 s that is driven at random, at 10 Hz with 1 mK of noise.
    fn record() -> QuiescentRecord {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / 16_777_216.0
        };
        let (mut power_w, mut temperature_c) = (Vec::new(), Vec::new());
        let (mut heat_w, mut rise_k) = (0.0, 0.0);
        for row in 0..4000 {
            if row >= 300 && row % 20 == 0 {
                heat_w = if random() < 0.5 { 1.0 } else { 0.0 };
            }
            power_w.push(heat_w);
            temperature_c.push(20.0 + rise_k + 2e-3 * (random() - 0.5));
            rise_k += (1.0 - libm::exp(-0.02)) * (heat_w - rise_k);
        }
        QuiescentRecord {
            name: "r.csv".to_owned(),
            head: None,
            conditions: None,
            sample_period_s: 0.1,
            elements: vec!["film".to_owned()],
            driven: 0,
            power_w: vec![power_w],
            temperature_c: vec![temperature_c],
        }
    }

    #[test]
    fn progress_counts_the_pairs_of_both_rounds() {
        let mut seen = Vec::new();
        let mut show = |_: &'static str, done, all| seen.push((done, all));
        let model = identify(1, &|_| Ok(record()), PolesPerPair::default(), &mut show).unwrap();
        assert_eq!(seen, [(0, 2), (1, 2)]);
        let gain = model.pairs[0].classes.values().next().unwrap().steady_gain_k_per_w;
        // 3700 rows of 0.6 mK around 0.5 K.
        assert!((gain - 1.0).abs() < 1e-3, "{gain}");
    }

    const PERIOD_S: f64 = 0.1;
    const ROWS: usize = 20_000;

    /// Record of two elements, one driven by bits of four rows: it has 100 K/W at 0.1 rad/s, and
    /// warms the other by `cross_k_per_w` at 0.05 rad/s. Readings have 2 mK of noise.
    fn record_of_two(driven: usize, cross_k_per_w: f64) -> QuiescentRecord {
        let mut bits = dr_core::signal::Prbs::new(11, 77).unwrap();
        let (mut random, mut bit) = (1_u64, false);
        let mut noise_k = || {
            let sum: f64 = (0..12)
                .map(|_| {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (random >> 11) as f64 / (1_u64 << 53) as f64
                })
                .sum();
            2e-3 * (sum - 6.0)
        };
        let (mut own, mut cross) = (0.0, 0.0);
        let (mut power_w, mut temperature_c) = (vec![Vec::new(); 2], vec![Vec::new(); 2]);
        for row in 0..ROWS {
            if row % 4 == 0 {
                bit = row >= 300 && bits.step();
            }
            let w = if bit { 0.1 } else { 1e-3 };
            if row == 0 {
                (own, cross) = (w, w);
            }
            temperature_c[driven].push(20.0 + 100.0 * own + noise_k());
            temperature_c[1 - driven].push(20.0 + 100.0 * 1e-3 + cross_k_per_w * cross + noise_k());
            power_w[driven].push(w);
            power_w[1 - driven].push(1e-3);
            own += mesh::gain(0.1, PERIOD_S) * (w - own);
            cross += mesh::gain(0.05, PERIOD_S) * (w - cross);
        }
        QuiescentRecord {
            name: format!("record of {driven}"),
            head: None,
            conditions: None,
            sample_period_s: PERIOD_S,
            elements: vec!["film1".to_owned(), "film2".to_owned()],
            driven,
            power_w,
            temperature_c,
        }
    }

    #[test]
    fn readings_that_jump_with_the_level_are_noticed() {
        let model = |jump_k: f64| {
            let read = |n: usize| {
                let mut record = record_of_two(n, 1.0);
                for row in 1..ROWS {
                    if record.power_w[n][row - 1] > 0.05 {
                        record.temperature_c[n][row] += jump_k;
                    }
                }
                Ok(record)
            };
            identify(2, &read, PolesPerPair { own: 2, cross: 2 }, &mut |_, _, _| {}).unwrap()
        };
        assert!(model(0.0).supported);
        let off = model(-0.05);
        assert!(!off.supported && off.warnings[0].starts_with("film1: its record leaves "), "{:?}", off.warnings);
    }

    #[test]
    fn elements_that_do_not_warm_each_other_have_no_cross_heating() {
        let model = |cross_k_per_w: f64| {
            let read = |n: usize| Ok(record_of_two(n, cross_k_per_w));
            identify(2, &read, PolesPerPair { own: 2, cross: 2 }, &mut |_, _, _| {}).unwrap()
        };
        let r = |model: &Model, from: &str, to: &str| {
            let pair = model.pair(&format!("power_w_{from}"), &format!("temperature_c_{to}")).unwrap();
            pair.classes.values().flat_map(|class| &class.r_k_per_w).sum::<f64>()
        };
        let apart = model(0.0);
        assert_eq!((r(&apart, "film1", "film2"), r(&apart, "film2", "film1")), (0.0, 0.0));
        assert!((r(&apart, "film1", "film1") / 100.0 - 1.0).abs() < 1e-3);
        // An error far below a reading's noise is found.
        let near = model(0.05);
        assert!((r(&near, "film1", "film2") / 0.05 - 1.0).abs() < 0.1, "{}", r(&near, "film1", "film2"));
    }
}

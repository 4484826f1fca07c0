//! Models of sums that were gathered part by part, against those of the record in one go.

use std::ops::Range;

use dr_core::model::mesh;

use super::identify_parts;
use super::place::PartPlace;
use super::plan::GramPlan;
use super::summed::SummedRows;
use crate::identify::record::{Block, RecordTable, Selection, read_all};
use crate::identify::{Constraints, DriftGiven, DriftKind, IdentifyOptions, InitialState, Signs, identify};
use crate::model::{Model, RecordEnd};

const PERIOD_S: f64 = 0.1;
/// Resistance, K/W, and time constant, s.
const BODY: [(f64, f64); 3] = [(6.0, 0.4), (14.0, 5.0), (8.0, 60.0)];

/// A rig of two elements that heat each other.
struct Rig {
    power_w: [Vec<f64>; 2],
    temperature_c: [Vec<f64>; 2],
    gas_c: Vec<f64>,
    label: Vec<&'static str>,
    /// Rows with which later segments begin.
    begins: Vec<usize>,
}

struct Random(u64);

impl Random {
    /// Between 0 and 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn noise(&mut self) -> f64 {
        (0..6).map(|_| self.next()).sum::<f64>() - 3.0
    }
}

/// `walk_k`: what the room moves by from row to row; `late`: rows by which the answer comes late.
fn rig(rows: usize, walk_k: f64, late: usize) -> Rig {
    let mut random = Random(11);
    let mut rig = Rig {
        power_w: [Vec::new(), Vec::new()],
        temperature_c: [Vec::new(), Vec::new()],
        gas_c: Vec::new(),
        label: Vec::new(),
        begins: Vec::new(),
    };
    let (mut x, mut bits, mut room_k) = ([[0.3; 3]; 2], [0.0; 2], 0.0);
    for row in 0..rows {
        if row % 15 == 0 {
            bits = [(); 2].map(|()| if random.next() > 0.5 { 0.2 } else { 0.05 });
        }
        room_k += walk_k * random.noise();
        for (element, power_w) in rig.power_w.iter_mut().enumerate() {
            power_w.push(bits[element]);
            let rise = |of: usize| BODY.iter().zip(x[of]).map(|((r, _), x)| r * x).sum::<f64>();
            let rise_k = rise(element) + 0.3 * rise(1 - element);
            rig.temperature_c[element].push(21.0 + rise_k + room_k + 0.004 * random.noise());
        }
        rig.gas_c.push(20.0 + (row as f64 * PERIOD_S / 70.0).sin());
        rig.label.push(if row / 700 % 2 == 0 { "calm" } else { "wind" });
        for (element, x) in x.iter_mut().enumerate() {
            let heat_w = row.checked_sub(late).map_or(0.0, |row| rig.power_w[element][row]);
            for ((_, time_s), x) in BODY.iter().zip(x) {
                *x += mesh::gain(1.0 / time_s, PERIOD_S) * (heat_w - *x);
            }
        }
    }
    rig
}

/// Which columns a table has.
#[derive(Clone, Copy, Default)]
struct Has {
    second: bool,
    gas: bool,
    events: bool,
}

impl Rig {
    fn table(&self, rows: Range<usize>, has: Has) -> RecordTable {
        let columns = |name: &str, of: &[Vec<f64>; 2]| -> Vec<(String, Vec<f64>)> {
            let all = of.iter().enumerate().take(1 + usize::from(has.second));
            all.map(|(at, values)| (format!("{name}{at}"), values[rows.clone()].to_vec())).collect()
        };
        let table = RecordTable::new(PERIOD_S, columns("power", &self.power_w), columns("t", &self.temperature_c));
        let mut table = table.unwrap().starting_at(rows.start as f64 * PERIOD_S);
        if has.gas {
            table = table.with_gas(&self.gas_c[rows.clone()]).unwrap();
        }
        let begins = self.begins.iter().filter(|row| rows.start < **row && **row < rows.end);
        let begins: Vec<usize> = begins.map(|row| row - rows.start).collect();
        let table = if has.events { table.with_events(&self.label[rows]).unwrap() } else { table };
        table.with_segments(&begins)
    }

    /// Recordings of the same body: some of the rows, one stretch after the other.
    fn recordings(&self, stretches: &[Range<usize>]) -> Self {
        let of = |values: &Vec<f64>| -> Vec<f64> {
            stretches.iter().flat_map(|rows| values[rows.clone()].to_vec()).collect()
        };
        let label = stretches.iter().flat_map(|rows| self.label[rows.clone()].to_vec()).collect();
        let lengths = stretches.iter().scan(0, |row, stretch| {
            *row += stretch.len();
            Some(*row)
        });
        Self {
            power_w: self.power_w.each_ref().map(of),
            temperature_c: self.temperature_c.each_ref().map(of),
            gas_c: of(&self.gas_c),
            label,
            begins: lengths.take(stretches.len() - 1).collect(),
        }
    }

    fn rows(&self) -> usize {
        self.gas_c.len()
    }
}

/// Places of so many cuts, at random; no part has fewer than two rows, as a table must have.
fn cuts(rows: usize, count: usize, random: &mut Random) -> Vec<usize> {
    let mut cuts: Vec<usize> =
        (0..count).map(|_| 2 * (1 + (random.next() * (rows as f64 / 2.0 - 2.0)) as usize)).collect();
    cuts.extend([0, rows]);
    cuts.sort_unstable();
    cuts.dedup();
    cuts
}

fn whole(rig: &Rig, has: Has, options: &IdentifyOptions) -> Model {
    identify(&mut rig.table(0..rig.rows(), has), options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

/// The model of parts that are joined as a tree, in whatever order. `table`: of some of the rows.
fn parted(
    table: &dyn Fn(Range<usize>) -> RecordTable,
    options: &IdentifyOptions,
    cuts: &[usize],
    random: &mut Random,
) -> Model {
    let parts: Vec<Range<usize>> = cuts.windows(2).map(|pair| pair[0]..pair[1]).collect();
    let places = parts.iter().map(place).collect();
    let mut all = table(0..cuts[cuts.len() - 1]);
    let (plan, starts) = GramPlan::of(&mut all, Selection::default(), places, options, &mut |_, _, _| {}).unwrap();
    let sum = |(at, rows): (usize, &Range<usize>)| {
        plan.sum(&mut table(rows.clone()), &starts, at, &mut |_, _, _| {}).unwrap()
    };
    let mut sums: Vec<SummedRows> = parts.iter().enumerate().map(sum).collect();
    let designs = plan.designs().unwrap();
    while sums.len() > 1 {
        let at = (random.next() * (sums.len() - 1) as f64) as usize;
        let behind = sums.remove(at + 1);
        let before = sums.remove(at);
        sums.insert(at, designs.join(before, behind).unwrap());
    }
    identify_parts(&plan, sums.remove(0), &mut |_, _, _| {}).unwrap()
}

fn place(rows: &Range<usize>) -> PartPlace {
    PartPlace {
        path: format!("part-{}", rows.start).into(),
        first_row: rows.start as u64,
        rows: rows.len() as u64,
        first_time_s: rows.start as f64 * PERIOD_S,
        last_time_s: (rows.end - 1) as f64 * PERIOD_S,
        checksum: 0,
    }
}

/// Greatest distance of two lists, in units of the greatest value.
fn apart(one: impl Iterator<Item = f64>, other: impl Iterator<Item = f64>) -> f64 {
    let (mut apart, mut greatest) = (0.0_f64, f64::MIN_POSITIVE);
    for (one, other) in one.zip(other) {
        apart = apart.max((one - other).abs());
        greatest = greatest.max(one.abs());
    }
    apart / greatest
}

fn values(model: &Model) -> impl Iterator<Item = f64> {
    let classes = model.pairs.iter().flat_map(|pair| pair.classes.values());
    classes.flat_map(|class| class.r_k_per_w.iter().copied())
}

fn errors(model: &Model) -> impl Iterator<Item = f64> {
    let classes = model.pairs.iter().flat_map(|pair| pair.classes.values());
    classes.flat_map(|class| class.se_k_per_w.iter().copied().chain([class.se_steady_gain_k_per_w]))
}

fn assert_same(parts: &Model, whole: &Model, of_segments: usize, what: &str) {
    let (r, se) = (apart(values(parts), values(whole)), apart(errors(parts), errors(whole)));
    println!("{what}: R {r:.1e}, se {se:.1e}");
    let meshes = |model: &Model| model.pairs.iter().map(|pair| pair.mesh_rad_s.clone()).collect::<Vec<_>>();
    assert_eq!(meshes(parts), meshes(whole), "{what}");
    assert_eq!(parts.chosen.reasons, whole.chosen.reasons, "{what}");
    assert_eq!(parts.warnings, whole.warnings, "{what}");
    // The bar of the whole thing.
    assert!(r < 1e-9 && se < 1e-9, "{what}: R {r:.1e}, se {se:.1e}");
    // Squares of what is left are differences of squares some 1e8 times as great; what later
    // segments began with is a sum of decays some 1e3 times as great, and a filter's of 1e5.
    let bar = if of_segments > 1 { 1e-4 } else { 1e-7 };
    let mut most = [0.0_f64; 2];
    for (one, other) in parts.outputs.iter().zip(&whole.outputs) {
        let part = |one: f64, other: f64| (one - other).abs() / other.abs().max(1e-9);
        assert!(part(one.offset_c, other.offset_c) <= 1e-9, "{what}");
        assert!(part(one.spread_rms.unwrap(), other.spread_rms.unwrap()) <= 1e-9, "{what}");
        let (rms, fit) = (part(one.residual_rms, other.residual_rms), part(one.fit_percent, other.fit_percent));
        let (one, other) = (one.whiteness.as_ref().unwrap(), other.whiteness.as_ref().unwrap());
        let of_lags = apart(one.autocorrelation.iter().copied(), other.autocorrelation.iter().copied());
        let inflation = part(one.inflation, other.inflation);
        most = [most[0].max(rms).max(fit), most[1].max(of_lags).max(inflation)];
    }
    println!("{what}: residual rms {:.1e}, autocorrelation {:.1e}", most[0], most[1]);
    assert!(most[0] < bar && most[1] < if of_segments > 1 { bar } else { 1e-5 }, "{what}");
    let (one, other) = (parts.end.as_ref().unwrap(), whole.end.as_ref().unwrap());
    assert_eq!((&one.pending, &one.pending_class), (&other.pending, &other.pending_class), "{what}");
    assert!((one.next_time_s - other.next_time_s).abs() < 1e-9 * other.next_time_s);
    let ends = apart(decayed(one).into_iter(), decayed(other).into_iter());
    let rms = whole.outputs.iter().map(|output| output.residual_rms).fold(f64::MAX, f64::min);
    let next = (decayed(one).iter().zip(decayed(other)).take(whole.outputs.len()))
        .fold(0.0_f64, |most, (one, other)| most.max((one - other).abs()));
    println!("{what}: end {ends:.1e} of the largest, {:.1e} of the residual", next / rms);
    // What a later segment began with is known to half of the digits only.
    assert!(if of_segments > 1 { ends < 1e-2 && next < 1e-2 * rms } else { ends < 1e-8 }, "{what}");
}

/// What all outputs decay to behind the record, from its next row to long after: of decays so close
/// that others are sums of them only that is known.
fn decayed(end: &RecordEnd) -> Vec<f64> {
    let at = |time_s: f64| {
        let of =
            move |decays: &Vec<(f64, f64)>| -> f64 { decays.iter().map(|(rate, k)| k * (-rate * time_s).exp()).sum() };
        end.decays.iter().map(of)
    };
    [0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0].into_iter().flat_map(at).collect()
}

fn compare(rig: &Rig, has: Has, options: &IdentifyOptions, counts: &[usize], what: &str) {
    let whole = whole(rig, has, options);
    let mut random = Random(3);
    for &count in counts {
        let cuts = cuts(rig.rows(), count, &mut random);
        let parts = parted(&|rows| rig.table(rows, has), options, &cuts, &mut random);
        assert_same(&parts, &whole, 1 + rig.begins.len(), &format!("{what}, {count} cuts"));
    }
}

#[test]
fn sums_of_parts_make_the_model_of_the_whole_without_drift() {
    let options = IdentifyOptions { drift: DriftGiven::None, ..IdentifyOptions::default() };
    compare(&rig(6000, 0.0, 0), Has::default(), &options, &[1, 7, 64], "one element");
}

#[test]
fn sums_of_parts_make_the_model_of_the_whole_with_a_room_that_drifts() {
    let (rig, has) = (rig(6000, 0.002, 0), Has { second: true, ..Has::default() });
    compare(&rig, has, &IdentifyOptions::default(), &[1, 7, 64], "two elements, drift");
}

#[test]
fn sums_of_parts_of_a_late_answer_make_the_model_of_the_whole() {
    let options = IdentifyOptions { signs: Signs::AllPositive, ..IdentifyOptions::default() };
    compare(&rig(6000, 0.002, 9), Has::default(), &options, &[1, 64, 700], "late answer");
}

#[test]
fn sums_of_parts_make_the_model_of_the_whole_with_surroundings_and_with_events() {
    let rig = rig(6000, 0.0, 2);
    let ambient = IdentifyOptions { follow_ambient: true, ..IdentifyOptions::default() };
    compare(&rig, Has { gas: true, ..Has::default() }, &ambient, &[1, 40], "surroundings");
    let (initial_state, delay) = (Some(InitialState::Rest), Some(2));
    let constraints = Constraints { initial_state, delay, feed_through: Some(false), ..Constraints::default() };
    let drift = DriftGiven::Kind(DriftKind::Correlated);
    let events = IdentifyOptions { constraints, drift, ..IdentifyOptions::default() };
    compare(&rig, Has { events: true, second: true, ..Has::default() }, &events, &[40], "events");
}

#[test]
fn sums_of_parts_of_several_recordings_make_the_model_of_them_all() {
    let none = IdentifyOptions { drift: DriftGiven::None, ..IdentifyOptions::default() };
    let still = rig(9000, 0.0, 0).recordings(&[100..2600, 3000..3999, 4500..7001, 7300..9000]);
    compare(&still, Has::default(), &none, &[1, 7, 64], "recordings");
    let moved = rig(9000, 0.002, 0).recordings(&[0..2500, 2800..3250, 4001..6000, 7000..9000]);
    let options = IdentifyOptions::default();
    compare(&moved, Has { second: true, ..Has::default() }, &options, &[1, 7, 64], "recordings, drift");
}

#[test]
fn sums_of_parts_with_many_short_segments_make_the_model_of_the_whole() {
    let lengths = [700, 33, 250, 1, 90, 128, 5, 1000, 12, 400, 64, 300, 129, 2, 800, 41, 500];
    let stretches = |from: usize| {
        let next = |row: &mut usize, rows: usize| {
            *row += rows + 40;
            Some(*row - rows..*row)
        };
        lengths.into_iter().scan(from, move |row, rows| next(row, rows)).collect::<Vec<_>>()
    };
    let options = IdentifyOptions::default();
    compare(&rig(9000, 0.002, 0).recordings(&stretches(0)), Has::default(), &options, &[1, 7, 64], "gaps");
    let late = rig(9000, 0.002, 9).recordings(&stretches(20));
    compare(&late, Has { second: true, ..Has::default() }, &options, &[3, 40], "gaps, late answer");
}

#[test]
fn sums_of_parts_of_several_recordings_follow_surroundings_events_and_known_initial_states() {
    let stretches = [0..2000, 2500..4100, 5000..7777, 8000..8900];
    let ambient = IdentifyOptions { follow_ambient: true, ..IdentifyOptions::default() };
    let still = rig(9000, 0.0, 2).recordings(&stretches);
    compare(&still, Has { gas: true, ..Has::default() }, &ambient, &[1, 40], "recordings, surroundings");
    let (initial_state, delay) = (Some(InitialState::Rest), Some(2));
    let constraints = Constraints { initial_state, delay, feed_through: Some(false), ..Constraints::default() };
    let drift = DriftGiven::Kind(DriftKind::Correlated);
    let events = IdentifyOptions { constraints, drift, ..IdentifyOptions::default() };
    let has = Has { events: true, second: true, ..Has::default() };
    compare(&still, has, &events, &[40], "recordings, events, drift");
    let events = IdentifyOptions { drift: DriftGiven::None, ..events };
    compare(&still, has, &events, &[7], "recordings, events");
    let settled = Constraints { initial_state: Some(InitialState::Settled), ..Constraints::default() };
    let integrated = DriftGiven::Kind(DriftKind::IntegratedWalk);
    let options = IdentifyOptions { constraints: settled, drift: integrated, ..IdentifyOptions::default() };
    let moved = rig(9000, 0.002, 0).recordings(&stretches);
    compare(&moved, Has::default(), &options, &[40], "recordings, settled");
}

/// Rows of a part that was changed since the plan was made.
#[test]
fn a_part_that_was_changed_is_not_summed() {
    let (mut rig, has) = (rig(2000, 0.0, 0), Has::default());
    let (parts, options) = (vec![place(&(0..700)), place(&(700..2000))], IdentifyOptions::default());
    let mut all = rig.table(0..2000, has);
    let (plan, starts) = GramPlan::of(&mut all, Selection::default(), parts, &options, &mut |_, _, _| {}).unwrap();
    let sum =
        |rig: &Rig, at: usize, rows: Range<usize>| plan.sum(&mut rig.table(rows, has), &starts, at, &mut |_, _, _| {});
    let (first, second) = (sum(&rig, 0, 0..700).unwrap(), sum(&rig, 1, 700..2000).unwrap());
    let designs = plan.designs().unwrap();
    assert!(designs.join(first, second).is_some());
    rig.power_w[0][300] += 1e-9;
    let refused = sum(&rig, 0, 0..700).unwrap_err().to_string();
    assert!(refused.contains("was changed since the plan was made"), "{refused}");
}

/// Records of rigs that nobody tuned this on: their values on uniform times.
#[test]
fn sums_of_parts_of_measured_records_make_the_models_of_the_whole() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/more");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: {} is absent", folder.display());
        return;
    };
    let mut random = Random(8);
    for path in entries.map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let (survey, rows, _) = read_all(&path, &Selection::default()).unwrap();
        if survey.segments > 1 || !rows.missing.is_empty() {
            continue;
        }
        let (count, block) = (rows.len(), &rows);
        let of = |rows: Range<usize>| RecordTable::part(&survey, block, rows);
        let options = IdentifyOptions::default();
        let whole = identify(&mut of(0..count), &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
        let cuts = cuts(count, 7, &mut random);
        assert_same(&parted(&of, &options, &cuts, &mut random), &whole, 1, &name);
    }
}

/// Recordings of one head each, one after the other, with a gap in the midst of each.
#[test]
fn sums_of_parts_of_measured_recordings_make_the_models_of_them_all() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/more");
    let heads = [
        vec!["hal_semi30_T1", "hal_semi60_T1", "hal_val_T1"],
        vec!["hal_val_T2", "hal_semi60_T2"],
        vec!["luca_semi60_T1", "luca_val_T1", "luca_semi30_T1"],
        vec!["luca_sine1_T1", "luca_sine2_T1"],
        vec!["luca_val_T2", "luca_semi60_T2"],
        vec!["sbhs_prbs2", "sbhs_sine", "sbhs_ramp", "sbhs_step"],
    ];
    let mut random = Random(8);
    for names in heads {
        let (mut all, mut begins, mut of_head) = (Block::default(), Vec::new(), None);
        for name in &names {
            let path = folder.join(format!("{name}.csv"));
            if !path.exists() {
                println!("skipped: {} is absent", path.display());
                return;
            }
            let (survey, rows, _) = read_all(&path, &Selection::default()).unwrap();
            let (middle, end) = (rows.len() / 2, rows.len());
            for stretch in [0..middle, middle + 7..end] {
                begins.push(all.len());
                all.append(&rows.rows(stretch));
            }
            of_head.get_or_insert(survey);
        }
        let (survey, what) = (of_head.unwrap(), names.join(" + "));
        let of = |rows: Range<usize>| {
            let own: Vec<usize> =
                begins.iter().filter(|at| rows.start < **at && **at < rows.end).map(|at| at - rows.start).collect();
            RecordTable::part(&survey, &all, rows).with_segments(&own)
        };
        let options = IdentifyOptions::default();
        let whole = identify(&mut of(0..all.len()), &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
        for count in [1, 7, 64] {
            let cuts = cuts(all.len(), count, &mut random);
            let parts = parted(&of, &options, &cuts, &mut random);
            assert_same(&parts, &whole, begins.len(), &format!("{what}, {count} cuts"));
        }
    }
}

//! Models of sums that were gathered part by part, against those of the record in one go.

use std::ops::Range;

use dr_core::model::mesh;

use super::identify_parts;
use super::plan::{GramPlan, PartPlace};
use super::summed::SummedRows;
use crate::identify::record::{RecordTable, Selection, read_all};
use crate::identify::{Constraints, DriftGiven, DriftKind, IdentifyOptions, InitialState, Signs, identify};
use crate::model::Model;

const PERIOD_S: f64 = 0.1;
/// Resistance, K/W, and time constant, s.
const BODY: [(f64, f64); 3] = [(6.0, 0.4), (14.0, 5.0), (8.0, 60.0)];

/// A rig of two elements that heat each other.
struct Rig {
    power_w: [Vec<f64>; 2],
    temperature_c: [Vec<f64>; 2],
    gas_c: Vec<f64>,
    label: Vec<&'static str>,
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
        if has.events { table.with_events(&self.label[rows]).unwrap() } else { table }
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

fn assert_same(parts: &Model, whole: &Model, what: &str) {
    let (r, se) = (apart(values(parts), values(whole)), apart(errors(parts), errors(whole)));
    println!("{what}: R {r:.1e}, se {se:.1e}");
    let meshes = |model: &Model| model.pairs.iter().map(|pair| pair.mesh_rad_s.clone()).collect::<Vec<_>>();
    assert_eq!(meshes(parts), meshes(whole), "{what}");
    assert_eq!(parts.chosen.reasons, whole.chosen.reasons, "{what}");
    assert_eq!(parts.warnings, whole.warnings, "{what}");
    // The bar of the whole thing.
    assert!(r < 1e-9 && se < 1e-9, "{what}: R {r:.1e}, se {se:.1e}");
    for (one, other) in parts.outputs.iter().zip(&whole.outputs) {
        let near = |one: f64, other: f64, part: f64| {
            assert!((one - other).abs() <= part * other.abs().max(1e-9), "{what}: {one} for {other}")
        };
        near(one.offset_c, other.offset_c, 1e-9);
        near(one.residual_rms, other.residual_rms, 1e-7);
        near(one.fit_percent, other.fit_percent, 1e-7);
        near(one.spread_rms.unwrap(), other.spread_rms.unwrap(), 1e-9);
        let (one, other) = (one.whiteness.as_ref().unwrap(), other.whiteness.as_ref().unwrap());
        let of_lags = apart(one.autocorrelation.iter().copied(), other.autocorrelation.iter().copied());
        // Squares of what is left are differences of squares some 1e8 times as great.
        assert!(of_lags < 1e-5, "{what}: autocorrelation {of_lags:.1e}");
        near(one.inflation, other.inflation, 1e-5);
    }
    let (one, other) = (parts.end.as_ref().unwrap(), whole.end.as_ref().unwrap());
    assert_eq!((&one.pending, &one.pending_class), (&other.pending, &other.pending_class), "{what}");
    assert!((one.next_time_s - other.next_time_s).abs() < 1e-9 * other.next_time_s);
    let decays = |end: &crate::model::RecordEnd| end.decays.iter().flatten().map(|decay| decay.1).collect::<Vec<_>>();
    assert!(apart(decays(one).into_iter(), decays(other).into_iter()) < 1e-8, "{what}");
}

fn compare(rig: &Rig, has: Has, options: &IdentifyOptions, counts: &[usize], what: &str) {
    let whole = whole(rig, has, options);
    let mut random = Random(3);
    for &count in counts {
        let cuts = cuts(rig.rows(), count, &mut random);
        let parts = parted(&|rows| rig.table(rows, has), options, &cuts, &mut random);
        assert_same(&parts, &whole, &format!("{what}, {count} cuts"));
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
        assert_same(&parted(&of, &options, &cuts, &mut random), &whole, &name);
    }
}

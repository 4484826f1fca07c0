//! Files damaged at random, thousands of each kind: whatever comes out is checked data or an error of one line, never a panic.
//!
//! The damage is drawn from a fixed seed, so a failure can be repeated; what failed is named by its number.

use std::collections::BTreeMap;
use std::path::Path;

use host_sim::identify::record::{RecordError, Selection, Source as _, Stream};
use host_sim::model::{
    Chosen, Class, End, Estimate, FORMAT, Followed, Following, Gas, Model, Output, Pair, Provenance, Structure,
    VERSION, Whiteness, Wind,
};
use host_sim::recording::{Layout, Metadata, RecordingWriter, Row};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// Damaged files of each kind: together they take some seconds.
const FILES: usize = 3_000;

/// What tables and JSON stumble over.
const TOKENS: [&str; 30] = [
    "",
    "1e999",
    "-1e308",
    "1e308",
    "nan",
    "inf",
    "-0",
    "0",
    "1e-320",
    "99999999999999999999",
    "-1",
    "0x10",
    "\"",
    "\"\"",
    ",",
    ";",
    "\n",
    "\r\n",
    "\r",
    "#",
    "# a: b\n",
    "\0",
    "\u{feff}",
    "é",
    "null",
    "[]",
    "{}",
    "true",
    "time_s",
    "power_w:",
];

struct Damage(ChaCha8Rng);

impl Damage {
    fn below(&mut self, end: usize) -> usize {
        (self.0.next_u64() % end.max(1) as u64) as usize
    }

    /// One to four faults in a file.
    fn of(&mut self, whole: &[u8]) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        for _ in 0..=self.below(4) {
            let at = self.below(bytes.len());
            match self.below(9) {
                0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
                1 if !bytes.is_empty() => bytes[at] = self.below(256) as u8,
                2 => bytes.truncate(at),
                3 => {
                    // A piece goes missing.
                    let to = bytes.len().min(at + self.below(64));
                    bytes.drain(at.min(to)..to);
                }
                4 => self.lines(&mut bytes, b'\n'),
                5 => self.lines(&mut bytes, b','),
                6 => {
                    let token = TOKENS[self.below(TOKENS.len())];
                    bytes.splice(at..at, token.bytes());
                }
                _ => self.field(&mut bytes),
            }
        }
        bytes
    }

    /// Doubles, removes or swaps what stands between separators: lines of a table or its fields.
    fn lines(&mut self, bytes: &mut Vec<u8>, separator: u8) {
        let mut parts: Vec<&[u8]> = bytes.split(|&byte| byte == separator).collect();
        let (a, b) = (self.below(parts.len()), self.below(parts.len()));
        match self.below(3) {
            0 => parts.insert(b, parts[a]),
            1 => drop(parts.remove(a)),
            _ => parts.swap(a, b),
        }
        *bytes = parts.join(&separator);
    }

    /// Puts something else in the place of a field or a value.
    fn field(&mut self, bytes: &mut Vec<u8>) {
        let ends = |byte: &u8| b",\n:[]{} ".contains(byte);
        let at = self.below(bytes.len());
        let from = bytes[..at].iter().rposition(ends).map_or(0, |before| before + 1);
        let to = bytes[at..].iter().position(ends).map_or(bytes.len(), |after| at + after);
        let token = TOKENS[self.below(TOKENS.len())];
        bytes.splice(from.min(to)..to, token.bytes());
    }
}

fn assert_one_line(sentence: &str, number: usize) {
    assert!(!sentence.is_empty() && !sentence.contains(char::is_control), "file {number}: {sentence:?}");
}

/// Reads a record twice; what passes must keep what [`Stream`] promises.
fn read(path: &Path, selection: &Selection) -> Result<(), RecordError> {
    let mut stream = Stream::open(path, selection)?;
    for _ in 0..2 {
        let mut rows = 0;
        while let Some(block) = stream.next_block()? {
            assert_eq!(block.first_row, rows);
            rows += block.len() as u64;
            let columns = block.inputs.iter().chain(&block.outputs);
            for column in columns.chain(Some(&block.gas).filter(|gas| !gas.is_empty())) {
                assert_eq!(column.len(), block.len());
                assert!(column.iter().all(|value| value.is_finite()));
            }
            let classes = block.class.clone();
            assert!(classes.iter().all(|&class| (class as usize) < stream.classes().len()));
        }
        let survey = stream.survey();
        assert!(rows >= 2 && survey.rows == rows && !survey.inputs.is_empty() && !survey.outputs.is_empty());
        assert!(survey.sample_period_s > 0.0 && survey.last_time_s > survey.first_time_s);
        stream.restart()?;
    }
    Ok(())
}

/// Damages a recording again and again; returns how many were still read.
fn damaged(name: &str, whole: &[u8], seed: u64) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let named = Selection {
        inputs: vec!["u".to_owned()],
        outputs: vec!["y".to_owned()],
        event: Some("phase".to_owned()),
        gas: Some("gas".to_owned()),
    };
    let mut damage = Damage(ChaCha8Rng::seed_from_u64(seed));
    let mut passed = 0;
    for number in 0..FILES {
        std::fs::write(&path, damage.of(whole)).unwrap();
        let selection = if number % 3 == 0 { named.clone() } else { Selection::default() };
        match read(&path, &selection) {
            Ok(()) => passed += 1,
            Err(error) => assert_one_line(&error.to_string(), number),
        }
        // A file that is written over is flushed to the disk by some file systems, which takes longer than all the rest.
        std::fs::remove_file(&path).unwrap();
    }
    passed
}

/// A recording of ours with two elements, in the format of the name.
fn ours(name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let layout = Layout {
        elements: vec!["u".to_owned(), "y".to_owned()],
        wind: false,
        gas: false,
        observed: Vec::new(),
        answers: Vec::new(),
    };
    let metadata: Metadata = vec![("head".to_owned(), "name = \"B\"\nx = 1".to_owned())];
    let mut writer = RecordingWriter::create(&path, layout, &metadata).unwrap();
    for n in 0..40_u16 {
        let x = f32::from(n);
        let row = Row {
            time_s: f64::from(n) / 100.0,
            temperature_c: &[-23.0 + x, 1.0 / (1.0 + x)],
            power_w: &[f32::from(n % 2), 0.042],
            equivalent_power_w: &[],
            heaters: n % 4,
            event: ["calm", "2 m/s, \"gusts\""][usize::from(n > 20)],
            state: "running",
            wind_m_s: None,
            gas_temperature_c: None,
            answer: &[],
        };
        writer.push(&row).unwrap();
    }
    writer.finish(&vec![("lost".to_owned(), "0".to_owned())]).unwrap();
    std::fs::read(path).unwrap()
}

/// A model with wind as feedback, which has every key.
fn model() -> Model {
    let estimate = |value: f64| Estimate { value, se: 0.01 };
    let of_classes =
        |value: f64| BTreeMap::from([("calm".to_owned(), estimate(0.0)), ("gust".to_owned(), estimate(value))]);
    let class = Class {
        r_k_per_w: vec![100.0, 20.5, 3.0],
        se_k_per_w: vec![1.0, 0.5, 0.25],
        steady_gain_k_per_w: 123.5,
        se_steady_gain_k_per_w: 1.5,
        feed_through_k_per_w: 0.0,
        se_feed_through_k_per_w: 0.0,
    };
    Model {
        format: FORMAT.to_owned(),
        version: VERSION,
        structure: Structure::Conductance,
        sample_period_s: 0.01,
        inputs: vec!["power_w:a".to_owned()],
        outputs: vec![Output {
            name: "temperature_c:a".to_owned(),
            offset_c: 20.0,
            se_offset_c: 0.001,
            residual_rms: 0.005,
            fit_percent: 99.5,
            whiteness: Some(Whiteness { autocorrelation: vec![0.1, -0.05], q: 2.5, p_value: 0.3, inflation: 1.1 }),
        }],
        pairs: vec![Pair {
            input: "power_w:a".to_owned(),
            output: "temperature_c:a".to_owned(),
            mesh_rad_s: vec![0.1, 1.0, 10.0],
            se_rate_rad_s: None,
            dead_time_samples: 1,
            non_negative: true,
            classes: BTreeMap::from([("calm".to_owned(), class)]),
        }],
        event_column: Some("event".to_owned()),
        classes: vec!["calm".to_owned(), "gust".to_owned()],
        conductance_w_per_k: of_classes(0.002),
        wind: Some(Wind {
            reference: "calm".to_owned(),
            gas: Gas::Column("gas_c".to_owned()),
            elements: vec![of_classes(0.002)],
            following: Some(Following {
                from_c: 19.5,
                range_c: [18.5, 21.5],
                mesh_rad_s: vec![0.3, 3.0],
                outputs: vec![Followed {
                    f_k_per_k: vec![0.75, 0.25],
                    se_k_per_k: vec![0.02, 0.03],
                    steady_gain_k_per_k: 1.0,
                    se_steady_gain_k_per_k: 0.04,
                }],
            }),
        }),
        offset_c: 20.0,
        residual_rms: 0.005,
        fit_percent: 99.5,
        supported: true,
        warnings: Vec::new(),
        chosen: Chosen::default(),
        provenance: Provenance::default(),
        end: Some(End { next_time_s: 1.0, decays: vec![vec![(0.1, 2.0)]], pending: vec![vec![0.5]], ..End::default() }),
    }
}

#[test]
fn damaged_csv_records_are_read_or_refused_in_a_line() {
    let mut foreign = String::from("t,u,gas,phase,y\r\n");
    for n in 0..40 {
        foreign +=
            &format!("{},{},20.5,\"{}\",{}\r\n", f64::from(n) * 0.5, n % 3, ["a", "b, c"][n as usize / 20], n * n);
    }
    for (seed, whole) in [foreign.into_bytes(), ours("r.csv")].iter().enumerate() {
        let passed = damaged("r.csv", whole, seed as u64);
        // Faults in columns that are not used, and in the digits of a value, do no harm; most others must be noticed.
        assert!((FILES / 50..FILES * 3 / 4).contains(&passed), "{passed} of {FILES} were read");
    }
}

#[test]
fn damaged_parquet_records_are_read_or_refused_in_a_line() {
    let passed = damaged("r.parquet", &ours("r.parquet"), 2);
    assert!((1..FILES * 3 / 4).contains(&passed), "{passed} of {FILES} were read");
}

#[test]
fn a_number_beyond_what_can_be_computed_with_is_named() {
    let whole = model().to_json().replace("0.1,\n          2.0", "0.1,\n          1e999");
    assert_eq!(Model::from_json(&whole), Err("`end.decays[0][0][1]` is a number too large to compute with".to_owned()));
}

#[test]
fn damaged_models_are_read_or_refused_in_a_line() {
    let whole = model().to_json();
    assert_eq!(Model::from_json(&whole), Ok(model()));
    let mut damage = Damage(ChaCha8Rng::seed_from_u64(3));
    let mut passed = 0;
    for number in 0..FILES {
        match Model::from_json(&String::from_utf8_lossy(&damage.of(whole.as_bytes()))) {
            Ok(model) => {
                passed += 1;
                // What was read can be written, and read again as the same.
                assert_eq!(Model::from_json(&model.to_json()).map(|again| again.to_json()), Ok(model.to_json()));
            }
            Err(sentence) => assert_one_line(&sentence, number),
        }
    }
    assert!((1..FILES * 3 / 4).contains(&passed), "{passed} of {FILES} were read");
}

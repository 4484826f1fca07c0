//! Records with gaps, missing values, jitter, and of several files.

use super::*;
use crate::identify::{IdentifyOptions, identify};

/// Times of 100 rows a second apart, in three columns; `row` may change each.
fn table(row: impl Fn(usize) -> Option<[String; 3]>) -> String {
    let rows = (0..100).filter_map(row).map(|cells| cells.join(",") + "\n");
    rows.fold("t,u,y\n".to_owned(), |table, row| table + &row)
}

fn plain(n: usize) -> [String; 3] {
    [n.to_string(), (n % 7).to_string(), (2 * n).to_string()]
}

/// The first row of each segment by its output, and the whole.
fn segments(paths: &[PathBuf]) -> Result<(Survey, Vec<f64>, Block), String> {
    let mut stream = RecordStream::open_all(paths, &Selection::default()).map_err(|error| error.to_string())?;
    let mut passes = Vec::new();
    for _ in 0..2 {
        let (mut begins, mut all) = (Vec::new(), Block::default());
        while let Some(block) = stream.next_block().map_err(|error| error.to_string())? {
            if all.is_empty() || block.begins_segment {
                begins.push(block.outputs[0][0]);
            }
            assert!(!(all.is_empty() && block.begins_segment), "nothing stands before the first block");
            all.append(block);
        }
        passes.push((begins, all));
        stream.restart().unwrap();
    }
    assert_eq!(passes[0], passes[1], "a second pass gives the same");
    let (begins, all) = passes.remove(0);
    assert_eq!((stream.survey().rows as usize, stream.survey().segments as usize), (all.len(), begins.len()));
    Ok((stream.survey().clone(), begins, all))
}

fn of(content: &str) -> (Survey, Vec<f64>, Block) {
    let file = file("r.csv", content);
    segments(std::slice::from_ref(&file.path)).unwrap()
}

#[test]
fn a_gap_in_time_begins_a_segment_and_keeps_the_period() {
    let (survey, begins, _) = of(&table(|n| Some(plain(n)).filter(|_| !(40..70).contains(&n))));
    assert_eq!((begins, survey.sample_period_s, survey.rows), (vec![0.0, 140.0], 1.0, 70));
    assert_eq!(survey.notes[1], "1 gap in time, of 30 rows of 1 s: nothing is taken from one side to the other");
    // A logger that was started again, at another part of the second.
    let later =
        |n: usize| [format!("{:.1}", n as f64 + if n < 40 { 0.0 } else { 1000.4 }), "1".to_owned(), n.to_string()];
    let (survey, begins, _) = of(&table(|n| {
        Some(later(n)).map(|mut row| {
            row[1] = (n % 3).to_string();
            row
        })
    }));
    assert_eq!(begins, [0.0, 40.0]);
    assert!((survey.sample_period_s - 1.0).abs() < 1e-9);
}

#[test]
fn a_missing_input_begins_a_segment_and_a_missing_output_is_marked() {
    let lacking = |n: usize| {
        let mut row = plain(n);
        if n == 20 {
            row[1] = "NaN".to_owned();
        }
        if [0, 50, 51].contains(&n) {
            row[2] = String::new();
        }
        Some(row)
    };
    let (survey, begins, all) = of(&table(lacking));
    // Before the first output there is none that could be kept: the row is left out.
    assert_eq!((begins, survey.rows, all.missing), (vec![2.0, 42.0], 98, vec![48, 49]));
    assert_eq!(all.outputs[0][47..51], [98.0, 98.0, 98.0, 104.0]);
    assert_eq!(
        survey.notes[1..],
        [
            "2 rows left out, in which a value is missing, first `y` in row 1",
            "2 segments, each with offset and stored heat of its own",
            "`y` is missing in 2 rows, which count by their inputs only"
        ]
    );
}

#[test]
fn a_missing_input_that_stood_follows_from_the_rows_beside_it() {
    let (survey, begins, all) = of(&table(|n| {
        let [t, _, y] = plain(n);
        Some([t, if [20, 21].contains(&n) { String::new() } else { (n / 10 % 3 / 2).to_string() }, y])
    }));
    assert_eq!((begins, all.len()), (vec![0.0, 44.0], 98));
    let (survey_filled, begins, all) = of(&table(|n| {
        let [t, _, y] = plain(n);
        Some([t, if [23, 24].contains(&n) { String::new() } else { (n / 10 % 3 / 2).to_string() }, y])
    }));
    assert_eq!((begins, all.len(), all.inputs[0][24]), (vec![0.0], 100, 1.0));
    assert!(survey.notes.iter().any(|note| note.starts_with("2 segments,")), "{:?}", survey.notes);
    let filled = "`u` is missing in 2 rows, and follows from those beside";
    assert!(survey_filled.notes.iter().any(|note| note == filled), "{:?}", survey_filled.notes);
}

#[test]
fn a_missing_row_of_an_input_that_stood_is_one_without_output() {
    let without = |missing: &'static [usize]| {
        let row = |n: usize| {
            let [t, _, y] = plain(n);
            Some([t, (n / 10 % 3 / 2).to_string(), y]).filter(|_| !missing.contains(&n))
        };
        of(&table(row))
    };
    let (survey, begins, all) = without(&[23, 24, 61]);
    assert_eq!((begins, all.len(), all.inputs[0][24]), (vec![0.0], 100, 1.0));
    assert_eq!(all.missing, [23, 24, 61]);
    assert_eq!(
        survey.notes[1],
        "3 rows missing in time, 1 s apart, in which inputs stand: they follow from those beside"
    );
    // The input moves there, or eleven rows are missing.
    assert_eq!(without(&[19, 20]).1, [0.0, 42.0]);
    assert_eq!(without(&[30, 31, 32, 33, 34, 35, 36, 37, 38, 39, 40]).1, [0.0, 82.0]);
}

#[test]
fn rows_keep_the_numbers_of_their_file_behind_one_that_is_missing() {
    let row = |n: usize| {
        let [t, _, y] = plain(n);
        Some([t, (n / 10 % 3 / 2).to_string(), if n == 50 { "inf".to_owned() } else { y }]).filter(|_| n != 23)
    };
    let file = file("r.csv", &table(row));
    let refused = segments(std::slice::from_ref(&file.path)).unwrap_err();
    assert!(refused.contains("row 50"), "{refused}");
}

#[test]
fn a_marker_of_a_logger_is_a_missing_value() {
    let (survey, begins, all) = of(&table(|n| {
        let [t, u, y] = plain(n);
        Some([t, u, if [40, 41].contains(&n) { "-9999".to_owned() } else { y }])
    }));
    assert_eq!((begins, all.len(), all.missing), (vec![0.0], 100, vec![40, 41]));
    assert!(survey.notes.iter().any(|note| note == "`y` is -9999 or 9.9e37 in 2 rows: taken for missing"));
}

#[test]
fn a_file_is_no_second_measurement_of_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("day.csv");
    std::fs::write(&path, table(|n| Some(plain(n)))).unwrap();
    let refused = segments(&[path.clone(), path]).unwrap_err();
    assert!(refused.ends_with("is named twice: its rows would count as two measurements"), "{refused}");
}

#[test]
fn a_missing_time_is_a_missing_row() {
    let (_, begins, all) =
        of(&table(|n| Some(plain(n)).map(|[t, u, y]| [if n == 30 { String::new() } else { t }, u, y])));
    assert_eq!((begins, all.len()), (vec![0.0, 62.0], 99));
}

#[test]
fn jitter_is_resampled_with_a_remark() {
    // A straight line is met exactly by linear interpolation, but for the outermost rows.
    let jitter = |n: usize| ((n * 37) % 91) as f64 / 110.0 - 0.4;
    let mut text = "t,u,y\n".to_owned();
    for n in 0..40_000 {
        let time_s = 0.1 * (n as f64 + jitter(n));
        text += &format!("{time_s:.5},{},{:.5}\n", n % 7, 20.0 + 3.0 * time_s);
    }
    let (survey, begins, all) = of(&text);
    assert_eq!((begins.len(), all.len()), (1, 40_000));
    assert!((survey.sample_period_s / 0.1 - 1.0).abs() < 1e-6, "{}", survey.sample_period_s);
    let first = all.outputs[0][100] - 0.3 * 100.0;
    for (n, y) in all.outputs[0].iter().enumerate().take(39_999).skip(1) {
        // Rows of less than a tenth are left as they are: 0.1 · 0.1 s · 3 K/s.
        assert!((y - (first + 0.3 * n as f64)).abs() < 0.061, "{n}: {y}");
    }
    assert_eq!(all.inputs[0][8], 1.0);
    let note = survey.notes.last().unwrap();
    assert!(note.contains("rows are off their place in time by more than 10 % of 0.1 s"), "{note}");
    assert!(note.ends_with("outputs are interpolated to uniform times, inputs held"), "{note}");
}

#[test]
fn several_files_are_segments_of_one_record() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| {
        std::fs::write(folder.path().join(name), content).unwrap();
        folder.path().join(name)
    };
    let day = write("day1.csv", &table(|n| Some(plain(n))));
    let (survey, begins, all) =
        segments(&[day.clone(), write("day2.csv", &table(|n| Some(plain(n))).replace(',', ";"))]).unwrap();
    assert_eq!((begins, survey.rows, survey.sample_period_s), (vec![0.0, 0.0], 200, 1.0));
    assert_eq!((all.outputs[0][100], survey.paths.len()), (0.0, 2));

    let refused = |content: &str| {
        let sentence = segments(&[day.clone(), write("other.csv", content)]).unwrap_err();
        sentence.replace(&format!("{}/", folder.path().display()), "")
    };
    assert_eq!(
        refused("t,u,T\n0,1,2\n"),
        "other.csv: has `T` where day1.csv has `y`: files of one record have the same columns"
    );
    let slow = table(|n| Some(plain(n)).map(|[t, u, y]| [format!("{t}0"), u, y])).replace("\n00,", "\n0,");
    assert_eq!(
        refused(&slow),
        "other.csv: has rows 10 s apart, and day1.csv has 1 s: identify records of one sample period together"
    );
    // An event label has one number in all files.
    let labelled = |first: &str, second: &str| {
        let text = |label: &str| format!("t,u,event,y\n0,1,{label},2\n1,2,{label},3\n2,3,both,4\n");
        let paths = [write("a.csv", &text(first)), write("b.csv", &text(second))];
        let mut stream = RecordStream::open_all(&paths, &Selection::default()).unwrap();
        let mut class = Vec::new();
        while let Some(block) = stream.next_block().unwrap() {
            class.extend_from_slice(&block.class);
        }
        (class, stream.classes().to_vec())
    };
    assert_eq!(labelled("calm", "gust"), (vec![0, 0, 1, 2, 2, 1], names(&["calm", "both", "gust"])));
}

/// A logger that begins a new file every so many rows, with times that run on.
#[test]
fn files_that_go_on_where_another_ended_are_one_segment() {
    let folder = tempfile::tempdir().unwrap();
    let part = |name: &str, rows: std::ops::Range<usize>, from_s: f64| {
        // Times jitter by a fifth of the period.
        let time_s = |n: usize| from_s + n as f64 + ((n * 37) % 91) as f64 / 227.0 - 0.2;
        let line = |n| format!("{:.3},{},{}\n", time_s(n), n % 7, n as f64 / 2.0);
        std::fs::write(folder.path().join(name), "t,u,y\n".to_owned() + &rows.map(line).collect::<String>()).unwrap();
        folder.path().join(name)
    };
    let parts = [part("1.csv", 0..300, 0.0), part("2.csv", 300..320, 0.0), part("3.csv", 320..900, 0.0)];
    let whole = segments(&[part("whole.csv", 0..900, 0.0)]).unwrap();
    let (survey, begins, all) = segments(&parts).unwrap();
    assert_eq!((survey.segments, begins.len(), survey.rows), (1, 1, 900));
    assert!((survey.sample_period_s / whole.0.sample_period_s - 1.0).abs() < 1e-9);
    for (n, (y, of_whole)) in all.outputs[0].iter().zip(&whole.2.outputs[0]).enumerate() {
        // At the seams a row has no neighbour in its file, and keeps its value: 0.2 s at 0.5 1/s.
        assert!(
            (y - of_whole).abs() < if [299, 300, 319, 320].contains(&n) { 0.11 } else { 1e-3 },
            "{n}: {y}, {of_whole}"
        );
    }
    // A second file of another day begins a segment, and so does one with a row too few.
    let later = |rows| segments(&[part("1.csv", 0..300, 0.0), part("4.csv", rows, 0.0)]).unwrap().0.segments;
    assert_eq!([later(0..300), later(301..600), later(300..600)], [2, 2, 1]);
}

#[test]
fn a_record_that_is_too_long_to_be_kept_reads_as_one_that_is() {
    // 1.6 million rows of three columns: more than are kept.
    let mut text = "t,u,y\n".to_owned();
    for n in 0..1_600_000_u32 {
        if n != 800_000 {
            text += &format!("{n},{},{}\n", n % 7, n / 2);
        }
    }
    let (survey, begins, _) = of(&text);
    assert_eq!((survey.rows, begins), (1_599_999, vec![0.0, 400_000.0]));
}

/// A body of 2 s and 40 s, heated by chance; every file begins with stored heat, and is eight times
/// as long as its slower time constant.
#[test]
fn many_recordings_tell_a_gain_in_any_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut seed = 9_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut file = |number: usize| {
        let (mut fast, mut slow, mut power_w) = (0.0, random(), 0.0);
        let mut text = "time_s,power_w,temperature_c\n".to_owned();
        for row in 0..640 + 40 * number {
            if row % 8 == 0 {
                power_w = if random() > 0.0 { 1.0 } else { 0.0 };
            }
            let temperature_c = 20.0 + 10.0 * random() * 1e-3 + 12.0 * fast + 30.0 * slow;
            text += &format!("{},{power_w},{temperature_c:.4}\n", 0.5 * row as f64);
            fast += (1.0 - libm::exp(-0.5_f64 / 2.0)) * (power_w - fast);
            slow += (1.0 - libm::exp(-0.5_f64 / 40.0)) * (power_w - slow);
        }
        let path = folder.path().join(format!("{number}.csv"));
        std::fs::write(&path, text).unwrap();
        path
    };
    let mut files: Vec<PathBuf> = (0..12).map(&mut file).collect();
    let gain = |files: &[PathBuf]| {
        let mut stream = RecordStream::open_all(files, &Selection::default()).unwrap();
        let model = identify(&mut stream, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {}).unwrap();
        let class = model.pairs[0].classes.values().next().unwrap().clone();
        println!("{} files: {} ± {} K/W", files.len(), class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
        (class.steady_gain_k_per_w, class.se_steady_gain_k_per_w)
    };
    for turn in 0..4 {
        files.rotate_left(5);
        if turn % 2 == 1 {
            files.reverse();
        }
        let (of_all, se) = gain(&files);
        // With rates that no file is long enough for, this was wrong by tens of percent.
        assert!((of_all - 42.0).abs() < 4.0 * se && se < 0.01 * of_all, "{of_all} ± {se}");
    }
}

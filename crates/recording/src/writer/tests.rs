//! Recordings that end in the middle, and in several files.

use std::time::Duration;

use super::*;
use crate::column::ColumnValues;
use crate::reader::RecordingReader;
use crate::recording::Recording;
use std::path::PathBuf;

fn layout() -> RecordingLayout {
    RecordingLayout { elements: vec!["sector1".to_owned(), "core-1".to_owned()], ..RecordingLayout::default() }
}

fn row(n: u32) -> (f64, [f32; 2]) {
    (f64::from(n) / 100.0, [20.0 + (n as f32) / 3.0, if n.is_multiple_of(7) { f32::NAN } else { -(n as f32).sqrt() }])
}

fn push(writer: &mut RecordingWriter, n: u32) {
    let (time_s, temperature_c) = row(n);
    writer.push(&of(time_s, &temperature_c)).unwrap();
}

fn of<'a>(time_s: f64, temperature_c: &'a [f32]) -> RecordingRow<'a> {
    RecordingRow {
        time_s,
        temperature_c,
        power_w: &[1e-3, 0.0],
        equivalent_power_w: &[],
        heaters: 2,
        event: "door \"open\",\nwindow",
        state: "running",
        true_wind_m_s: None,
        gas_temperature_c: None,
        estimate: &[],
    }
}

/// Refuses rows that are not those that were pushed, and tells how many there are.
fn rows_of(path: &Path) -> u32 {
    let read = Recording::read(path).unwrap();
    let bits = |numbers: &[f64]| numbers.iter().map(|number| (*number as f32).to_bits()).collect::<Vec<_>>();
    let count = read.len() as u32;
    let expected: Vec<_> = (0..count).map(row).collect();
    assert_eq!(read.time_s().unwrap(), expected.iter().map(|(time_s, _)| *time_s).collect::<Vec<_>>());
    for (at, element) in ["temperature_c_sector1", "temperature_c_core_1"].into_iter().enumerate() {
        let expected: Vec<_> = expected.iter().map(|(_, values)| f64::from(values[at])).collect();
        assert_eq!(bits(read.numbers(element).unwrap()), bits(&expected), "{element}");
    }
    assert!(read.numbers("heater_core_1").unwrap().iter().all(|bit| *bit == 1.0));
    assert!(read.events().unwrap().iter().all(|event| event == "door \"open\",\nwindow"));
    count
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn start(path: &Path, segment: SegmentLength) -> Result<RecordingWriter, RecordingError> {
    let options = WriterOptions { has_journal: true, segment, ..WriterOptions::default() };
    RecordingWriter::with_options(path, layout(), &vec![("head_name".to_owned(), "test".to_owned())], &options)
}

/// Ends as if the program was killed: nothing is closed, and the system keeps what it was handed.
fn kill(mut writer: RecordingWriter) -> PathBuf {
    let journal = writer.journal.as_mut().unwrap();
    journal.sync().unwrap();
    let path = journal.path.clone();
    drop(writer);
    path
}

#[test]
fn a_folder_has_closed_segments_and_reads_as_one_recording() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::Seconds(1.0)).unwrap();
    for n in 0..250 {
        push(&mut writer, n);
    }
    // It is read while it grows, up to what the disk has.
    writer.journal.as_mut().unwrap().sync().unwrap();
    assert_eq!(names(&folder).iter().filter(|name| !name.starts_with('.')).count(), 3);
    assert_eq!(rows_of(&folder), 250);
    writer.finish(&vec![("complete".to_owned(), "true".to_owned()), ("lost".to_owned(), "0".to_owned())]).unwrap();
    assert_eq!(names(&folder), ["segment-000001.parquet", "segment-000002.parquet", "segment-000003.parquet"]);
    assert_eq!(rows_of(&folder), 250);
    assert_eq!(rows_of(&folder.join("segment-*.parquet")), 250);
    let read = Recording::read(&folder).unwrap();
    let said = |key| read.metadata(key).unwrap();
    assert_eq!((said("head_name"), said("lost"), said("segment")), ("test", "0", "3"));
    assert_eq!(Recording::read(&folder.join("segment-000002.parquet")).unwrap().time_s().unwrap()[0], 1.0);
    // Rows of several segments are passed over.
    let mut reader = RecordingReader::open(&folder).unwrap();
    assert_eq!((reader.skip(130).unwrap(), reader.rows()), (130, None));
    assert_eq!(reader.next_chunk().unwrap().unwrap()[0].values.len(), 70);
    assert_eq!(RecordingReader::open(&folder).unwrap().skip(1000).unwrap(), 250);
    let error = start(&folder, SegmentLength::default()).err().unwrap().to_string();
    assert!(error.contains("holds a recording already"), "{error}");
}

#[test]
fn segments_are_no_longer_than_their_bytes() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::Bytes(30_000)).unwrap();
    for n in 0..3000 {
        push(&mut writer, n);
    }
    writer.finish(&Metadata::new()).unwrap();
    let sizes: Vec<u64> = names(&folder).iter().map(|name| folder.join(name).metadata().unwrap().len()).collect();
    assert!(sizes.len() > 3 && sizes.iter().all(|size| *size <= 30_000), "{sizes:?}");
    assert_eq!(rows_of(&folder), 3000);
}

#[test]
fn what_a_journal_has_kept_becomes_the_file_or_the_last_segment() {
    let outer = tempfile::tempdir().unwrap();
    for (name, closed, kept) in [("run.parquet", 0, 130), ("run.csv", 0, 130), ("run", 1, 30)] {
        let path = outer.path().join(name);
        let mut writer = start(&path, SegmentLength::Seconds(1.0)).unwrap();
        for n in 0..130 {
            push(&mut writer, n);
        }
        let journal = kill(writer);
        let error = start(&path, SegmentLength::default()).err().unwrap().to_string();
        let expected = if closed > 0 { "holds a recording already" } else { "anemo recover" };
        assert!(error.contains(expected), "{error}");
        let recovered = recover(&path).unwrap().unwrap();
        assert_eq!((recovered.rows, journal.exists()), (kept, false), "{name}");
        assert_eq!(rows_of(&path), 130);
        let read = Recording::read(&recovered.file).unwrap();
        assert_eq!((read.metadata("complete"), read.metadata("head_name")), (Some("false"), Some("test")));
        assert!(read.metadata("ended").unwrap().contains("without closing it"));
        assert_eq!(recover(&path).unwrap(), None);
    }
}

/// Whatever reached the disk of a journal, rows up to there are whole, and nothing is made up.
#[test]
fn a_journal_may_end_anywhere() {
    let outer = tempfile::tempdir().unwrap();
    let path = outer.path().join("run.parquet");
    let mut writer = start(&path, SegmentLength::default()).unwrap();
    for n in 0..40 {
        push(&mut writer, n);
    }
    let journal = kill(writer);
    let whole = std::fs::read(&journal).unwrap();
    let mut counts = Vec::new();
    // The last line is a checksum, which may end in any of its digits.
    for end in (0..=whole.len()).filter(|end| end % 11 == 0 || end + 30 > whole.len()) {
        // Blocks that the disk has not got are zeros, or missing.
        for zeros in [0, 700] {
            let mut cut = whole[..end].to_vec();
            cut.extend(vec![0; zeros]);
            std::fs::write(&journal, cut).unwrap();
            match recover(&path).unwrap() {
                Some(Recovered { rows, .. }) => {
                    assert_eq!(u64::from(rows_of(&path)), rows);
                    counts.push(rows);
                    std::fs::remove_file(&path).unwrap();
                }
                None => counts.push(0),
            }
            assert!(!journal.exists() && !path.exists());
        }
    }
    assert!(counts.is_sorted(), "{counts:?}");
    assert_eq!((counts.first(), counts.last()), (Some(&0), Some(&40)));
}

/// Damage in the midst costs the lines that it hit, and nothing is thrown away.
#[test]
fn a_damaged_journal_keeps_the_rows_that_can_be_read() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::Seconds(1.0)).unwrap();
    for n in 0..130 {
        push(&mut writer, n);
    }
    let journal = kill(writer);
    let whole = std::fs::read(&journal).unwrap();
    let first = std::fs::read(folder.join("segment-000001.parquet")).unwrap();
    let find = |text: &str| whole.windows(text.len()).position(|bytes| bytes == text.as_bytes()).unwrap();
    let row = find("\n1.1,") + 1;
    let garbage: &[u8] = &[0xff, 0xfe, 0];
    let hits: [(usize, &[u8], u64); 10] = [
        (row, garbage, 29),                          // no text
        (row, b"1,1", 29),                           // a field too many
        (row, b"\"", 29),                            // a quote that nothing ends
        (row, b"x", 29),                             // a word in place of a number
        (row + 4, b"7", 30),                         // a digit in place of another
        (find("# segment"), b"# sogment", 30),       // which segment it is
        (find("# segment: 2"), b"# segment: 1", 30), // one that is closed
        (find("time_s,"), b"tame_s", 30),            // names of columns
        (0, b"\"", 30),                              // what the journal says of itself
        (0, &[0; 60], 30),
    ];
    for (at, damage, rows) in hits {
        let mut bytes = whole.clone();
        bytes[at..at + damage.len()].copy_from_slice(damage);
        assert!(bytes != whole);
        std::fs::remove_dir_all(&folder).unwrap();
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("segment-000001.parquet"), &first).unwrap();
        std::fs::write(&journal, &bytes).unwrap();
        let recovered = recover(&folder).unwrap().unwrap();
        assert_eq!(recovered.rows, rows, "{damage:?}");
        let read = Recording::read(&folder).unwrap();
        let is_hit = |n: &f64| rows < 30 && *n == 110.0;
        let expected: Vec<f64> = (0..130).map(f64::from).filter(|n| !is_hit(n)).map(|n| n / 100.0).collect();
        assert_eq!(read.time_s().unwrap(), expected, "{damage:?}");
        assert!(std::fs::read(recovered.damaged.unwrap()).unwrap() == bytes);
        assert_eq!(recover(&folder).unwrap(), None);
    }
    // Killed after the rows had their file, and before the journal was put aside.
    let mut bytes = whole.clone();
    bytes[row..row + 3].copy_from_slice(garbage);
    std::fs::write(&journal, &bytes).unwrap();
    let again = recover(&folder).unwrap().unwrap();
    assert_eq!(again.rows, 0);
    assert!(std::fs::read(again.damaged.unwrap()).unwrap() == bytes);
}

/// Whatever has become of the columns' names, the rows are there, under names that say so.
#[test]
fn rows_outlast_the_names_of_their_columns() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::default()).unwrap();
    for n in 0..30 {
        push(&mut writer, n);
    }
    let journal = kill(writer);
    let whole = std::fs::read(&journal).unwrap();
    let names = whole.windows(7).position(|bytes| bytes == b"time_s,").unwrap();
    let comma = whole[names..].iter().position(|&byte| byte == b',').unwrap() + names;
    let hits: [(usize, Vec<u8>); 4] =
        [(names, b"time_s\0".to_vec()), (0, vec![0; names + 9]), (0, b"\"".to_vec()), (comma, b"\n".to_vec())];
    for (at, damage) in hits {
        let mut bytes = whole.clone();
        bytes[at..at + damage.len()].copy_from_slice(&damage);
        std::fs::remove_dir_all(&folder).unwrap();
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(&journal, &bytes).unwrap();
        let recovered = recover(&folder).unwrap().unwrap();
        assert!(recovered.rows == 30 && std::fs::read(recovered.damaged.unwrap()).unwrap() == bytes, "{damage:?}");
        let read = Recording::read(&folder).unwrap();
        assert_eq!(read.time_s().unwrap().len(), 30);
        assert!(read.metadata("ended").unwrap().contains("its journal was damaged"));
    }
}

/// Another program has closed a segment since this one counted them: theirs stays.
#[test]
fn segments_of_two_programs_do_not_replace_each_other() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let options = WriterOptions { appends: true, ..WriterOptions::default() };
    let before = Segments::new(&folder, &options, &layout().columns()).unwrap();
    assert_eq!((before.number, before.check_number()), (1, Ok(())));
    let mut writer = start(&folder, SegmentLength::default()).unwrap();
    push(&mut writer, 0);
    writer.finish(&Metadata::new()).unwrap();
    let refusal = before.check_number().unwrap_err().to_string();
    assert!(refusal.contains("another program has recorded there"), "{refusal}");
    let (last, next) =
        (folder.join("segment-4294967295.parquet"), || Segments::new(&folder, &options, &layout().columns()));
    std::fs::copy(folder.join("segment-000001.parquet"), &last).unwrap();
    assert!(next().err().unwrap().to_string().contains("no number follows"));
}

/// A disk without room for a segment's end, and later with it.
#[test]
fn a_segment_that_could_not_be_closed_is_closed_when_there_is_room() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::default()).unwrap();
    for n in 0..30 {
        push(&mut writer, n);
    }
    // Its end has failed.
    (writer.table, writer.waits_for_room) = (None, true);
    writer.begin_segment().unwrap();
    for n in 30..50 {
        push(&mut writer, n);
    }
    writer.finish(&Metadata::new()).unwrap();
    assert_eq!(names(&folder), ["segment-000001.parquet", "segment-000002.parquet"]);
    assert_eq!(rows_of(&folder), 50);
    let first = Recording::read(&folder.join("segment-000001.parquet")).unwrap();
    assert_eq!((first.metadata("complete"), first.metadata("ended")), (Some("false"), Some(FULL)));
}

#[test]
fn a_disk_without_room_is_known_within_the_error_of_a_format() {
    let full = || std::io::Error::from(ErrorKind::StorageFull);
    assert!(unwritten(Path::new("a"))(full()).lacks_room());
    let within = parquet::errors::ParquetError::External(Box::new(full()));
    assert!(unwritten(Path::new("a"))(std::io::Error::other(within)).lacks_room());
    assert!(!unwritten(Path::new("a"))(std::io::Error::other("else")).lacks_room());
}

/// A folder with a journal's name keeps nothing else from being recovered.
#[test]
fn folders_named_like_journals_are_passed_over() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::default()).unwrap();
    push(&mut writer, 0);
    kill(writer);
    std::fs::create_dir_all(folder.join("every-y/recording.journal")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(".", folder.join("every-x")).unwrap();
    assert!(!is_being_written(&folder));
    assert_eq!(recover(&folder).unwrap().unwrap().rows, 1);
}

#[test]
fn a_journal_of_closed_rows_does_not_repeat_them() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("run");
    let mut writer = start(&folder, SegmentLength::Seconds(1.0)).unwrap();
    for n in 0..100 {
        push(&mut writer, n);
    }
    // Killed between the end of the segment and the next journal.
    writer.journal.as_mut().unwrap().sync().unwrap();
    let before = std::fs::read(journal_in(&folder)).unwrap();
    writer.close_segment(true).and_then(|()| writer.begin_segment()).unwrap();
    let journal = kill(writer);
    std::fs::write(&journal, before).unwrap();
    assert_eq!(rows_of(&folder), 100);
    assert_eq!(recover(&folder).unwrap(), None);
    assert_eq!(names(&folder), ["segment-000001.parquet"]);
}

#[test]
fn a_recording_that_goes_on_is_left_alone() {
    let outer = tempfile::tempdir().unwrap();
    let path = outer.path().join("run.parquet");
    let mut writer = start(&path, SegmentLength::default()).unwrap();
    push(&mut writer, 0);
    for error in [start(&path, SegmentLength::default()).err().unwrap(), recover(&path).unwrap_err()] {
        assert!(error.to_string().contains("another program is recording there"), "{error}");
    }
    writer.finish(&Metadata::new()).unwrap();
    assert_eq!(names(outer.path()), ["run.parquet"]);
}

#[test]
fn a_recorder_writes_as_its_writer_does_and_a_silent_instrument_loses_nothing() {
    let outer = tempfile::tempdir().unwrap();
    let path = outer.path().join("run.parquet");
    let options = WriterOptions { has_journal: true, ..WriterOptions::default() };
    let mut recorder = Recorder::create(&path, layout(), &Metadata::new(), &options).unwrap();
    for n in 0..500 {
        let (time_s, temperature_c) = row(n);
        recorder.push(&of(time_s, &temperature_c)).unwrap();
    }
    // No more rows come, and nobody closes the file: all are on the disk all the same.
    let journal = journal_of(&path);
    let deadline = std::time::Instant::now() + Duration::from_secs(20);
    while RecordingReader::open(&journal).unwrap().skip(1000).unwrap() < 500 {
        assert!(std::time::Instant::now() < deadline);
        std::thread::sleep(Duration::from_millis(20));
    }
    recorder.finish(&Metadata::new()).unwrap();
    assert_eq!((rows_of(&path), names(outer.path()).len()), (500, 1));
    // Without a row nothing is left.
    let folder = outer.path().join("none");
    drop(Recorder::create(&folder, layout(), &Metadata::new(), &options).unwrap());
    drop(Recorder::create(&path.with_file_name("none.csv"), layout(), &Metadata::new(), &options).unwrap());
    assert_eq!(names(outer.path()), ["run.parquet"]);
}

/// No row before the first that the disk refused is lost.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_no_row_that_it_had() {
    let outer = tempfile::tempdir().unwrap();
    let path = outer.path().join("run.parquet");
    let mut writer = start(&path, SegmentLength::default()).unwrap();
    for n in 0..100 {
        push(&mut writer, n);
    }
    writer.journal.as_mut().unwrap().sync().unwrap();
    // The journal's next bytes go to a disk without room.
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let columns = ColumnKind::of_each(layout().columns());
    writer.journal.as_mut().unwrap().replace_writer(full, &columns);
    let error = (100..100_000).find_map(|n| {
        let (time_s, temperature_c) = row(n);
        writer.push(&of(time_s, &temperature_c)).err()
    });
    let error = error.unwrap().to_string();
    assert!(error.contains("No space left"), "{error}");
    drop(writer);
    assert_eq!(recover(&path).unwrap().unwrap().rows, 100);
}

#[test]
fn names_of_recordings_are_files_with_an_extension_or_folders() {
    let outer = tempfile::tempdir().unwrap();
    for (name, fault) in [
        ("run.txt", "ends in .parquet or .csv"),
        ("run.journal", "ends in .parquet or .csv"),
        ("no/run", "cannot be written"),
        ("no/run.csv", "there is no folder"),
    ] {
        let error = start(&outer.path().join(name), SegmentLength::default()).err().unwrap().to_string();
        assert!(error.contains(fault), "{name}: {error}");
    }
    assert!(names(outer.path()).is_empty());
    let empty = Recording::read(outer.path()).unwrap_err().to_string();
    assert!(empty.contains("holds no recording"), "{empty}");
    let none = Recording::read(&outer.path().join("*.parquet")).unwrap_err().to_string();
    assert!(none.contains("no file has such a name"), "{none}");
}

#[test]
fn either_format_gives_the_same_numbers_back() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = ([0.0, 1.0, 1.0], [0.1, 1.0 / 3.0, -2e-9]);
    for name in ["record.csv", "record.parquet"] {
        let path = folder.path().join(name);
        let metadata = vec![("title".to_owned(), "a test".to_owned())];
        write_columns(&path, 5e-4, &[("u", &u), ("y", &y)], &metadata).unwrap();
        let read = Recording::read(&path).unwrap();
        let columns: Vec<(&str, &ColumnValues)> = read.columns.iter().map(|c| (c.name.as_str(), &c.values)).collect();
        let numbers = |values: &[f64]| ColumnValues::Numbers(values.to_vec());
        let expected = [numbers(&[0.0, 5e-4, 1e-3]), numbers(&u), numbers(&y)];
        assert_eq!(columns.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["time_s", "u", "y"], "{name}");
        assert!(columns.iter().zip(&expected).all(|((_, values), expected)| *values == expected), "{name}");
        assert_eq!(read.metadata, metadata, "{name}");
    }
    let error = write_columns(&folder.path().join("record.txt"), 1.0, &[("u", &u)], &Vec::new()).unwrap_err();
    assert!(error.to_string().contains(".parquet or .csv"), "{error}");
}

/// Arrival in steps of a sample period: a board whose clock is that of the host.
#[test]
fn what_is_measured_says_when_it_arrived_and_how_far_the_clocks_drift() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.parquet", "run.csv", "run"] {
        let path = folder.path().join(name);
        let options = WriterOptions { has_journal: true, has_utc: true, ..WriterOptions::default() };
        let mut recorder = Recorder::create(&path, layout(), &Metadata::new(), &options).unwrap();
        let begin = SystemTime::UNIX_EPOCH + Duration::from_secs_f64(1_793_000_000.5);
        for n in 0..300 {
            let (time_s, temperature_c) = row(n);
            recorder.push_at(&of(time_s, &temperature_c), begin + Duration::from_secs_f64(time_s)).unwrap();
        }
        recorder.finish(&Metadata::new()).unwrap();
        assert_eq!(rows_of(&path), 300);
        let read = Recording::read(&path).unwrap();
        let arrived = read.numbers("utc").unwrap();
        assert!((arrived[0] - 1_793_000_000.5).abs() < 1e-6 && (arrived[299] - arrived[0] - 2.99).abs() < 2e-6);
        let said = |key| read.metadata(key).unwrap().parse::<f64>().unwrap();
        assert!(said("clock_drift_ppm").abs() < 0.2 && said("clock_drift_u_ppm") < 0.2, "{name}");
        if name == "run.csv" {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains("\n0.01,2026-10-26T07:33:20.51Z,"), "{text}");
        }
    }
}

#[test]
fn a_folder_goes_on_forgets_old_segments_and_keeps_means_beside() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("log");
    let options = WriterOptions {
        segment: SegmentLength::Seconds(1.0),
        appends: true,
        keep_s: Some(2.5),
        every_s: Some(0.5),
        ..WriterOptions::default()
    };
    let run = |rows: std::ops::Range<u32>| {
        let mut writer = RecordingWriter::with_options(&folder, layout(), &Metadata::new(), &options).unwrap();
        rows.for_each(|n| push(&mut writer, n));
        writer.finish(&Metadata::new()).unwrap();
    };
    run(0..250);
    assert_eq!(names(&folder).len(), 4);
    // Segments 4 to 9: of 4.0 s on, what is older than 2.5 s when the last one is begun goes.
    run(400..950);
    let left = names(&folder);
    assert_eq!((left[0].as_str(), left[1].as_str(), left.len()), ("every-500ms", "segment-000006.parquet", 5));
    let full = Recording::read(&folder).unwrap();
    assert_eq!((full.len(), full.time_s().unwrap()[0]), (350, 6.0));
    let means = Recording::read(&folder.join("every-500ms")).unwrap();
    assert_eq!(means.time_s().unwrap()[..6], [0.0, 0.5, 1.0, 1.5, 2.0, 4.0]);
    let of = |name| means.numbers(name).unwrap()[1];
    // Rows 50 to 99.
    let expected = 20.0 + 74.5 / 3.0;
    assert!((of("temperature_c_sector1") - expected).abs() < 1e-4, "{}", of("temperature_c_sector1"));
    assert!((of("min_temperature_c_sector1") - (20.0 + 50.0 / 3.0)).abs() < 1e-4);
    assert_eq!((of("duty_core_1"), of("duty_sector1")), (1.0, 0.0));
    let other = RecordingLayout { elements: vec!["other".to_owned()], ..RecordingLayout::default() };
    let error = RecordingWriter::with_options(&folder, other, &Metadata::new(), &options).err().unwrap().to_string();
    assert!(error.contains("other columns"), "{error}");
}

/// Begins itself again, with a disk of 1 MiB for its temporary files, where the system gives one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_closes_the_segment_and_costs_only_what_it_refused() {
    if std::env::var_os("ANEMO_SMALL_DISK").is_some() {
        return outlast_a_full_disk();
    }
    let folder = tempfile::tempdir().unwrap();
    let name = "writer::tests::a_full_disk_closes_the_segment_and_costs_only_what_it_refused";
    let script = "mount -t tmpfs -o size=1m tmpfs \"$TMPDIR\" || exit 77; exec \"$0\" --exact \"$1\" --nocapture";
    let outcome = std::process::Command::new("unshare")
        .args(["-rm", "sh", "-c", script, std::env::current_exe().unwrap().to_str().unwrap(), name])
        .env("TMPDIR", folder.path())
        .env("ANEMO_SMALL_DISK", "1")
        .output();
    match outcome {
        Ok(output) if [Some(77), Some(1)].contains(&output.status.code()) => eprintln!("no small disk: skipped"),
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => eprintln!("no small disk: skipped: {error}"),
    }
}

#[cfg(target_os = "linux")]
fn outlast_a_full_disk() {
    let disk = std::env::temp_dir();
    let folder = disk.join("log");
    let options =
        WriterOptions { segment: SegmentLength::Seconds(20.0), outlasts_full_disk: true, ..WriterOptions::default() };
    let metadata = vec![("head".to_owned(), "x".repeat(5000))];
    let mut writer = RecordingWriter::with_options(&folder, layout(), &metadata, &options).unwrap();
    let mut n = 0;
    while !writer.lacks_room() {
        push(&mut writer, n);
        n += 1;
        assert!(n < 1_000_000, "the disk does not fill");
    }
    // All but the one that was refused.
    let whole = n - u32::try_from(writer.left_out).unwrap();
    assert_eq!(writer.left_out, 1);
    assert_eq!(rows_of(&folder), whole);
    let last = Recording::read(&folder).unwrap();
    assert_eq!((last.metadata("complete"), last.metadata("ended")), (Some("false"), Some("the disk is full")));
    // Somebody makes room.
    std::fs::remove_file(folder.join("segment-000001.parquet")).unwrap();
    std::fs::remove_file(folder.join("segment-000002.parquet")).unwrap();
    for _ in 0..40 {
        std::thread::sleep(Duration::from_millis(50));
        push(&mut writer, n);
        n += 1;
    }
    let left_out = writer.left_out;
    assert!((2..40).contains(&left_out) && !writer.lacks_room(), "{left_out}");
    assert_eq!(writer.finish(&Metadata::new()).unwrap(), left_out);
    let times = Recording::read(&folder).unwrap();
    let times = times.time_s().unwrap();
    let gap = times.windows(2).position(|pair| pair[1] - pair[0] > 0.015).unwrap();
    assert_eq!(times[gap], f64::from(whole - 1) / 100.0);
    eprintln!("{whole} rows, {left_out} left out, {} behind the gap", times.len() - gap - 1);
}

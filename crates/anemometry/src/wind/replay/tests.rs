use super::*;
use recording::{Metadata, RecordingLayout, RecordingWriter};

fn head() -> Head {
    Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml")).unwrap()
}

/// A recording of these times, with what it says of its sample period; sector 1 takes 10 mW, and 30
/// mW in every fourth row.
fn recording(folder: &Path, times_s: &[f64], period: Option<&str>) -> PathBuf {
    let path = folder.join("r.parquet");
    let elements: Vec<String> = head().names().into_iter().map(str::to_owned).collect();
    let layout = RecordingLayout {
        elements,
        true_wind: false,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    };
    let metadata: Metadata =
        period.map(|period| ("sample_period_s".to_owned(), period.to_owned())).into_iter().collect();
    let mut writer = RecordingWriter::create(&path, layout, &metadata).unwrap();
    for (n, &time_s) in times_s.iter().enumerate() {
        let power_w = [if n % 4 == 0 { 0.03 } else { 0.01 }, 0.0, 0.0, 0.0, 0.0, 0.0];
        let row = recording::RecordingRow {
            time_s,
            temperature_c: &[-20.0; 6],
            power_w: &power_w,
            equivalent_power_w: &[],
            heaters: 0,
            event: if n < 500 { "before" } else { "after" },
            state: "running",
            true_wind_m_s: None,
            gas_temperature_c: None,
            estimate: &[],
        };
        writer.push(&row).unwrap();
    }
    writer.finish(&Metadata::new()).unwrap();
    path
}

fn replayed(path: &Path) -> Result<Vec<Moment>, String> {
    let mut replay = Replay::open(path, &head(), None).map_err(|error| error.to_string())?;
    let mut moments = Vec::new();
    while let Some(moment) = replay.next_moment().map_err(|error| error.to_string())? {
        moments.push(moment);
    }
    Ok(moments)
}

#[test]
fn ticks_that_are_missing_are_gone_through_and_what_follows_is_doubted_for_ten_times_as_long() {
    let folder = tempfile::tempdir().unwrap();
    // 0.2 s without rows, from 5 s on, in a recording that begins at 200 s.
    let times_s: Vec<f64> =
        (0..1200).filter(|n| !(500..520).contains(n)).map(|n| 200.0 + 0.01 * f64::from(n)).collect();
    let moments = replayed(&recording(folder.path(), &times_s, None)).unwrap();
    assert_eq!(moments.len(), 1200);
    // No tick is left out, whatever its row.
    assert!(moments.iter().enumerate().all(|(n, moment)| moment.tick.tick == n as u32));
    let known = |of: TickOrigin| moments.iter().filter(|moment| moment.known == of).count();
    assert_eq!((known(TickOrigin::Missing), known(TickOrigin::AfterGap), known(TickOrigin::Recorded)), (20, 200, 980));
    for missing in &moments[500..520] {
        assert_eq!((missing.tick.valid, missing.event.as_str()), (0, "before"));
        // The mean of 30, 10, 10 and 10 mW.
        assert!((missing.tick.power_w[0] / 0.015 - 1.0).abs() < 0.05, "{:?}", missing.tick.power_w);
    }
    assert_eq!(
        (moments[520].known, moments[719].known, moments[720].known),
        (TickOrigin::AfterGap, TickOrigin::AfterGap, TickOrigin::Recorded)
    );
    assert!((moments[520].time_s - 205.2).abs() < 1e-9 && moments[520].event == "after");
}

#[test]
fn of_a_gap_of_days_no_more_than_an_hour_is_gone_through() {
    let folder = tempfile::tempdir().unwrap();
    let times_s: Vec<f64> = (0..10).map(|n| f64::from(n) + if n < 5 { 0.0 } else { 500_000.0 }).collect();
    let moments = replayed(&recording(folder.path(), &times_s, Some("1"))).unwrap();
    assert_eq!(moments.len(), 10 + 3600);
    assert_eq!(moments.last().unwrap().tick.tick, 500_009);
}

/// A row each 3000 s would be as much work as ten years of rows.
#[test]
fn rows_far_apart_cost_no_more_than_rows() {
    let folder = tempfile::tempdir().unwrap();
    let times_s: Vec<f64> = (0..600).map(|n| 3000.0 * f64::from(n / 2) + 0.01 * f64::from(n % 2)).collect();
    let moments = replayed(&recording(folder.path(), &times_s, Some("0.01"))).unwrap();
    let (longest, rows) = (360_000, times_s.len());
    assert!(
        (longest..=longest + (GONE_THROUGH_A_ROW as usize + 1) * rows).contains(&moments.len()),
        "{}",
        moments.len()
    );
    let recorded = moments.iter().filter(|moment| moment.known != TickOrigin::Missing).skip(2);
    assert!(
        recorded.clone().count() == rows - 2 && recorded.clone().all(|moment| moment.known == TickOrigin::AfterGap)
    );
}

#[test]
fn times_that_cannot_be_are_refused_with_their_row() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |change: &dyn Fn(&mut [f64]), period: Option<&str>| {
        let mut times_s: Vec<f64> = (0..20).map(|n| 0.01 * f64::from(n)).collect();
        change(&mut times_s);
        replayed(&recording(folder.path(), &times_s, period)).unwrap_err()
    };
    let back = refused(&|times_s| times_s[10] = 0.03, Some("0.01"));
    assert!(back.ends_with("r.parquet: row 11: `time_s` goes from 0.09 s to 0.03 s, but time must ascend"), "{back}");
    let half = refused(&|times_s| times_s[10] = 0.095, None);
    assert!(
        half.ends_with(
            "row 11: `time_s` moves on by 0.005 s, by 0.01 s elsewhere; resample the recording or cut it there"
        ),
        "{half}"
    );
    let other = refused(&|_| {}, Some("0.02"));
    assert!(
        other.ends_with("says that its sample period is 0.02 s, but its rows are 0.01 s apart: one of them is wrong"),
        "{other}"
    );
    let none = replayed(&recording(folder.path(), &[], Some("0.01"))).unwrap_err();
    assert!(none.ends_with("r.parquet: has columns but no rows"), "{none}");
}

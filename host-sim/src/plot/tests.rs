use super::*;
use crate::recording::{Collector, Layout, Metadata, Row};

const ELEMENTS: [&str; 6] = ["sector1", "sector2", "sector3", "sector4", "core1", "core2"];

/// A run in which everything is as noisy as can be, so that no neighbours can be merged.
fn noisy(rows: u32, metadata: &[(&str, &str)]) -> Recording {
    let metadata: Metadata = metadata.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let layout = Layout { elements: ELEMENTS.map(str::to_owned).to_vec(), wind: true, observed: Vec::new() };
    let mut collector = Collector::new(layout, &metadata);
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    for n in 0..rows {
        let temperature_c = std::array::from_fn::<f32, 6, _>(|_| -23.0 + random());
        let power_w = std::array::from_fn::<f32, 6, _>(|_| 0.04 * random());
        let row = Row {
            time_s: f64::from(n) * 0.01,
            temperature_c: &temperature_c,
            power_w: &power_w,
            equivalent_power_w: &[],
            heaters: (random() * 64.0) as u16,
            event: ["calm", "gust <&> \"böe\""][(n / 1000 % 2) as usize],
            state: if n < rows - rows / 10 { "running" } else { "tripped:open:sector3" },
            wind_m_s: Some([0; 3].map(|_| f64::from(random()))),
        };
        collector.push(&row).unwrap();
    }
    collector.finish(&Metadata::new())
}

#[test]
fn a_hundred_thousand_ticks_stay_a_small_picture() {
    let experiment = "[drives]\nsector1 = { temperature_c = -22.5 }\ncore1 = \"passive\"\n";
    let svg = figure::svg(&noisy(100_000, &[("title", "A < B"), ("experiment", experiment)])).unwrap();
    // The bar of the design, with noise that no real run has.
    assert!(svg.len() < 500_000, "{}", svg.len());
    for text in [
        "A &lt; B",
        "Heating power",
        "Off the set-point",
        "every bit of 200 ticks",
        "sector4",
        "tripped: open, sector3",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(svg.starts_with("<svg width=\"1200\""));
}

#[test]
fn short_runs_are_drawn_too() {
    for rows in [1, 2, 3, 50, 300] {
        let svg = figure::svg(&noisy(rows, &[])).unwrap();
        assert!(!svg.contains("NaN"), "{rows}");
    }
}

#[test]
fn readings_that_are_missing_leave_gaps() {
    let mut recording = noisy(1000, &[]);
    for column in &mut recording.columns {
        if let crate::recording::Values::Numbers(numbers) = &mut column.values
            && column.name != "time_s"
        {
            numbers.iter_mut().skip(200).for_each(|number| *number = f64::NAN);
        }
    }
    assert!(!figure::svg(&recording).unwrap().contains("NaN"));
}

fn read(content: &str) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, content).unwrap();
    Recording::read(&path).unwrap()
}

#[test]
fn panels_without_columns_are_left_out_and_a_foreign_table_is_refused() {
    let svg = figure::svg(&read("time_s,temperature_c:probe\n0,1\n1,2\n2,4\n")).unwrap();
    assert!(svg.contains("Temperature") && !svg.contains("Heating power") && !svg.contains("Heater bits"));
    let error = figure::svg(&read("t,u\n0,1\n1,2\n")).unwrap_err().to_string();
    assert!(
        error.ends_with("r.csv: holds none of the columns that a run records, such as temperature_c:<element>"),
        "{error}"
    );
}

#[test]
fn only_pictures_that_can_be_written_are_begun() {
    assert_eq!(Canvas::create(Path::new("a.png")).err().unwrap().to_string(), "a.png: a picture's name ends in .svg");
    assert!(
        Canvas::create(Path::new("no/such/a.svg")).err().unwrap().to_string().contains("there is no folder `no/such`")
    );
    let folder = tempfile::tempdir().unwrap();
    drop(Canvas::create(&folder.path().join("a.svg")).unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

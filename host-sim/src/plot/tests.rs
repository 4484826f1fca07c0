use super::*;
use crate::recording::{Collector, Layout, Metadata, Row};

const ELEMENTS: [&str; 6] = ["sector1", "sector2", "sector3", "sector4", "core1", "core2"];

/// A run in which everything is as noisy as can be, so that no neighbours can be merged.
fn noisy(rows: u32, metadata: &[(&str, &str)]) -> Recording {
    noisy_in(rows, metadata, false)
}

/// The same, in a gas that swings or does not.
fn noisy_in(rows: u32, metadata: &[(&str, &str)], gas: bool) -> Recording {
    let metadata: Metadata = metadata.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let layout = Layout {
        elements: ELEMENTS.map(str::to_owned).to_vec(),
        wind: true,
        gas,
        observed: Vec::new(),
        answers: Vec::new(),
    };
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
            gas_temperature_c: gas.then(|| -53.0 + (0.01 * f64::from(n)).sin()),
            answer: &[],
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
fn of_more_conditions_than_can_be_seen_the_number_is_told() {
    let labelled = |rows: u32| {
        let mut recording = noisy(3000, &[]);
        let mut words = crate::recording::Words::default();
        (0..3000_u32).for_each(|n| words.push(&format!("wind {}", n / rows)));
        let events = recording.columns.iter_mut().find(|column| column.name == crate::recording::EVENT).unwrap();
        events.values = crate::recording::Values::Words(words);
        figure::svg(&recording).unwrap()
    };
    assert!(labelled(10).contains("300 conditions, “wind 0” to “wind 299”"));
    let few = labelled(1000);
    assert!(!few.contains("conditions") && few.contains("wind 2"));
}

#[test]
fn a_gas_that_swings_is_drawn_among_the_temperatures() {
    let (still, swinging) = [false, true].map(|gas| figure::svg(&noisy_in(2000, &[], gas)).unwrap()).into();
    // One more curve and one more name; the elements are at -23 °C, so that the gas widens the axis.
    assert!(swinging.contains(">\ngas\n<") && !still.contains(">\ngas\n<"));
    assert!(swinging.contains("−50") && !still.contains("−50"));
    assert!(!swinging.contains("NaN"));
}

#[test]
fn short_runs_are_drawn_too() {
    for rows in [1, 2, 3, 50, 300] {
        let svg = figure::svg(&noisy(rows, &[])).unwrap();
        assert!(!svg.contains("NaN"), "{rows}");
    }
}

/// Columns of temperature over 100 s.
fn temperatures(names: &[&str], experiment: &str, celsius: impl Fn(u32) -> f64) -> Recording {
    // A line break in metadata is written as in a string.
    let mut text = format!("# experiment: {}\n", experiment.replace('\n', "\\n"));
    let columns: Vec<String> = names.iter().map(|name| format!("temperature_c:{name}")).collect();
    text += &format!("time_s,{}\n", columns.join(","));
    for n in 0..100 {
        text += &format!("{n}{}\n", format!(",{}", celsius(n)).repeat(names.len()));
    }
    read(&text)
}

#[test]
fn after_a_change_the_new_set_point_counts() {
    let drives = "[drives]\nboom = { temperature_c = 30.0 }\n";
    let change = "[[changes]]\nstart_s = 50.0\ndrives = { boom = { temperature_c = 25.0 } }\n";
    // Held at 30 °C from the first tick; after the change it cools by 1 K a tick, and then stays at 25 °C.
    let celsius = |n: u32| if n < 50 { 30.0 } else { (80.0 - f64::from(n)).max(25.0) };
    let recording = temperatures(&["boom"], &format!("{drives}{change}"), celsius);
    let content = content::Content::of(&recording).unwrap();
    let means: Vec<f64> = content.deviations[0].bins.iter().map(|bin| bin.mean).collect();
    assert_eq!(means.len(), 100);
    assert!(means[..50].iter().chain(&means[55..]).all(|mean_mk| *mean_mk == 0.0), "{means:?}");
    assert!(means[50..55].iter().all(|mean_mk| mean_mk.is_nan()), "{means:?}");
}

#[test]
fn thirteen_elements_have_thirteen_colours_and_a_legend_inside_the_picture() {
    let names: Vec<String> = (0..13).map(|i| format!("card{}-die{}", i / 4, i % 4)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let recording = temperatures(&names, "", f64::from);
    let content = content::Content::of(&recording).unwrap();
    let mut colours: Vec<_> = content.elements.iter().map(|(_, colour)| (colour.0, colour.1, colour.2)).collect();
    colours.sort_unstable();
    colours.dedup();
    assert_eq!(colours.len(), 13);
    let svg = figure::svg(&recording).unwrap();
    for (at, _) in svg.match_indices("<text") {
        let x = svg[at..].split_once("x=\"").unwrap().1.split_once('"').unwrap().0;
        assert!((0.0..4800.0).contains(&x.parse::<f64>().unwrap()), "{x}");
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

/// Answers of 400 winds that go round once, with the true wind; `metadata` are lines before the header.
fn answers(parts: &[&str], metadata: &str, doubts: impl Fn(usize) -> u16) -> Recording {
    let named = |prefix: &str| parts.iter().map(|part| format!(",{prefix}{part}")).collect::<String>();
    let mut text = format!("{metadata}time_s,answer_x_m_s,answer_y_m_s,answer_z_m_s,answer_speed_m_s,");
    text += "answer_speed_error_m_s,answer_direction_error_deg,answer_gas_c";
    text +=
        &format!("{}{},answer_doubts,wind_x_m_s,wind_y_m_s,wind_z_m_s\n", named("conductance_w_k:"), named("raw_w_k:"));
    for n in 0..400 {
        let azimuth = (0.9 * n as f64).to_radians();
        let (x, y) = (3.0 * azimuth.cos(), 3.0 * azimuth.sin());
        let measured = ",0.0011".repeat(2 * parts.len());
        text += &format!("{n},{x},{y},4,5,0.1,1.5,-53{measured},{},{x},{y},4\n", doubts(n));
    }
    read(&text)
}

const SECTORS: [&str; 4] = ["sector1", "sector2", "sector3", "sector4"];

#[test]
fn answers_by_themselves_have_a_page_of_their_own() {
    let svg = figure::svg(&answers(&SECTORS, "", |n| if n == 77 { 8 } else { 0 })).unwrap();
    for text in
        ["Wind speed", "Azimuth", "Elevation", "Conductance to the gas", "ambiguous", "400 answers", "true wind"]
    {
        assert!(svg.contains(text), "{text}");
    }
    // The gas stands still; nothing is known of temperatures and bits; one doubt occurs.
    for text in ["\nGas\n", "Temperature", "Heater bits", "NaN", "saturated"] {
        assert!(!svg.contains(text), "{text}");
    }
    let nothing_doubted = figure::svg(&answers(&SECTORS, "", |_| 0)).unwrap();
    assert!(nothing_doubted.contains("\nnone\n"));
}

#[test]
fn an_answer_without_direction_leaves_a_gap_and_still_has_a_speed() {
    let recording = answers(&SECTORS, "", |n| if (100..300).contains(&n) { 32 } else { 0 });
    let answer = content::Content::of(&recording).unwrap().answer.unwrap();
    let told = |bins: &[reduce::Bin]| bins.iter().filter(|bin| bin.mean.is_finite()).count();
    assert_eq!(told(&answer.speed.answer), 400);
    let (azimuth, elevation) = (answer.azimuth.unwrap(), answer.elevation.unwrap());
    assert_eq!((told(&azimuth.answer), told(&elevation.answer)), (200, 200));
    assert_eq!(told(azimuth.truth.as_ref().unwrap()), 400);
    // sin(elevation) = 4/5; an error of 1.5° on the sphere is 1.5°/cos(elevation) = 2.5° of azimuth.
    assert!((elevation.answer[0].mean - 53.130_102).abs() < 1e-5);
    assert!((azimuth.error[0] - 2.5).abs() < 1e-9 && (elevation.error[0] - 1.5).abs() < 1e-12);
    assert!((azimuth.answer[50].mean - 45.0).abs() < 1e-9);
}

#[test]
fn a_head_of_two_hemispheres_has_one_angle() {
    let axis = "[[calibration.parts]]\\naxis = [0.0, 0.0, 2.0]\\n[[calibration.parts]]\\naxis = [0.0, 0.0, -2.0]\\n";
    // All of its answers are undetermined: that is no reason for a gap.
    let recording = answers(&["hemisphere1", "hemisphere2"], &format!("# head: {axis}\n"), |_| 16);
    let recording_of = content::Content::of(&recording).unwrap();
    let answer = recording_of.answer.as_ref().unwrap();
    assert!(answer.azimuth.is_none() && answer.elevation.is_none());
    // cos(angle) = 4/5
    let angle = answer.angle.as_ref().unwrap();
    assert!(angle.answer.iter().all(|bin| (bin.mean - 36.869_898).abs() < 1e-5));
    let svg = figure::svg(&recording).unwrap();
    assert!(svg.contains("Angle to the head") && !svg.contains("Azimuth"));
}

#[test]
fn a_run_that_answers_shows_them_over_the_true_wind() {
    let mut recording = answers(&SECTORS, "", |_| 0);
    let temperature = crate::recording::Values::Numbers(vec![-23.0; 400]);
    recording.columns.push(crate::recording::Column { name: "temperature_c:sector1".into(), values: temperature });
    let svg = figure::svg(&recording).unwrap();
    for text in ["answers over the true wind", "Doubts", "Temperature", "400 ticks"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(!svg.contains("Azimuth") && !svg.contains("Conductance"));
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

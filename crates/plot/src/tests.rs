use super::*;
use recording::{Collector, Metadata, Recording, RecordingLayout, RecordingRow};
use std::path::Path;

const ELEMENTS: [&str; 6] = ["sector1", "sector2", "sector3", "sector4", "core1", "core2"];

/// The picture of a recording.
fn drawn(recording: &Recording) -> String {
    run::figure(recording).unwrap().svg()
}

/// The bins of the first trace of a chart with this label.
fn bins(figure: &Figure, caption: &str, label: &str) -> Vec<Bin> {
    let chart = figure.charts().find(|chart| chart.caption() == caption).unwrap();
    chart.traces.iter().find(|trace| trace.label == label).unwrap().bins.clone()
}

/// A run in which everything is as noisy as can be, so that no neighbours can be merged.
pub(crate) fn noisy(rows: u32, metadata: &[(&str, &str)]) -> Recording {
    noisy_in(rows, metadata, false)
}

/// The same, in a gas that swings or does not.
fn noisy_in(rows: u32, metadata: &[(&str, &str)], gas: bool) -> Recording {
    let metadata: Metadata = metadata.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let layout = RecordingLayout {
        elements: ELEMENTS.map(str::to_owned).to_vec(),
        true_wind: true,
        gas,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
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
        let row = RecordingRow {
            time_s: f64::from(n) * 0.01,
            temperature_c: &temperature_c,
            power_w: &power_w,
            equivalent_power_w: &[],
            heaters: (random() * 64.0) as usize,
            event: ["calm", "gust <&> \"böe\""][(n / 1000 % 2) as usize],
            state: if n < rows - rows / 10 { "running" } else { "tripped:open:sector3" },
            true_wind_m_s: Some([0; 3].map(|_| f64::from(random()))),
            gas_temperature_c: gas.then(|| -53.0 + libm::sin(0.01 * f64::from(n))),
            estimate: &[],
        };
        collector.push(&row).unwrap();
    }
    collector.finish(&Metadata::new())
}

#[test]
fn a_hundred_thousand_ticks_stay_a_small_picture() {
    let experiment = "[drives]\nsector1 = { temperature_c = -22.5 }\ncore1 = \"passive\"\n";
    let svg = drawn(&noisy(100_000, &[("title", "A < B"), ("experiment", experiment)]));
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
    assert!(svg.starts_with("<svg width=\"180mm\""));
}

#[test]
fn of_more_conditions_than_can_be_seen_the_number_is_reported() {
    let labelled = |rows: u32| {
        let mut recording = noisy(3000, &[]);
        let mut words = recording::ColumnWords::default();
        (0..3000_u32).for_each(|n| words.push(&format!("wind {}", n / rows)));
        let events = recording.columns.iter_mut().find(|column| column.name == recording::EVENT).unwrap();
        events.values = recording::ColumnValues::Words(words);
        drawn(&recording)
    };
    assert!(labelled(10).contains("300 conditions, “wind 0” to “wind 299”"));
    let few = labelled(1000);
    assert!(!few.contains("conditions") && few.contains("wind 2"));
}

#[test]
fn a_gas_that_swings_is_drawn_among_the_temperatures() {
    let (still, swinging) = [false, true].map(|gas| drawn(&noisy_in(2000, &[], gas))).into();
    // One more curve and one more name; the elements are at -23 °C, so that the gas widens the
    // axis.
    assert!(swinging.contains(">gas<") && !still.contains(">gas<"));
    assert!(swinging.contains("−50") && !still.contains("−50"));
    assert!(!swinging.contains("NaN"));
}

#[test]
fn short_runs_are_drawn_too() {
    for rows in [1, 2, 3, 50, 300] {
        let svg = drawn(&noisy(rows, &[]));
        assert!(!svg.contains("NaN"), "{rows}");
    }
}

/// Columns of temperature over 100 s.
fn temperatures(names: &[&str], experiment: &str, celsius: impl Fn(u32) -> f64) -> Recording {
    // A line break in metadata is written as in a string.
    let mut text = format!("# experiment: {}\n", experiment.replace('\n', "\\n"));
    let columns: Vec<String> = names.iter().map(|name| recording::column_name(recording::TEMPERATURE, name)).collect();
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
    // Held at 30 °C from the first tick; after the change it cools by 1 K a tick, and then stays at
    // 25 °C.
    let celsius = |n: u32| if n < 50 { 30.0 } else { (80.0 - f64::from(n)).max(25.0) };
    let recording = temperatures(&["boom"], &format!("{drives}{change}"), celsius);
    let bins = bins(&run::figure(&recording).unwrap(), "Off the set-point", "");
    let means: Vec<f64> = bins.iter().map(|bin| bin.mean).collect();
    assert_eq!(means.len(), 100);
    assert!(means[..50].iter().chain(&means[55..]).all(|mean_mk| *mean_mk == 0.0), "{means:?}");
    assert!(means[50..55].iter().all(|mean_mk| mean_mk.is_nan()), "{means:?}");
}

#[test]
fn thirteen_elements_have_thirteen_colours_and_a_legend_inside_the_picture() {
    let names: Vec<String> = (0..13).map(|i| format!("card{}-die{}", i / 4, i % 4)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let recording = temperatures(&names, "", f64::from);
    let figure = run::figure(&recording).unwrap();
    let traces = &figure.charts().find(|chart| chart.caption() == "Temperature").unwrap().traces;
    let mut colours: Vec<_> = traces.iter().map(|trace| trace.pen.unwrap().colour.rgb).collect();
    colours.sort_unstable();
    colours.dedup();
    assert_eq!(colours.len(), 13);
    let svg = drawn(&recording);
    assert!(svg.contains(">card3"));
}

#[test]
fn readings_that_are_missing_leave_gaps() {
    let mut recording = noisy(1000, &[]);
    for column in &mut recording.columns {
        if let recording::ColumnValues::Numbers(numbers) = &mut column.values
            && column.name != "time_s"
        {
            numbers.iter_mut().skip(200).for_each(|number| *number = f64::NAN);
        }
    }
    assert!(!drawn(&recording).contains("NaN"));
}

fn read(content: &str) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, content).unwrap();
    Recording::read(&path).unwrap()
}

#[test]
fn panels_without_columns_are_left_out_and_a_foreign_table_is_refused() {
    let svg = drawn(&read("time_s,temperature_c_probe\n0,1\n1,2\n2,4\n"));
    assert!(svg.contains("Temperature") && !svg.contains("Heating power") && !svg.contains("Heater bits"));
    let error = run::figure(&read("t,u\n0,1\n1,2\n")).unwrap_err().to_string();
    assert!(
        error.ends_with("r.csv: holds none of the columns that a run records, such as temperature_c_<element>"),
        "{error}"
    );
}

/// Estimates of 400 winds that go round once, with the true wind; `metadata` are lines before the
/// header.
pub(crate) fn estimates(parts: &[&str], metadata: &str, flags: impl Fn(usize) -> u16) -> Recording {
    let named = |prefix: &str| parts.iter().map(|part| format!(",{prefix}{part}")).collect::<String>();
    let mut text = format!("{metadata}time_s,wind_x_m_s,wind_y_m_s,wind_z_m_s,wind_speed_m_s,");
    text += "wind_speed_u_m_s,wind_direction_u_deg,wind_gas_temperature_c";
    text += &format!(
        "{}{},quality_flags,true_wind_x_m_s,true_wind_y_m_s,true_wind_z_m_s\n",
        named("conductance_w_k_"),
        named("raw_w_k_")
    );
    for n in 0..400 {
        let azimuth = (0.9 * n as f64).to_radians();
        let (x, y) = (3.0 * libm::cos(azimuth), 3.0 * libm::sin(azimuth));
        let measured = ",0.0011".repeat(2 * parts.len());
        text += &format!("{n},{x},{y},4,5,0.1,1.5,-53{measured},{},{x},{y},4\n", flags(n));
    }
    read(&text)
}

pub(crate) const SECTORS: [&str; 4] = ["sector1", "sector2", "sector3", "sector4"];

#[test]
fn wind_estimates_by_themselves_have_a_figure_of_their_own() {
    let svg = drawn(&estimates(&SECTORS, "", |n| if n == 77 { 8 } else { 0 }));
    for text in
        ["Wind speed", "Azimuth", "Elevation", "Conductance to the gas", "ambiguous", "400 wind estimates", "true wind"]
    {
        assert!(svg.contains(text), "{text}");
    }
    // The gas stands still; nothing is known of temperatures and bits; one flag occurs.
    for text in [">Gas<", "Temperature", "Heater bits", "NaN", "saturated"] {
        assert!(!svg.contains(text), "{text}");
    }
    let no_flags = drawn(&estimates(&SECTORS, "", |_| 0));
    assert!(no_flags.contains(">none<"));
}

#[test]
fn azimuths_of_a_head_with_a_heading_state_where_north_is() {
    // x points to north-west: north is an eighth of a turn to the right of it.
    for (heading, said) in [("", "goes to<"), ("# heading_deg: 315\n", "goes to; north is -45°<")] {
        let svg = drawn(&estimates(&SECTORS, heading, |_| 0));
        assert!(svg.contains(said), "{said}");
    }
}

#[test]
fn an_estimate_without_direction_leaves_a_gap_and_still_has_a_speed() {
    let recording = estimates(&SECTORS, "", |n| if (100..300).contains(&n) { 32 } else { 0 });
    let figure = run::figure(&recording).unwrap();
    let known = |bins: &[Bin]| bins.iter().filter(|bin| bin.mean.is_finite()).count();
    let of = |caption, label| bins(&figure, caption, label);
    assert_eq!(known(&of("Wind speed", "estimate")), 400);
    let (azimuth, elevation) = (of("Azimuth", "estimate"), of("Elevation", "estimate"));
    assert_eq!((known(&azimuth), known(&elevation)), (200, 200));
    assert_eq!(known(&of("Azimuth", "true wind")), 400);
    // sin(elevation) = 4/5; an uncertainty of 1.5° on the sphere is 1.5°/cos(elevation) = 2.5° of
    // azimuth.
    assert!((elevation[0].mean - 53.130_102).abs() < 1e-5);
    let uncertainty = |caption| bins(&figure, caption, "")[0].most - bins(&figure, caption, "estimate")[0].mean;
    assert!((uncertainty("Azimuth") - 2.5).abs() < 1e-9 && (uncertainty("Elevation") - 1.5).abs() < 1e-12);
    assert!((azimuth[50].mean - 45.0).abs() < 1e-9);
}

#[test]
fn a_head_of_two_hemispheres_has_one_angle() {
    // A number of a TOML file needs no decimal point.
    let axis = "[[calibration.surfaces]]\\naxis = [0, 0, 2]\\n[[calibration.surfaces]]\\naxis = [0.0, 0.0, -2.0]\\n";
    // All of its estimates are undetermined: that is no reason for a gap.
    let recording = estimates(&["hemisphere1", "hemisphere2"], &format!("# head: {axis}\n"), |_| 16);
    let figure = run::figure(&recording).unwrap();
    // cos(angle) = 4/5
    let angle = bins(&figure, "Angle to the head's axis", "estimate");
    assert!(angle.len() == 400 && angle.iter().all(|bin| (bin.mean - 36.869_898).abs() < 1e-5));
    let svg = figure.svg();
    assert!(svg.contains("Angle to the head") && !svg.contains("Azimuth") && !svg.contains("Elevation"));
}

#[test]
fn a_head_of_a_plane_has_an_azimuth_in_it_and_an_error_of_direction() {
    let surface = "[[calibration.surfaces]]\\naxis = [1.0, 0.0, 0.0]\\ncorner = [0.0, 0.0, 1.0]\\n";
    for form in ["cylinder", "wires"] {
        let head = format!("[calibration]\\nform = \"{form}\"\\n{}", surface.repeat(2));
        // All of its estimates are undetermined: that is no reason for a gap.
        let figure = run::figure(&estimates(&["wire1", "wire2"], &format!("# head: {head}\n"), |_| 16)).unwrap();
        let azimuth = bins(&figure, "Azimuth", "estimate");
        assert!((azimuth[50].mean - 45.0).abs() < 1e-9);
        assert_eq!(azimuth.iter().filter(|bin| bin.mean.is_finite()).count(), 400);
        // The wind across the plane is no part of what it could output: 3 of 5 m/s are in it.
        assert!(bins(&figure, "Wind speed", "true wind").iter().all(|bin| (bin.mean - 3.0).abs() < 1e-9));
        let error = bins(&figure, "Direction error", "error");
        // The estimates have 4 m/s across the plane: they are 53° off what lies in it.
        assert!(error.iter().all(|bin| (bin.mean - 53.130_102).abs() < 1e-5));
        assert!(!figure.charts().any(|chart| chart.caption() == "Elevation"));
    }
}

#[test]
fn estimates_without_any_direction_have_no_panels_of_it() {
    let head = "[calibration]\\nform = \"single\"\\n[[calibration.surfaces]]\\naxis = [1.0, 0.0, 0.0]\\n";
    // Undetermined and without a direction.
    let figure = run::figure(&estimates(&["wire"], &format!("# head: {head}\n"), |_| 16 + 32)).unwrap();
    let captions: Vec<&str> = figure.charts().map(Chart::caption).collect();
    assert!(captions.contains(&"Wind speed") && captions.contains(&"Speed error"), "{captions:?}");
    for caption in ["Azimuth", "Elevation", "Direction error", "Direction errors"] {
        assert!(!captions.contains(&caption), "{captions:?}");
    }
}

#[test]
fn histograms_have_the_estimates_that_count() {
    let dots = |metadata: &str| {
        let figure = run::figure(&estimates(&SECTORS, metadata, |_| 0)).unwrap();
        let chart = figure.charts().find(|chart| chart.caption() == "Estimate over truth").unwrap();
        chart.traces.iter().map(|trace| trace.points.len()).max().unwrap()
    };
    assert_eq!([dots(""), dots("# counted_from_s: 300\n")], [200, 100]);
}

#[test]
fn a_run_with_wind_estimates_shows_them_over_the_true_wind() {
    let mut recording = estimates(&SECTORS, "", |_| 0);
    let temperature = recording::ColumnValues::Numbers(vec![-23.0; 400]);
    recording.columns.push(recording::RecordingColumn { name: "temperature_c_sector1".into(), values: temperature });
    let svg = drawn(&recording);
    for text in ["estimates over the true wind", "Quality flags", "Temperature", "400 ticks"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(!svg.contains("Azimuth") && !svg.contains("Conductance"));
}

#[test]
fn only_pictures_that_can_be_written_are_begun() {
    assert_eq!(
        Canvas::create(Path::new("a.gif")).err().unwrap().to_string(),
        "a.gif: a picture's name ends in .svg, .pdf or .png"
    );
    assert!(
        Canvas::create(Path::new("no/such/a.svg")).err().unwrap().to_string().contains("there is no folder `no/such`")
    );
    let folder = tempfile::tempdir().unwrap();
    drop(Canvas::create(&folder.path().join("a.svg")).unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_warm_up_leaves_the_temperature_panel() {
    let experiment = "[drives]\nboom = { temperature_c = 30.0 }\n";
    // It warms up from −50 °C by 2 K a tick, and is then held within 0.1 K.
    let celsius = |n: u32| (2.0 * f64::from(n) - 50.0).min(30.0) + 0.05 * f64::from(n % 2);
    let figure = run::figure(&temperatures(&["boom"], experiment, celsius)).unwrap();
    let chart = figure.charts().find(|chart| chart.caption() == "Temperature").unwrap();
    let (ends, _) = chart.reach();
    assert!(ends[0] > 29.5 && ends[1] < 30.5, "{ends:?}");
    assert!(figure.svg().contains("the warm-up from −50 °C leaves the panel"));
    // Without a set-point nothing is a warm-up.
    assert!(!drawn(&temperatures(&["boom"], "", celsius)).contains("warm-up"));
}

#[test]
fn a_rare_flag_is_a_hair_with_its_share_in_words() {
    let figure = run::figure(&estimates(&SECTORS, "", |n| if n == 77 { 8 } else { 0 })).unwrap();
    let chart = figure.charts().find(|chart| chart.caption() == "Quality flags").unwrap();
    assert_eq!(chart.traces[0].label, "ambiguous 0.2 %");
    let often = run::figure(&estimates(&SECTORS, "", |n| if n % 4 == 0 { 8 } else { 0 })).unwrap();
    assert!(often.svg().contains("ambiguous 25 %"));
}

#[test]
fn errors_against_the_true_wind_are_drawn_over_time_and_in_all() {
    let recording = estimates(&SECTORS, "", |_| 0);
    let figure = run::figure(&recording).unwrap();
    let captions: Vec<&str> = figure.charts().map(Chart::caption).collect();
    for caption in ["Speed error", "Direction error", "Estimate over truth"] {
        assert!(captions.contains(&caption), "{captions:?}");
    }
    // Estimates without any error.
    assert!(bins(&figure, "Speed error", "error").iter().all(|bin| bin.mean.abs() < 1e-9));
    let svg = figure.svg();
    for title in ["Speed error (m/s)", "Direction error (°)", "True speed (m/s)", "Estimated speed (m/s)"] {
        assert!(svg.contains(title), "{title}");
    }
}

/// Estimates of winds of ten estimates each, 5 % too fast.
fn sweep(winds: usize) -> Recording {
    let mut text = "time_s,event,wind_x_m_s,wind_y_m_s,wind_z_m_s,wind_speed_m_s,wind_speed_u_m_s,".to_owned();
    text += "wind_direction_u_deg,quality_flags,true_wind_x_m_s,true_wind_y_m_s,true_wind_z_m_s\n";
    for n in 0..10 * winds {
        let wind = n / 10;
        let (speed, azimuth) = (2.0 + 0.01 * wind as f64, (37.0 * wind as f64).to_radians());
        let [x, y] = [speed * libm::cos(azimuth), speed * libm::sin(azimuth)];
        text += &format!("{n},w{wind},{},{},0,{},0.1,1,0,{x},{y},0\n", 1.05 * x, 1.05 * y, 1.05 * speed);
    }
    read(&text)
}

#[test]
fn many_winds_are_drawn_by_wind() {
    let figure = run::figure(&sweep(100)).unwrap();
    let captions: Vec<&str> = figure.charts().map(Chart::caption).collect();
    assert!(!captions.contains(&"Azimuth") && captions.contains(&"Quality flags"), "{captions:?}");
    let of = |caption: &str| figure.charts().filter(|chart| chart.caption() == caption).collect::<Vec<_>>();
    let speed = of("Speed error");
    assert_eq!(speed.iter().map(|chart| chart.x_name()).collect::<Vec<_>>(), ["True speed", "True azimuth"]);
    assert!(speed.iter().all(|chart| chart.traces[0].points.len() == 100));
    assert!(speed[0].traces[0].points.iter().all(|(_, percent)| (percent - 5.0).abs() < 1e-6));
    assert!(speed[0].traces[0].errors.len() == 100);
    assert!(figure.subtitle.contains("100 winds"));
    // Few are drawn over time.
    let few = run::figure(&sweep(10)).unwrap();
    assert!(few.charts().any(|chart| chart.caption() == "Azimuth"));
}

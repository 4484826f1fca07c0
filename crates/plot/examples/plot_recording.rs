//! Draws a recording, here a table of a heated probe, and lists the charts of its figure.

use recording::Recording;

const TABLE: &str = "\
# title: A probe that is heated for ten seconds
time_s,temperature_c_probe,power_w_probe,heater_probe
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let table = folder.path().join("probe.csv");
    let mut text = TABLE.to_owned();
    let mut temperature_c = 20.0;
    for n in 0..600 {
        let power_w = if n < 100 { 0.05 } else { 0.0 };
        let bit = u8::from(power_w > 0.0);
        text += &format!("{},{temperature_c},{power_w},{bit}\n", f64::from(n) * 0.1);
        // 200 K/W and a time constant of 10 s.
        temperature_c += 0.01 * (20.0 + 200.0 * power_w - temperature_c);
    }
    std::fs::write(&table, text)?;

    let figure = plot::run::figure(&Recording::read(&table)?)?;
    println!("{} charts", figure.charts().count());
    for chart in figure.charts() {
        println!("- {}", chart.caption());
    }
    let svg = figure.svg();
    plot::Canvas::create(&folder.path().join("probe.svg"))?.draw(&figure)?;
    println!("{}", svg.lines().next().unwrap_or_default());
    Ok(())
}

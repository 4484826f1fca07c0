//! Simulates the sensor board's analogue part by ngspice: one channel, the cut-off of the
//! platinum's supply, the head's temperature, each with single faults.
//!
//! `hardware/results.csv` has a line for every number: netlist, case, the parameters that the case
//! overrides, the quantity (a `.meas` or a printed vector of the netlist), the bounds that the
//! design wants of it, and what was simulated last. A number outside its bounds fails, and so does
//! one that has moved by more than [`TOLERANCE`], which another version of ngspice does not. The
//! drawing of the cut-off has the netlist's values.

use crate::{install, shell};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs;
use std::path::Path;

const FOLDER: &str = "hardware";
const RESULTS: &str = "hardware/results.csv";
/// The cut-off's netlist, and its drawing in the pages.
const CUT_OFF: [&str; 2] = ["hardware/cut-off.cir", "docs/images/cut-off.svg"];
/// Share of the number, or of its larger bound, by which it may move.
const TOLERANCE: f64 = 0.03;
/// Stands for a crossing that does not come.
const NEVER: &str = "never";
const COLUMNS: usize = 7;

#[derive(Args, Default)]
pub struct HardwareOptions {
    /// Write what is simulated into hardware/results.csv; bounds hold all the same
    #[arg(long)]
    write: bool,
}

/// Values that a netlist has printed, by name; a crossing that does not come is missing.
type Measured = BTreeMap<String, f64>;

pub fn run(options: &HardwareOptions) -> Result<()> {
    install::ngspice()?;
    let path = shell::root().join(RESULTS);
    let text = fs::read_to_string(&path).with_context(|| format!("{RESULTS} cannot be read"))?;
    let mut simulated: BTreeMap<[&str; 2], Measured> = BTreeMap::new();
    let (mut written, mut faults) = (String::new(), Vec::new());
    for line in text.lines() {
        let cells: Vec<_> = line.split(',').collect();
        let &[netlist, case, parameters, quantity, least, most, last] = cells.as_slice() else {
            bail!("{RESULTS}: {COLUMNS} cells a line, not {}: {line}", cells.len());
        };
        if netlist == "netlist" {
            written += &format!("{line}\n");
            continue;
        }
        let measured = match simulated.entry([netlist, parameters]) {
            Entry::Occupied(done) => done.into_mut(),
            Entry::Vacant(new) => new.insert(simulate(netlist, case, parameters)?),
        };
        let value = measured.get(quantity).copied();
        let now = value.map_or_else(|| NEVER.to_owned(), |value| format!("{value:.4e}"));
        let fault =
            outside(value, least, most)?.or(if options.write { None } else { moved(value, last, [least, most]) });
        faults.extend(fault.map(|fault| format!("{netlist}, {case}: {quantity} is {now}, {fault}")));
        written += &format!("{netlist},{case},{parameters},{quantity},{least},{most},{now}\n");
    }
    if options.write {
        fs::write(&path, written).with_context(|| format!("{RESULTS} cannot be written"))?;
    }
    let [netlist, drawing] = CUT_OFF.map(|name| fs::read_to_string(shell::root().join(name)));
    faults.extend(drawn_otherwise(&drawing.context(CUT_OFF[1])?, &netlist.context(CUT_OFF[0])?));
    println!("{} simulations, {} numbers", simulated.len(), text.lines().count() - 1);
    ensure!(faults.is_empty(), "the board does not behave as {RESULTS} states:\n{}", faults.join("\n"));
    Ok(())
}

/// Runs a netlist with some of its parameters set otherwise.
fn simulate(netlist: &str, case: &str, parameters: &str) -> Result<Measured> {
    let mut text = expand(&shell::root().join(FOLDER), &format!("{netlist}.cir"))?;
    for parameter in parameters.split_whitespace() {
        text = with_parameter(&text, parameter)?;
    }
    let folder = shell::target_directory()?.join(FOLDER);
    fs::create_dir_all(&folder)?;
    let file = folder.join(format!("{netlist} {case}.cir"));
    fs::write(&file, text)?;
    let output = shell::program(install::NGSPICE).arg("-b").arg(&file).output().context("ngspice cannot be started")?;
    let printed = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    let measured = measurements(&printed);
    if !output.status.success() || measured.is_empty() || printed.contains("aborted") {
        bail!("ngspice fails on {}:\n{printed}", file.display());
    }
    Ok(measured)
}

/// A netlist with what it includes in its place.
fn expand(folder: &Path, name: &str) -> Result<String> {
    let text = fs::read_to_string(folder.join(name)).with_context(|| format!("{FOLDER}/{name} cannot be read"))?;
    let mut whole = String::new();
    for line in text.lines() {
        match line.strip_prefix(".include ") {
            Some(included) => whole += &expand(folder, included.trim_matches('"'))?,
            None => whole += &format!("{line}\n"),
        }
    }
    Ok(whole)
}

/// Puts `name=value` in the place of the line `.param name = …`, which must be there once.
fn with_parameter(text: &str, parameter: &str) -> Result<String> {
    let (name, value) = parameter.split_once('=').with_context(|| format!("{parameter} is not name=value"))?;
    let start = format!(".param {name} = ");
    ensure!(text.matches(&start).count() == 1, "no netlist line, or more than one, begins with {start}");
    let set = |line: &str| if line.starts_with(&start) { format!("{start}{value}\n") } else { format!("{line}\n") };
    Ok(text.lines().map(set).collect())
}

/// The lines `name = value …`.
fn measurements(printed: &str) -> Measured {
    let number = |line: &str| {
        let (name, value) = line.split_once('=')?;
        let value = value.split_whitespace().next()?.parse().ok()?;
        Some((name.trim().to_owned(), value))
    };
    printed.lines().filter_map(number).filter(|(name, _)| !name.contains(' ')).collect()
}

/// Why a number is not within its bounds. A crossing that does not come is later than any bound.
fn outside(value: Option<f64>, least: &str, most: &str) -> Result<Option<String>> {
    let value = value.unwrap_or(f64::INFINITY);
    let bound = |text: &str, none: f64| if text.is_empty() { Ok(none) } else { text.parse().context(text.to_owned()) };
    let within = (bound(least, f64::NEG_INFINITY)?..=bound(most, f64::INFINITY)?).contains(&value);
    Ok((!within).then(|| format!("which is not within {least} … {most}")))
}

/// Why a number is not what it was.
fn moved(value: Option<f64>, last: &str, bounds: [&str; 2]) -> Option<String> {
    let as_before = match (value, last.parse::<f64>()) {
        (None, _) => last == NEVER,
        (Some(_), Err(_)) => false,
        (Some(value), Ok(last)) => {
            let sizes = bounds.iter().filter_map(|bound| bound.parse().ok()).map(f64::abs);
            (value - last).abs() <= TOLERANCE * sizes.fold(last.abs(), f64::max)
        }
    };
    (!as_before).then(|| format!("which was {last}; if that is right: cargo xtask hardware --write"))
}

/// Values of a drawing that are not the netlist's. A text of the drawing whose id is a parameter
/// states its value.
fn drawn_otherwise(drawing: &str, netlist: &str) -> Vec<String> {
    let texts = drawing.split("<text id=\"").skip(1).filter_map(|text| {
        let (name, rest) = text.split_once('"')?;
        Some((name, rest.split_once('>')?.1.split_once('<')?.0))
    });
    let differs = |&(name, drawn): &(&str, &str)| {
        let value = drawn.replace([' ', 'Ω', 'F', 'V'], "").replace('M', "meg").replace('µ', "u");
        !netlist.lines().any(|line| line == format!(".param {name} = {value}"))
    };
    texts
        .filter(differs)
        .map(|(name, drawn)| format!("{}: {name} is not {drawn} in {}", CUT_OFF[1], CUT_OFF[0]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_outside_its_bounds_and_one_that_has_moved_are_named() {
        assert_eq!(outside(Some(1.0), "", "2").expect("numbers"), None);
        assert!(outside(Some(2.1), "1", "2").expect("numbers").is_some());
        assert!(outside(None, "", "2").expect("numbers").is_some(), "what never comes is too late");
        assert!(outside(Some(1.0), "one", "").is_err());
        assert_eq!(moved(Some(1.02), "1.0", ["", ""]), None);
        assert!(moved(Some(1.04), "1.0", ["", ""]).is_some());
        assert_eq!(moved(Some(1e-4), "2e-4", ["-0.2", "0.2"]), None, "what is small beside its bound may move");
        assert!(moved(Some(1.0), NEVER, ["", ""]).is_some() && moved(None, "1.0", ["", ""]).is_some());
        assert_eq!(moved(None, NEVER, ["", ""]), None);
    }

    #[test]
    fn measurements_are_the_lines_with_a_name_and_a_number() {
        let printed = "Doing analysis at TEMP = 27.0\nnever_s = failed\npeak_a   =  -3.0e-03 at=  2.0e-05\n";
        assert_eq!(measurements(printed), Measured::from([("peak_a".to_owned(), -3.0e-3)]));
    }

    #[test]
    fn a_parameter_that_the_netlist_does_not_have_is_refused() {
        let text = ".param r_s = 20\nr_sense source 0 {r_s}\n";
        assert!(with_parameter(text, "r_s=1m").expect("there").starts_with(".param r_s = 1m\nr_sense"));
        assert!(with_parameter(text, "r_t=1m").is_err());
    }

    #[test]
    fn a_value_that_is_drawn_otherwise_than_it_is_simulated_is_named() {
        let netlist = ".param hold_ohm = 4.7meg\n.param c_hold = 1u\n";
        let drawing = |ohm: &str| format!("<text id=\"hold_ohm\" x=\"1\">{ohm}</text><text id=\"c_hold\">1 µF</text>");
        assert_eq!(drawn_otherwise(&drawing("4.7 MΩ"), netlist), Vec::<String>::new());
        assert_eq!(drawn_otherwise(&drawing("4.7 kΩ"), netlist).len(), 1);
        assert_eq!(drawn_otherwise("<text id=\"gone\">1</text>", netlist).len(), 1);
    }
}

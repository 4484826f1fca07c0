//! A head's check as text and as JSON.

use std::fmt;

use anemometry::head::Head;
use anemometry::head::body::{Body, BodyLink};
use dr_core::sensor::Level;
use recording::text::{brief, count};
use recording::toml_file::FileError;
use serde::Serialize;

use super::conditions::{ElementCheck, GivenConditions, HeadConditions};
use super::fault::OverheatError;
use super::warnings::warnings;
use super::winds::WindRange;
use crate::sensor::{Construction, construction_of};

/// Speeds whose needs are printed, m/s.
const SHOWN_M_S: [f64; 5] = [0.1, 1.0, 3.162, 10.0, 31.62];
/// A usual wind, m/s, for time constants and gains.
const USUAL_M_S: [f64; 3] = [3.0, 0.0, 0.0];
/// Time constants that are printed at either end.
const SLOWEST: usize = 4;

/// Summary of `anemo head check`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeadCheckReport {
    /// Name of the head.
    pub head: String,
    /// Gas, overheat, sample period, noise.
    pub conditions: HeadConditions,
    /// Nodes and links of the network.
    pub network: NetworkSize,
    /// From the slowest, s: in quiescent gas.
    pub time_constants_s: Vec<f64>,
    /// From the slowest, s: at 3 m/s.
    pub time_constants_in_wind_s: Vec<f64>,
    /// The elements.
    pub elements: Vec<ElementCheck>,
    /// Needs by wind, and range.
    pub range: WindRange,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Why the head cannot be operated at all: warnings name it, too.
    #[serde(skip)]
    pub fault: Option<OverheatError>,
}

/// Size of a network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NetworkSize {
    /// Nodes, cells of rods among them.
    pub nodes: usize,
    /// Links, a rod as one.
    pub links: usize,
    /// Surfaces in the wind.
    pub surfaces: usize,
}

/// Judges a head under conditions, after `refine` has changed those that it wants otherwise.
///
/// # Errors
/// If the head has nothing that simulates it, or the gas is none that it can be simulated in.
pub fn check(
    head: &Head,
    given: GivenConditions,
    refine: impl FnOnce(&mut HeadConditions),
) -> Result<HeadCheckReport, FileError> {
    let construction = construction_of(head)?.ok_or_else(|| {
        let names = Construction::NAMES.map(|name| format!("\"{name}\"")).join(", ");
        let sentence = format!("is missing: it says what the head is made of (or a `sensor`, one of {names})");
        head.source.refuse("body", sentence)
    })?;
    let gas = construction.bodies().iter().find_map(|body| body.gas);
    let mut conditions = HeadConditions::of(head, gas, given);
    refine(&mut conditions);
    let mut survey = conditions.survey(head, &construction)?;
    let gains = survey.own_gains_k_per_w([0.0; 3]);
    let gains_in_wind = survey.own_gains_k_per_w(USUAL_M_S);
    let range = WindRange::of(&mut survey, &head.elements, &conditions);
    // Time constants are those of the overheat that is checked, not of others that are possible.
    let fault = OverheatError::of(&mut survey.clone(), head, &conditions);
    let capacities_j_k: Vec<f64> = (0..head.elements.len()).map(|i| survey.element_capacity_j_k(i)).collect();
    let element = |(i, of): (usize, &anemometry::head::HeadElement)| ElementCheck {
        name: of.name.clone(),
        held: range.held[i],
        own_gain_k_per_w: gains[i],
        own_gain_in_wind_k_per_w: gains_in_wind[i],
        capacity_j_k: capacities_j_k[i],
        level_w: [Level::Low, Level::High].map(|level| of.power_w(conditions.set_point_c(), level)),
    };
    let elements: Vec<ElementCheck> = head.elements.iter().enumerate().map(element).collect();
    Ok(HeadCheckReport {
        head: head.name.clone(),
        network: size(construction.bodies()),
        time_constants_s: survey.time_constants_s([0.0; 3]),
        time_constants_in_wind_s: survey.time_constants_s(USUAL_M_S),
        warnings: warnings(head, &conditions, &elements, &range, fault.as_ref()),
        fault,
        elements,
        conditions,
        range,
    })
}

fn size(bodies: &[Body]) -> NetworkSize {
    let sum = |of: &dyn Fn(&Body) -> usize| bodies.iter().map(of).sum();
    NetworkSize {
        nodes: sum(&|body| body.nodes.len()),
        links: sum(&|body| {
            body.links.iter().map(|link| if let BodyLink::Rod { from, .. } = link { from.len() } else { 1 }).sum()
        }),
        surfaces: sum(&|body| body.surfaces().count()),
    }
}

impl fmt::Display for HeadCheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let HeadConditions { species, pressure_pa, temperature_c, overheat_k, sample_period_s, noise_v_rms } =
            self.conditions;
        writeln!(
            f,
            "{} in {} of {} Pa and {} °C, held {} K above it, a bit every {} ms, {} µV of noise",
            self.head,
            species.name(),
            brief(pressure_pa),
            brief(temperature_c),
            brief(overheat_k),
            brief(1e3 * sample_period_s),
            brief(1e6 * noise_v_rms)
        )?;
        let NetworkSize { nodes, links, surfaces } = self.network;
        let [nodes, links, surfaces] =
            [(nodes, "node"), (links, "link"), (surfaces, "surface")].map(|(number, thing)| count(number, thing));
        writeln!(f, "\nnetwork        {nodes}, {links}, {surfaces} in the wind")?;
        writeln!(f, "time constants {} in quiescent gas", shown(&self.time_constants_s))?;
        writeln!(f, "               {} at 3 m/s", shown(&self.time_constants_in_wind_s))?;
        self.write_elements(f)?;
        self.write_range(f)?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "\nwarning: {warning}"))
    }
}

impl HeadCheckReport {
    fn write_elements(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<f64> = SHOWN_M_S.into_iter().filter(|speed| self.range.near(*speed).is_some()).collect();
        let width = self.elements.iter().map(|of| of.name.chars().count()).max().unwrap_or(0).max(7);
        write!(f, "\n{:width$}   own gain (K/W)        levels (mW)     needed (mW)", "element")?;
        write!(f, "\n{:width$}   at rest    3 m/s      low     high    at rest", "")?;
        shown
            .iter()
            .try_for_each(|speed| write!(f, "{:>17}", format!("{} m/s", brief((speed * 10.0).round() / 10.0))))?;
        writeln!(f)?;
        for (i, of) in self.elements.iter().enumerate() {
            write!(
                f,
                "{:width$}  {:>8} {:>8}",
                of.name,
                short(of.own_gain_k_per_w),
                short(of.own_gain_in_wind_k_per_w)
            )?;
            write!(f, " {:>8} {:>8}", short(1e3 * of.level_w[0]), short(1e3 * of.level_w[1]))?;
            if !of.held {
                writeln!(f, "   only senses")?;
                continue;
            }
            write!(f, " {:>10}", short(1e3 * self.range.at_rest_w[i]))?;
            for needs in shown.iter().filter_map(|speed| self.range.near(*speed)) {
                let [least, most] = needs.power_w[i];
                write!(f, "{:>17}", format!("{} … {}", short(1e3 * least), short(1e3 * most)))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }

    fn write_range(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range = &self.range;
        let speed = |speed_m_s: f64| short(speed_m_s);
        writeln!(f)?;
        match (range.least_m_s, range.greatest_m_s) {
            (Some(least), Some(most)) => {
                let limit =
                    range.limited_by.map(|i| format!("; more takes more than `{}` can give", self.elements[i].name));
                writeln!(f, "winds          {} … {} m/s{}", speed(least), speed(most), limit.unwrap_or_default())?;
            }
            _ if !range.held.contains(&true) => {}
            _ => writeln!(f, "winds          none takes more than quiescent gas does")?,
        }
        if range.known_to_m_s < range.greatest_m_s.unwrap_or(0.0) {
            writeln!(f, "               convection is known up to {} m/s", speed(range.known_to_m_s))?;
        }
        let known = SHOWN_M_S.into_iter().filter_map(|speed| range.near(speed));
        let resolution: Vec<String> = known
            .map(|needs| {
                format!("{} at {}", short(needs.resolution_m_s), short((needs.speed_m_s * 10.0).round() / 10.0))
            })
            .collect();
        if !resolution.is_empty() && range.held.contains(&true) {
            writeln!(f, "resolution     {} m/s, by noise in 1 s, from the sum of all powers", resolution.join(", "))?;
        }
        Ok(())
    }
}

/// Three digits.
fn short(value: f64) -> String {
    recording::text::short(value, 3)
}

/// The slowest, and the fastest.
fn shown(time_constants_s: &[f64]) -> String {
    let time = |time_s: &f64| match *time_s {
        time_s if time_s < 0.1 => format!("{} ms", short(1e3 * time_s)),
        time_s => format!("{} s", short(time_s)),
    };
    let slowest: Vec<String> = time_constants_s.iter().take(SLOWEST).map(time).collect();
    match time_constants_s.last() {
        Some(last) if time_constants_s.len() > SLOWEST => format!("{} … {}", slowest.join(", "), time(last)),
        _ => slowest.join(", "),
    }
}

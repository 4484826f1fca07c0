//! From a head's check to what is drawn of it.

use anemometry::head::Head;
use anemometry::head::body::{Body, BodyLink};
use host_sim::head_check::HeadCheckReport;
use host_sim::sensor::{Construction, construction_of};
use plot::Figure;
use plot::head::{HeadSketch, figure};
use recording::text::brief;
use recording::toml_file::FileError;

/// Adds the nodes of a body to a picture's, the cells of a rod as one; returns where each went.
fn places(body: &Body, names: &mut Vec<String>) -> Vec<usize> {
    let rod_of = |node: usize| {
        body.links.iter().find_map(|link| match link {
            BodyLink::Rod { cells, .. } if cells.contains(&node) => Some(cells.clone()),
            _ => None,
        })
    };
    let mut places: Vec<usize> = Vec::new();
    for (node, of) in body.nodes.iter().enumerate() {
        let place = match rod_of(node) {
            Some(cells) if node > cells.start => places[cells.start],
            Some(cells) => {
                let name = of.name.trim_end_matches('1');
                names.push(if cells.len() == 1 { name.to_owned() } else { format!("{name} ({} cells)", cells.len()) });
                names.len() - 1
            }
            None => {
                names.push(of.name.clone());
                names.len() - 1
            }
        };
        places.push(place);
    }
    places
}

/// The picture of `anemo head check`.
pub fn drawn(head: &Head, report: &HeadCheckReport) -> Result<Figure, FileError> {
    let conditions = &report.conditions;
    let mut sketch = HeadSketch {
        name: report.head.clone(),
        conditions: format!(
            "{} of {} Pa and {} °C, elements {} K above it",
            conditions.species.name(),
            brief(conditions.pressure_pa),
            brief(conditions.temperature_c),
            brief(conditions.overheat_k)
        ),
        ..HeadSketch::default()
    };
    let construction = construction_of(head)?;
    for body in construction.as_ref().map_or(&[][..], Construction::bodies) {
        let places = places(body, &mut sketch.nodes);
        let ways = body.ways().map(|(from, to)| (places[from], to.map(|to| places[to])));
        sketch.links.extend(ways.filter(|(from, to)| Some(*from) != *to));
        sketch.surfaces.extend(body.surfaces().map(|of| (of.name.clone(), of.normal, places[of.node])));
    }
    for (i, element) in report.elements.iter().enumerate().filter(|(_, element)| element.held) {
        let point = |needs: &host_sim::head_check::WindNeeds| {
            let [least, most] = needs.power_w[i].map(|power_w| 1e3 * power_w);
            (needs.speed_m_s, least, most)
        };
        sketch.powers_mw.push((element.name.clone(), report.range.winds.iter().map(point).collect()));
        let high_mw = 1e3 * element.level_w[1];
        sketch.high_mw = Some(sketch.high_mw.map_or(high_mw, |lowest: f64| lowest.min(high_mw)));
    }
    Ok(figure(&sketch))
}

//! Reading and refusals of a `[body]`.

use std::path::Path;

use crate::head::Head;
use crate::head::body::Body;
use crate::head::body::BodyLink;
use recording::toml_file::TomlSource;

fn source(name: &str) -> TomlSource {
    TomlSource::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads").join(name)).unwrap()
}

fn body(name: &str) -> Body {
    Head::from_source(source(name)).unwrap().body.unwrap()
}

/// The sentence about a head of the project with other words in one place.
fn refused(name: &str, from: &str, to: &str) -> String {
    let mut source = source(name);
    assert!(source.text.contains(from), "{from}");
    source.text = source.text.replacen(from, to, 1);
    source.path = "h.toml".into();
    Head::from_source(source).unwrap_err().to_string()
}

#[test]
fn sphere_b_is_eighteen_nodes_and_what_joins_them() {
    let body = body("sphere-b.toml");
    let names: Vec<&str> = body.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!((names[0], names[4], names[8], names[10], names[17]), ("silver1", "chip1", "core1", "stem1", "stem8"));
    assert_eq!(body.nodes[17].capacity_j_k, 0.2 / 8.0);
    assert_eq!(body.elements, [4, 5, 6, 7, 8, 9]);
    // Four chips, four sectors on cores, six pairs of sectors, the cores, the stem.
    assert_eq!(body.links.len(), 4 + 4 + 6 + 1 + 1);
    let rod = BodyLink::Rod { from: vec![8, 9], to: None, cells: 10..18, conductance_w_k: 1.2e-3 };
    assert_eq!(body.links[15], rod);
    let surface = body.surfaces().nth(2).unwrap();
    assert_eq!((surface.name.as_str(), surface.node, surface.element), ("sector3", 2, Some(2)));
    assert_eq!((&surface.carries[..], surface.emissivity), (&[6][..], 0.03));
    assert!(surface.normal.unwrap()[0] < 0.0);
}

#[test]
fn what_hangs_between_a_surface_and_its_element_is_the_surfaces_own() {
    let body = body("sphere-a.toml");
    // Ceramic and film.
    assert_eq!(body.surfaces().next().unwrap().carries, [2, 4]);
}

#[test]
fn what_cannot_be_is_refused_with_key_and_line() {
    for (from, to, expected) in [
        ("capacity_j_k = 0.118", "capacity_j_k = 0.0", "`body.nodes[0].capacity_j_k` is 0 J/K: it must be finite and"),
        ("capacity_j_k = 0.118", "capacity_jk = 0.118", "unknown key `capacity_jk`; did you mean `capacity_j_k`?"),
        ("name = \"core[1-2]\"", "name = \"chip[1-2]\"", "`body.nodes[2].name` names `chip1`, which is a node already"),
        ("name = \"core[1-2]\"", "name = \"core[2-1]\"", "has `[2-1]`, which is no range: write `[1-4]`"),
        ("name = \"core[1-2]\"", "name = \"support\"", "is `support`, which has a fixed temperature"),
        (
            "to = \"core1\"",
            "to = \"kore1\"",
            "`body.links[1].to` names `kore1`, which is no node; did you mean `core1`?",
        ),
        ("from = \"silver[1-2]\"", "from = \"silver[1-2]\", among = \"chip1\"", "needs `from` and `to`, or `among`"),
        (
            "to = \"silver[1-4]\"",
            "to = \"silver[1-3]\"",
            "joins 4 nodes with 3: as many as there are, or each with one",
        ),
        ("from = \"core1\", to = \"core2\"", "from = \"core1\", to = \"core1\"", "leads from a node to itself"),
        ("conductance_w_k = 6e-4", "area_m2 = 1e-4", "needs one of `conductance_w_k`, `area_m2` with `contact_w_m2_k`"),
        ("cells = 8", "cells = 0", "`body.links[5].cells` is 0: it must lie between 1 and 100"),
        (", capacity_j_k = 0.2, cells = 8", "", "is a rod without `capacity_j_k` and `cells`"),
        ("rod = \"stem\", ", "", "has `capacity_j_k` or `cells` without a `rod`, which names the cells"),
        ("\"chip[1-4]\" }", "\"chip[1-3]\" }", "puts 4 elements on 3 nodes: one belongs on each"),
        ("\"sector[1-4]\" =", "\"sektor[1-4]\" =", "names `sektor1`, which is no element of the head; did you mean"),
        ("elements = { \"sector[1-4]\" = \"chip[1-4]\" }", "", "has no node for the element `sector1`: name one so"),
        ("diameter_m = 0.01", "diameter_m = -0.01", "`body.convection[0].correlation.diameter_m` is -0.01 m"),
        ("kind = \"sphere\"", "kind = \"spere\"", "unknown choice `spere` for `kind`; did you mean `sphere`?"),
        (
            "emissivity = 0.03",
            "emissivity = 3",
            "`body.convection[0].surfaces[0].emissivity` is 3: it must lie between 0 and 1",
        ),
        ("node = \"silver[1-4]\"", "node = \"silver1\"", "names 1 for 4 surfaces: one each"),
        ("name = \"sector[1-4]\", node", "name = \"sector[1-4],sector1\", node", "names 4 for 5 surfaces: one each"),
        ("normal = [1.0, -1.0, -1.0]", "normal = [1.0, 1.0, 1.0]", "`sector1` and `sector2` look into one direction"),
        ("normal = [1.0, -1.0, -1.0]", "", "need a `normal` each, but `sector2` has none, nor has its element"),
        ("pressure_pa = 1000.0", "pressure_pa = 0.1", "`body.gas` cannot be: `gas.pressure_pa` is 0.1"),
        ("name = \"sphere-b\"", "name = \"sphere-b\"\nsensor = \"sphere-b\"", "`sensor` is given besides [body]"),
    ] {
        let sentence = refused("sphere-b.toml", from, to);
        assert!(sentence.starts_with("h.toml, line ") && sentence.contains(expected), "{to}: {sentence}");
        assert!(!sentence.contains('\n'));
    }
}

#[test]
fn a_node_that_no_heat_can_leave_is_refused_by_its_name() {
    let lone = "{ name = \"core[1-2]\", capacity_j_k = 0.075 }, { name = \"lone\", capacity_j_k = 1.0 },";
    let sentence = refused("sphere-b.toml", "{ name = \"core[1-2]\", capacity_j_k = 0.075 },", lone);
    assert!(sentence.contains("leave `lone` without any way to the gas or the `support`"), "{sentence}");
}

#[test]
fn laws_refuse_what_they_cannot_be_for() {
    for (kind, expected) in [
        (
            "kind = \"cylinder\", diameter_m = 0.01, length_m = 0.01, axis = [1.0, 1.0, 1.0]",
            "`sector1` looks along the axis",
        ),
        ("kind = \"cylinder\", diameter_m = 0.01, length_m = 0.01, axis = [0.0, 0.0, 0.0]", "is no direction"),
        ("kind = \"plate\", length_m = 0.01, width_m = 0.01, faces = 3", "`body.convection[0].correlation.faces` is 3"),
        ("kind = \"wire\", diameter_m = 1e-5, length_m = 2e-3, law = \"king\"", "unknown choice `king`"),
        (
            "kind = \"king\", a_w_k = 1e-3, b_w_k = 1e-3, exponent = 1.5",
            "exponent` is 1.5: it must lie between 0.1 and 1",
        ),
        (
            "kind = \"table\", length_m = 0.01, area_m2 = 1e-4, reynolds = [1, 10], angles_deg = [0, 90], nusselt = [[1, 2]], nusselt_at_rest = 1",
            "`body.convection[0].correlation.nusselt` has not 2 rows of 2 numbers",
        ),
        (
            "kind = \"table\", length_m = 0.01, area_m2 = 1e-4, reynolds = [10, 1], angles_deg = [0], nusselt = [[1], [2]], nusselt_at_rest = 1",
            "correlation.reynolds` do not ascend",
        ),
    ] {
        let sentence = refused("sphere-b.toml", "kind = \"sphere\", diameter_m = 0.01", kind);
        assert!(sentence.starts_with("h.toml, line ") && sentence.contains(expected), "{kind}: {sentence}");
    }
    let sentence = refused("rems.toml", "front_to_rear = 0.1", "front_to_rear = 0.5");
    assert!(sentence.contains("front_to_rear` is 0.5: it must lie between 0 and 0.49"), "{sentence}");
    let sentence = refused("rems.toml", "  { name = \"shank[1-3]\" },\n", "");
    assert!(sentence.contains("are 16: twelve dice, three cards, the head and cells of the shank"), "{sentence}");
}

#[test]
fn an_unknown_number_has_a_range_and_other_values_make_another_head() {
    let end = "gas = { species = \"co2\", pressure_pa = 1000.0, temperature_c = -53.15 }";
    let with = |entry: &str| {
        let mut source = source("sphere-b.toml");
        source.text = source.text.replacen(end, &format!("{end}\nunknown = [ {entry} ]"), 1);
        source.path = "h.toml".into();
        Head::from_source(source)
    };
    let head = with(
        "{ of = \"body.nodes[2].capacity_j_k\", least = 0.05, most = 0.1 }, { of = \"body.links[3].conductance_w_k\", least = 5e-5, most = 5e-4 }",
    )
    .unwrap();
    let unknown = &head.body.as_ref().unwrap().unknown;
    assert_eq!((unknown[0].value, unknown[1].value), (0.075, 1e-4));
    let other = head.with_unknown(&[0.06, 2e-4]).unwrap().body.unwrap();
    assert_eq!(other.nodes[8].capacity_j_k, 0.06);
    let BodyLink::Solid { conductance_w_k, .. } = other.links[8] else { panic!("a pair of sectors") };
    assert_eq!(conductance_w_k, 2e-4);
    // All else is as it was.
    assert_eq!(other.nodes[0], head.body.as_ref().unwrap().nodes[0]);
    for (entry, expected) in [
        ("{ of = \"body.nodes[9].capacity_j_k\", least = 0.05, most = 0.1 }", "`body.unknown[0]` names `body.nodes[9]"),
        ("{ of = \"name\", least = 0.05, most = 0.1 }", "where no number stands"),
        ("{ of = \"body.nodes[2].capacity_j_k\", least = 0.1, most = 0.2 }", "above 0, and around its 0.075"),
    ] {
        let sentence = with(entry).unwrap_err().to_string();
        assert!(sentence.starts_with("h.toml, line ") && sentence.contains(expected), "{sentence}");
    }
}

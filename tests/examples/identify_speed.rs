//! One line of JSON on how fast identification is on a given record, for
//! `docs/performance/compare.py`.
//!
//! `identify_speed DATA ORDER RUNS`: DATA holds pairs of f64, input and output, little-endian, 0.5
//! ms apart.

use anemo_tests::speed;
use diffusive::identify::record::RecordTable;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [data, order, runs] = arguments.as_slice() else { panic!("usage: identify_speed DATA ORDER RUNS") };
    let (order, runs) = (order.parse().expect("ORDER is a number"), runs.parse().expect("RUNS is a number"));
    let bytes = std::fs::read(data).expect("DATA can be read");
    let values: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let column = |from: usize| values.iter().skip(from).step_by(2).copied().collect::<Vec<f64>>();
    let columns = |name: &str, from: usize| vec![(name.to_owned(), column(from))];
    let rows = values.len() / 2;
    let mut table =
        RecordTable::new(speed::SAMPLE_PERIOD_S, columns("u", 0), columns("y", 1)).expect("the record is in order");
    let design = speed::design(order, 1, 1);
    let mut theta = speed::solve(&mut table, &design);
    // The limits before and after: what the machine gives changes while others use it.
    let mut limits = (speed::flops_a_second(), speed::bytes_a_second());
    let least_s = speed::least_s(runs, || theta = speed::solve(&mut table, &design));
    limits = (limits.0.max(speed::flops_a_second()), limits.1.max(speed::bytes_a_second()));
    let drifting = speed::drift_design(order, rows);
    let drift_s = speed::least_s(runs.min(10), || drop(speed::read(&mut table, &drifting)));
    let report = serde_json::json!({
        "drift_ns_per_row": 1e9 * drift_s / rows as f64,
        "drift_columns": drifting.width(),
        "rows": rows,
        "order": order,
        "ns_per_row": 1e9 * least_s / rows as f64,
        "r_k_per_w": &theta.as_slice()[..order],
        "offset_c": theta[order],
        "flops_per_row": speed::flops_a_row(&design),
        "bytes_per_row": speed::bytes_a_row(1),
        "flops_per_second": limits.0,
        "bytes_per_second": limits.1,
    });
    println!("{report}");
}

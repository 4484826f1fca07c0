//! The examples print what stands beside them.

#[path = "../examples/read_a_table.rs"]
mod read_a_table;
#[path = "../examples/write_a_recording.rs"]
mod write_a_recording;

#[test]
fn examples_print_what_stands_beside_them() {
    assert_eq!(write_a_recording::text().unwrap(), include_str!("../examples/write_a_recording.out"));
    assert_eq!(read_a_table::text().unwrap(), include_str!("../examples/read_a_table.out"));
}

//! The unit tests of what the board runs, in an interpreter that knows what Rust does not define.
//!
//! There is no `unsafe` in these crates; their libraries have some.

use crate::{install, shell};
use anyhow::Result;

/// Tests that go through so many ticks, points or bytes that the interpreter would take from many seconds to hours for each. They find wrong numbers;
/// what they call the others call, too.
const LONG: [&str; 33] = [
    "anemometer::tests::bodies",
    "balance::on_a_head_too_warm",
    "balance::a_loop_is_saturated",
    "balance::a_thermometer_that_is_silent",
    "balance::no_flow_at_all",
    "balance::it_is_starting",
    "controller::tests::observing::observing_holds",
    "controller::tests::its_model_follows_the_power",
    "controller::tests::holds_a_temperature",
    "controller::tests::elements::room_for_more",
    "self_test::tests::each_thing_that_is_wrong",
    "self_test::tests::stopped_at_any_tick",
    "observer::tests::is_stable",
    "observer::tests::in_another_wind",
    "observer::tests::in_steady_state",
    "observer::tests::finds_the_states",
    "observer::tests::forgets_a_wrong_start",
    "relaxation::tests::ten_million",
    "decimator::tests::sums_may_wrap",
    "sigma_delta::tests::follows_the_closed_form",
    "sigma_delta::tests::the_sum_of_bits",
    "prbs::tests::short_registers",
    "wind::tests::surfaces::a_part_loses",
    "wind::tests::surfaces::conductances_agree",
    "wind::tests::noise",
    "wind::tests::round_trip",
    "wind::tests::partial::three_sectors",
    "wind::tests::partial::a_sector_that_is_hardly_known",
    "wind::tests::partial::two_hemispheres",
    "wind::tests::amplitudes::interpolates",
    "wind::tests::cards::winds_in_the_plane",
    "receiver::tests::garbage_of_any_length",
    "stuffing::tests::a_buffer_that_is_too_short",
];

pub fn run() -> Result<()> {
    install::nightly(&["miri", "rust-src"])?;
    let mut miri = install::on_nightly();
    miri.args(["cargo", "miri", "test", "-p", "dr-core", "-p", "wire", "--lib"]);
    miri.arg("--target-dir").arg(shell::target_directory()?.join("miri"));
    miri.arg("--").args(LONG.map(|name| format!("--skip={name}")));
    shell::run(&mut miri)
}

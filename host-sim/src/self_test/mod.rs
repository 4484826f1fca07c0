//! Self-tests: asked for, waited for, and told to people. What is tested, and what is right, is dr-core's ([`dr_core::control::self_test`]).

pub mod report;

use dr_core::control::self_test::plan::test_ticks;
use dr_core::control::{Command, SelfTestPlan};

use crate::instrument::setup::ARM;
use crate::instrument::{Instrument, InstrumentError};
pub use report::Report;

/// Ticks beyond those of the plan that are waited for: what a board has sent before it heard of the test.
const PATIENCE_TICKS: u32 = 200;

/// Has an instrument test itself, in standby or, without a pulse, tripped. `each` is told the ticks that are over, and how many there will be, as far as that is
/// known: `known` are the sample period in s and the number of elements, where a host has set them. If it says no, the test is left as it is, and there is
/// no report.
///
/// # Errors
/// If the instrument refuses, cannot be reached, or does not come to an end.
pub fn run(
    instrument: &mut dyn Instrument,
    plan: SelfTestPlan,
    known: Option<(f32, usize)>,
    each: &mut dyn FnMut(u32, u32) -> bool,
) -> Result<Option<Report>, InstrumentError> {
    if plan.pulse_s.is_some() {
        instrument.command(ARM)?;
    }
    // Of another test, that nobody has asked for.
    instrument.findings();
    instrument.command(Command::SelfTest(plan))?;
    let planned = known.map_or(u32::MAX - PATIENCE_TICKS, |(sample_period_s, elements)| {
        test_ticks(plan.pulse_ticks(sample_period_s).unwrap_or(0), elements)
    });
    let mut findings = Vec::new();
    for tick in 1..planned + PATIENCE_TICKS {
        instrument.observe()?;
        findings.extend(instrument.findings());
        if findings.first().is_some_and(|first: &dr_core::control::Finding| findings.len() >= usize::from(first.of)) {
            return Ok(Some(Report { firmware: instrument.identity().firmware.to_string(), plan, findings }));
        }
        if !each(tick, planned) {
            return Ok(None);
        }
    }
    Err(InstrumentError::Protocol("the self-test does not end; has another host stopped it?".to_owned()))
}

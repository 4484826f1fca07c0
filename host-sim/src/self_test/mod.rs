//! Self-tests of an instrument: started, waited for and reported. [`dr_core::control::self_test`]
//! defines what is tested.

pub mod currents;
pub mod report;

use dr_core::Command;
use dr_core::control::self_test::plan::test_ticks;
use dr_core::control::{SelfTestFinding, SelfTestPlan};
use std::time::{Duration, Instant};

use crate::instrument::setup::ARM;
use crate::instrument::{InstrumentError, InstrumentPort};
pub use report::{SelfTestReport, StoredSelfTests};

/// Ticks to wait beyond those of the plan: what a board has sent before it received the command.
const TIMEOUT_TICKS: u32 = 200;
/// Time to wait where the plan's ticks are not known: longer than any test takes.
const TIMEOUT: Duration = Duration::from_secs(1200);

/// Has an instrument test itself, in standby or, without a pulse, tripped.
///
/// `known` are the sample period in s and the number of elements, where a host has set them. `each`
/// gets the ticks that are over, and how many there will be, as far as that is known. If it returns
/// false, the test is left as it is, and there is no report.
///
/// # Errors
/// If the instrument refuses, cannot be reached, or does not come to an end.
pub fn run(
    instrument: &mut dyn InstrumentPort,
    plan: SelfTestPlan,
    known: Option<(f32, usize)>,
    each: &mut dyn FnMut(u32, Option<u32>) -> bool,
) -> Result<Option<SelfTestReport>, InstrumentError> {
    if plan.pulse_s.is_some() {
        instrument.command(ARM)?;
    }
    instrument.command(Command::SelfTest(plan))?;
    // Findings of an earlier test are dropped: those of this one come after the reply.
    instrument.findings();
    let planned =
        known.map(|(sample_period_s, elements)| test_ticks(plan.pulse_ticks(sample_period_s).unwrap_or(0), elements));
    let mut findings: Vec<SelfTestFinding> = Vec::new();
    let begun = Instant::now();
    // Ticks since the first finding: those of a test come together.
    let (mut tick, mut since) = (0, 0);
    loop {
        instrument.observe()?;
        findings.extend(instrument.findings());
        tick += 1;
        if let Some(first) = findings.first() {
            let of = usize::from(first.of);
            if findings.len() >= of {
                return Ok(Some(SelfTestReport {
                    firmware: instrument.identity().firmware.to_string(),
                    plan,
                    findings,
                    names: Vec::new(),
                }));
            }
            since += 1;
            if since > TIMEOUT_TICKS {
                let words = format!(
                    "{} of {of} findings of the self-test have arrived; the board has kept all of them",
                    findings.len()
                );
                return Err(InstrumentError::Protocol(words));
            }
        }
        let too_late = planned.map_or_else(|| begun.elapsed() > TIMEOUT, |planned| tick > planned + TIMEOUT_TICKS);
        if too_late {
            let words = "the self-test does not end; has another host stopped it?";
            return Err(InstrumentError::Protocol(words.to_owned()));
        }
        if !each(tick, planned) {
            return Ok(None);
        }
    }
}

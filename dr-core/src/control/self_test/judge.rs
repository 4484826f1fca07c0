//! Verdicts: the results of each phase of the self-test against the bounds.

use super::SelfTest;
use super::finding::{
    GAP_MOST_K, NOISE_MOST_K, OFFSET_MOST, PulseResponse, REFERENCE_ERROR_MOST, RESPONSE, SIGNIFICANT, SelfTestFault,
    SelfTestFinding,
};
use super::plan::{Phase, QUIET_TICKS};
use super::sums::Quiet;
use crate::control::controller::Controller;
use crate::control::guard::Cause;
use crate::sensor::Level;
use crate::sensor::reading::REFERENCE_CODE;

impl<const N: usize> SelfTest<N> {
    /// Evaluates a phase, and clears the sums for the next one.
    pub(crate) fn judge_phase(&mut self, controller: &Controller<N>) {
        if let Phase::Heating(element) = self.phase {
            self.judge_pulse(usize::from(element), controller);
            return;
        }
        let all = self.findings.iter_mut().zip(&mut self.quiet).zip(&self.absent);
        for (i, ((finding, quiet), absent)) in all.enumerate() {
            let Some(channel) = controller.channel(i) else { break };
            match self.phase {
                Phase::Offsets => {
                    let full_v = channel.volt_of_resistance(channel.platinum().resistance_ohm(0.0), Level::Low);
                    finding.offset_v = quiet.mean().map(|code| channel.volt(code));
                    let is_small = |offset_v: f32| (-OFFSET_MOST..=OFFSET_MOST).contains(&(offset_v / full_v));
                    finding.faults.add_if(!finding.offset_v.is_some_and(is_small), SelfTestFault::Offset);
                }
                Phase::References => {
                    finding.reference = quiet.mean().map(|code| code / REFERENCE_CODE as f32);
                    let right = 1.0 - REFERENCE_ERROR_MOST..=1.0 + REFERENCE_ERROR_MOST;
                    let is_right = |ratio: f32| right.contains(&ratio);
                    finding.faults.add_if(!finding.reference.is_some_and(is_right), SelfTestFault::Reference);
                }
                Phase::Quiet => {
                    if quiet.count() < QUIET_TICKS / 2 {
                        finding.cause = finding.cause.or(*absent).or(Some(Cause::Missing));
                    }
                    (finding.temperature_c, finding.noise_k) = (quiet.mean(), quiet.noise());
                    finding.faults.add_if(finding.cause.is_some(), SelfTestFault::Continuity);
                    finding
                        .faults
                        .add_if(finding.noise_k.is_some_and(|noise_k| noise_k > NOISE_MOST_K), SelfTestFault::Noise);
                    finding.faults.add_if(finding.noise_k.is_some_and(|noise_k| noise_k <= 0.0), SelfTestFault::Frozen);
                }
                Phase::Heating(_) | Phase::Cooling(_) | Phase::Done => {}
            }
            *quiet = Quiet::default();
        }
    }

    fn judge_pulse(&mut self, element: usize, controller: &Controller<N>) {
        let Some(pulse) = self.pulses.get(element) else { return };
        let rise_k = pulse.rise_k();
        // A difference of two readings has √2 times the noise of one.
        let least_k = |finding: &SelfTestFinding| SIGNIFICANT * 1.414 * finding.noise_k.unwrap_or_default();
        let others = self.pulses.iter().zip(&self.findings).take(usize::from(self.elements)).enumerate();
        let risen = others.filter(|(i, (other, finding))| *i != element && other.rise_k() > least_k(finding));
        let most_other_k = risen.fold(f32::MIN, |most, (_, (other, _))| most.max(other.rise_k()));
        let has_model = controller.model(element).is_some();
        let against = pulse.against_model().filter(|_| has_model);
        let expected_k = has_model.then(|| pulse.expected_k());
        let Some(finding) = self.findings.get_mut(element) else { return };
        let (ratio, gap_k) = (against.map(|(ratio, _)| ratio), against.map(|(_, gap_k)| gap_k));
        finding.response = Some(PulseResponse { rise_k, expected_k, ratio, gap_k });
        // The element under test is read at the high level, where a kelvin is a larger voltage.
        let quieter = controller
            .channel(element)
            .map_or(1.0, |channel| channel.current_a(Level::Low) / channel.current_a(Level::High));
        let least_k = least_k(finding) * quieter;
        // A response below the noise gives no verdict, nor does one without a model.
        let can_tell = expected_k.is_some_and(|expected_k| expected_k > least_k);
        let none = can_tell && rise_k <= least_k;
        finding.faults.add_if(none, SelfTestFault::NoResponse);
        let is_as_expected = |ratio: f32| (RESPONSE[0]..=RESPONSE[1]).contains(&ratio);
        finding.faults.add_if(can_tell && !none && !ratio.is_some_and(is_as_expected), SelfTestFault::Response);
        finding
            .faults
            .add_if(gap_k.is_some_and(|gap_k| !(-GAP_MOST_K..=GAP_MOST_K).contains(&gap_k)), SelfTestFault::Levels);
        finding.faults.add_if(can_tell && most_other_k > rise_k + least_k, SelfTestFault::Crossed);
    }
}

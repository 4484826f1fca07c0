//! The clerk's desk: what the settings' clerk needs to set the instrument up, one piece after the other.

use crate::board::SettingsFlash;
use dr_core::control::{Command, Refusal, SelfTestPlan};
use firmware::inbox::Questions;
use firmware::queue;
use firmware::settings::{Busy, Clerk, clerk::Next};
use heapless::spsc::{Consumer, Producer};
use wire::{Setting, Unusable};

/// What became of a command.
pub type Outcome = Result<(), Refusal>;

/// The clerk, and its way to the control task and back.
pub struct Desk {
    /// Who keeps the settings.
    pub clerk: Clerk<SettingsFlash>,
    orders: Producer<'static, Command>,
    outcomes: Consumer<'static, Outcome>,
}

impl Desk {
    /// A desk with these ways.
    pub const fn new(
        clerk: Clerk<SettingsFlash>,
        orders: Producer<'static, Command>,
        outcomes: Consumer<'static, Outcome>,
    ) -> Self {
        Self { clerk, orders, outcomes }
    }

    /// Makes the instrument forget what it has been told, and tells it what is kept. Commands of the host wait meanwhile ([`Busy`]). False if
    /// that is not possible now: it is tripped.
    ///
    /// Finding a value takes some milliseconds, in which all other tasks have their turn: none is of lower priority.
    pub fn set_up(&mut self, busy: &Busy, questions: &Questions, wake_control: impl Fn()) -> bool {
        if !busy.is_standby() {
            return false;
        }
        self.clerk.begin();
        if !self.clerk.is_well() {
            defmt::warn!("the flash of the settings holds something else, or has rotted");
        }
        if self.tell(Command::Clear, &wake_control).is_err() {
            return false;
        }
        loop {
            match self.clerk.next_piece() {
                Next::Tell(key, Setting::Command(command)) => match self.tell(command, &wake_control) {
                    Ok(()) => {}
                    Err(Refusal::Tripped(_)) => return false,
                    Err(refusal) => {
                        let why = Unusable::Refused(refusal);
                        self.clerk.was_refused(key, why);
                        defmt::warn!("setting {=u16:#x} is not used: {=str}", key, why.name());
                    }
                },
                Next::Tell(_, Setting::TelemetryEvery(every)) => questions.thin(every),
                Next::Tell(_, Setting::Name(_) | Setting::Tested(_)) => {}
                Next::Leave(key, why) => defmt::warn!("setting {=u16:#x} is not used: {=str}", key, why.name()),
                Next::Done { taken, left } => {
                    if taken > 0 || left > 0 {
                        defmt::info!("set up by {=u16} settings, {=u16} are not used", taken, left);
                        // Nothing heats in it, and nothing is tested where no element is known.
                        let plan = SelfTestPlan { pulse_s: None, unix_s: None };
                        self.tell(Command::SelfTest(plan), &wake_control).ok();
                    }
                    return true;
                }
            }
        }
    }

    /// Tells the control task something, which is of higher priority: it is through with it as soon as it is woken.
    fn tell(&mut self, command: Command, wake_control: &impl Fn()) -> Outcome {
        if queue::put(&mut self.orders, command).is_err() {
            // It has room for one, and one at a time is told.
            return Ok(());
        }
        wake_control();
        // This task is preempted by it within a few instructions. Should the control task be dead, the watchdog ends this loop.
        loop {
            if let Some(outcome) = self.outcomes.dequeue() {
                return outcome;
            }
        }
    }
}

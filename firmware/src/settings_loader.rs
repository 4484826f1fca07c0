//! The settings loader: sets the instrument up with the stored settings, command by command.

use crate::board::SettingsFlash;
use crate::vitals::CHECK_INS;
use dr_core::Command;
use dr_core::control::{Refusal, SelfTestPlan};
use firmware::check_ins::Member;
use firmware::inbox::TelemetryRequests;
use firmware::queue;
use firmware::settings::{SettingsServer, StandbyLock, server::Next};
use heapless::spsc::{Consumer, Producer};
use wire::{MOST_ELEMENTS, Setting, Unusable};

/// Result of a command.
pub type Outcome = Result<(), Refusal>;

/// The settings server with its queues to the control task and back.
pub struct SettingsLoader {
    /// The server of the stored settings.
    pub server: SettingsServer<SettingsFlash>,
    orders: Producer<'static, Command>,
    outcomes: Consumer<'static, Outcome>,
}

impl SettingsLoader {
    /// A loader with these queues.
    pub const fn new(
        server: SettingsServer<SettingsFlash>,
        orders: Producer<'static, Command>,
        outcomes: Consumer<'static, Outcome>,
    ) -> Self {
        Self { server, orders, outcomes }
    }

    /// Clears the instrument and applies the stored settings. The host's commands wait meanwhile
    /// ([`StandbyLock`]). Returns false if the instrument is tripped.
    ///
    /// Finding a value takes some milliseconds; all other tasks have a higher priority and run
    /// meanwhile.
    pub fn set_up(
        &mut self,
        busy: &StandbyLock,
        telemetry_requests: &TelemetryRequests,
        wake_control: impl Fn(),
    ) -> bool {
        if !busy.is_standby() {
            return false;
        }
        self.server.begin();
        if !self.server.is_well() {
            defmt::warn!("the settings in flash are corrupt, or the flash holds other data");
        }
        // `Clear` leaves the fingerprint, since a host sends it, too.
        for command in [Command::Clear, Command::Fingerprint { resistance_ohm: [0.0; MOST_ELEMENTS] }] {
            if self.send(command, &wake_control).is_err() {
                return false;
            }
        }
        loop {
            CHECK_INS.check_in(Member::Settings);
            match self.server.next_piece() {
                Next::Apply(key, Setting::Command(command)) => match self.send(command, &wake_control) {
                    Ok(()) => {}
                    Err(Refusal::Tripped(_)) => return false,
                    Err(refusal) => {
                        let why = Unusable::Refused(refusal);
                        self.server.was_refused(key, why);
                        defmt::warn!("setting {=u16:#x} is not used: {=str}", key, why.name());
                    }
                },
                Next::Apply(_, Setting::TelemetryEvery(every)) => telemetry_requests.thin(every),
                Next::Apply(_, Setting::Name(_) | Setting::Tested(_)) => {}
                Next::Skip(key, why) => defmt::warn!("setting {=u16:#x} is not used: {=str}", key, why.name()),
                Next::Done { taken, left } => {
                    if taken > 0 || left > 0 {
                        defmt::info!("{=u16} settings applied, {=u16} not used", taken, left);
                        // Without a pulse nothing heats; without an element nothing is tested.
                        let plan = SelfTestPlan { pulse_s: None, unix_s: None };
                        self.send(Command::SelfTest(plan), &wake_control).ok();
                    }
                    return true;
                }
            }
        }
    }

    /// Sends a command to the control task, which has a higher priority and carries it out as soon
    /// as it is woken.
    fn send(&mut self, command: Command, wake_control: &impl Fn()) -> Outcome {
        if queue::put(&mut self.orders, command).is_err() {
            // It has room for one, and commands are sent one at a time.
            return Ok(());
        }
        wake_control();
        // This task is preempted by it within a few instructions. Should the control task be dead,
        // the watchdog ends this loop.
        loop {
            if let Some(outcome) = self.outcomes.dequeue() {
                return outcome;
            }
        }
    }
}

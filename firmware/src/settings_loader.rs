//! The settings loader: sets the instrument up with the stored settings, command by command.

use crate::board::{SettingsFlash, table};
use crate::vitals::CHECK_INS;
use dr_core::Command;
use dr_core::control::{Refusal, SelfTestPlan};
use firmware::check_ins::Member;
use firmware::inbox::{Outcome, TelemetryRequests};
use firmware::queue;
use firmware::settings::{SettingsServer, StandbyLock};
use heapless::spsc::{Consumer, Producer};
use wire::{MOST_ELEMENTS, SettingsRefusal};

/// The settings server with its queues to the control task and back.
pub struct SettingsLoader {
    /// The server of the stored settings.
    pub server: SettingsServer<SettingsFlash>,
    /// To the control task.
    pub orders: Producer<'static, Command>,
    /// Their results.
    pub outcomes: Consumer<'static, Outcome>,
    /// Taken while it sets up.
    pub lock: &'static StandbyLock,
    /// Samples that the host gets.
    pub telemetry: &'static TelemetryRequests,
}

impl SettingsLoader {
    /// Clears the instrument and applies the stored settings, all of them or nothing. The host's
    /// commands wait meanwhile ([`StandbyLock`]). Returns false if the instrument is tripped.
    pub fn set_up(&mut self) -> bool {
        match self.clear().and_then(|()| self.apply()) {
            Ok(()) => {}
            Err(SettingsRefusal::NotInStandby) => return false,
            Err(why) => {
                // No half head.
                self.clear().ok();
                let why = if let SettingsRefusal::Unusable(why) = why { why.name() } else { "damaged, or other data" };
                defmt::warn!("the settings in flash are not used: {=str}", why);
                return true;
            }
        }
        let applied = self.server.applied();
        if applied > 0 {
            defmt::info!("settings with {=u16} commands applied", applied);
            // Without a pulse nothing heats; without an element nothing is tested.
            let plan = SelfTestPlan { pulse_s: None, unix_s: None };
            self.send(Command::SelfTest(plan)).ok();
        }
        true
    }

    fn clear(&mut self) -> Result<(), SettingsRefusal> {
        // `Clear` leaves the fingerprint, since a host sends it, too.
        let commands = [Command::Clear, Command::Fingerprint { resistance_ohm: [0.0; MOST_ELEMENTS] }];
        let cleared = self.lock.is_standby() && commands.map(|command| self.send(command)) == [Ok(()); 2];
        if cleared { Ok(()) } else { Err(SettingsRefusal::NotInStandby) }
    }

    /// Reading a command takes some milliseconds; all other tasks have a higher priority and run
    /// meanwhile.
    fn apply(&mut self) -> Result<(), SettingsRefusal> {
        let preface = self.server.begin()?;
        while let Some(command) = self.server.next_command()? {
            CHECK_INS.check_in(Member::Settings);
            self.send(command).map_err(|refusal| match refusal {
                Refusal::Tripped(_) => SettingsRefusal::NotInStandby,
                refusal => self.server.was_refused(refusal),
            })?;
        }
        if preface != Default::default() {
            self.telemetry.thin(preface.telemetry_every);
        }
        Ok(())
    }

    /// Sends a command to the control task. Control or the estimator replies; both have a higher
    /// priority and run as soon as they are woken.
    fn send(&mut self, command: Command) -> Outcome {
        if queue::put(&mut self.orders, command).is_err() {
            // It has room for one, and commands are sent one at a time.
            return Ok(());
        }
        rtic::pend(table::CONTROL);
        // This task is preempted by them within a few instructions. Should one of them be dead, the
        // watchdog ends this loop.
        loop {
            if let Some(outcome) = self.outcomes.dequeue() {
                return outcome;
            }
        }
    }
}

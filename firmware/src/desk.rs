//! The clerk's desk: what the settings' clerk needs to set the instrument up, one piece after the other.

use crate::board::SettingsFlash;
use core::future::poll_fn;
use core::task::Poll;
use dr_core::control::{Command, Refusal};
use firmware::inbox::Questions;
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
    /// Others of this priority have their turn between the pieces, the health task too: finding a value takes some milliseconds.
    pub async fn set_up(&mut self, busy: &Busy, questions: &Questions, wake_control: impl Fn()) -> bool {
        if !busy.is_standby() {
            return false;
        }
        self.clerk.begin();
        if !self.clerk.is_well() {
            defmt::warn!("the flash of the settings holds something else, or has rotted");
        }
        if self.tell(Command::Clear, &wake_control).await.is_err() {
            return false;
        }
        loop {
            match self.clerk.next_piece() {
                Next::Tell(key, Setting::Command(command)) => match self.tell(command, &wake_control).await {
                    Ok(()) => {}
                    Err(Refusal::Tripped(_)) => return false,
                    Err(refusal) => {
                        let why = Unusable::Refused(refusal);
                        self.clerk.was_refused(key, why);
                        defmt::warn!("setting {=u16:#x} is not used: {=str}", key, why.name());
                    }
                },
                Next::Tell(_, Setting::TelemetryEvery(every)) => questions.thin(every),
                Next::Tell(_, Setting::Name(_)) => {}
                Next::Leave(key, why) => defmt::warn!("setting {=u16:#x} is not used: {=str}", key, why.name()),
                Next::Done { taken, left } => {
                    if taken > 0 || left > 0 {
                        defmt::info!("set up by {=u16} settings, {=u16} are not used", taken, left);
                    }
                    return true;
                }
            }
            pause().await;
        }
    }

    /// Tells the control task something, which is of higher priority: it is through with it as soon as it is woken.
    async fn tell(&mut self, command: Command, wake_control: &impl Fn()) -> Outcome {
        if self.orders.enqueue(command).is_err() {
            // It has room for one, and one at a time is told.
            return Ok(());
        }
        wake_control();
        loop {
            if let Some(outcome) = self.outcomes.dequeue() {
                return outcome;
            }
            pause().await;
        }
    }
}

/// Lets others of the same priority have their turn.
async fn pause() {
    let mut paused = false;
    poll_fn(|context| {
        if paused {
            return Poll::Ready(());
        }
        paused = true;
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await;
}

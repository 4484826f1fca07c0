//! Commands of a host to an instrument, and its replies.
//!
//! Commands set an instrument up in `Standby`; drives may be changed while it runs. Order of a
//! set-up: `Clear`, `SamplePeriod`, `Guard`, `Observe`, `Element` and `Model` for each element,
//! `Drive` for each element, `Arm`, `Start`.

use crate::control::drive::Drive;
use crate::control::fingerprint::Fingerprint;
use crate::control::guard::GuardConfig;
use crate::control::self_test::plan::SelfTestPlan;
use crate::control::state::ElementConfig;
use crate::control::transducer::CapacitorConfig;
use crate::model::SelfHeatingConfig;
use crate::wind::anemometer::command::WindCommand;

/// A command.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Command {
    /// Forget every element, model and drive. In standby.
    Clear,
    /// Length of a tick. In standby; models have to be loaded again.
    SamplePeriod {
        /// Seconds, 0.0001 … 10.
        sample_period_s: f32,
    },
    /// Limits of the guard, in ticks. In standby.
    Guard(GuardConfig),
    /// Wiring and limits of an element. In standby.
    Element {
        /// Number of the element, from 0. Those before it have to be configured already.
        element: u8,
        /// Its wiring and limits.
        config: ElementConfig,
    },
    /// The diffusive model of an element. In standby, after the sample period.
    Model {
        /// Number of the element, from 0.
        element: u8,
        /// Mesh, symbol and reference.
        model: SelfHeatingConfig,
    },
    /// Operating mode of an element. At any time except when tripped; takes effect with the next
    /// tick.
    Drive {
        /// Number of the element, from 0.
        element: u8,
        /// Drive.
        drive: Drive,
    },
    /// From standby to running: drives, models and the tick counter start afresh.
    Start,
    /// From running to standby, heaters low.
    Stop,
    /// From tripped to standby.
    Acknowledge,
    /// Switches the observers on or off: they hold the models on the measured temperatures and
    /// report the equivalent control with each tick. In standby; off after `Clear`.
    Observe {
        /// On or off.
        on: bool,
    },
    /// A command to the anemometer.
    Wind(WindCommand),
    /// Allows commands that can heat for a limited time: `Start`, and while running a drive that
    /// heats. After the sample period, at any time except when tripped. `Start`, `Stop`, `Disarm`,
    /// `Clear`, `SamplePeriod` and a trip end it at once.
    Arm {
        /// Seconds, up to [`LONGEST_ARMED_S`]; counted in ticks.
        window_s: f32,
    },
    /// Ends the time of `Arm`. A run continues.
    Disarm,
    /// Starts a self-test ([`self_test`](crate::control::self_test)). With a pulse: in standby,
    /// armed; the length of the test replaces the armed time. Without: in standby or tripped, and
    /// the state stays. Any other command that changes something ends it.
    SelfTest(SelfTestPlan),
    /// Longest time without a frame of the host while heating; longer trips. In standby;
    /// [`HOST_TIMEOUT_S`] after `Clear`.
    HostTimeout {
        /// Seconds, up to [`LONGEST_HOST_TIMEOUT_S`], counted in ticks. 0: for ever, for an
        /// instrument that nobody attends.
        timeout_s: f32,
    },
    /// Fingerprint of the head, without which any head will do. In standby; stays after `Clear`.
    Fingerprint {
        /// Resistance of each element at the low level, Ω; 0 for one that is not compared.
        resistance_ohm: Fingerprint,
    },
    /// Curve, symbols and limits of a MEMS capacitor, which takes the place of an element and the
    /// one after it ([`transducer`](crate::control::transducer)). In standby.
    Capacitor {
        /// Number of the element, from 0. Those before it have to be configured already.
        element: u8,
        /// Configuration of the capacitor.
        config: CapacitorConfig,
    },
}

/// A host that sends nothing for so long is gone, if nothing else has been said, s. Shorter than
/// anything that a lost cable could heat up unseen; longer than a slow disk holds up a host.
pub const HOST_TIMEOUT_S: f32 = 60.0;

/// Longest timeout of a host, s: a day.
pub const LONGEST_HOST_TIMEOUT_S: f32 = 86_400.0;

/// Longest time for which an instrument can be armed, s.
pub const LONGEST_ARMED_S: f32 = 600.0;

/// Reply to a command that was carried out.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reply {
    /// Done.
    Done,
    /// Started, with this many set-points judged reachable by a model, and this many without a
    /// model to judge them.
    Started {
        /// Judged reachable.
        judged: u8,
        /// Not judged.
        unjudged: u8,
    },
}

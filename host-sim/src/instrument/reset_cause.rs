//! Why a board has started, in words.

use wire::{CrashKind, Identity, ResetCause};

/// Why a board has started, as a clause.
pub fn why_it_started(identity: &Identity) -> String {
    let crash = identity.crash.as_ref().map(|crash| match crash.kind {
        CrashKind::Panic => format!("its firmware panicked at {}:{}", crash.file, crash.at),
        CrashKind::Fault => format!("its processor faulted at {:#010x}", crash.at),
    });
    let reset = match identity.reset {
        ResetCause::PowerOn => "its supply was gone",
        ResetCause::Pin => "somebody reset it",
        ResetCause::Software => "its firmware ran into an error",
        ResetCause::Watchdog => "a task of its firmware hung",
        ResetCause::BrownOut => "its supply dipped",
        ResetCause::Unknown => "it does not know why",
    };
    crash.unwrap_or_else(|| reset.to_owned())
}

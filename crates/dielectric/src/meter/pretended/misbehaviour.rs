//! What can go wrong with a meter, on purpose.

/// When a pretended meter misbehaves, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misbehaviour {
    /// Number of the command, counted from 0 over all connections.
    pub at: usize,
    /// At all commands from there, rather than at this one.
    pub is_lasting: bool,
    /// What it does.
    pub kind: MisbehaviourKind,
}

impl Misbehaviour {
    /// What it does at a command.
    pub(super) fn kind_at(self, command: usize) -> Option<MisbehaviourKind> {
        let is_now = command == self.at || self.is_lasting && command > self.at;
        is_now.then_some(self.kind)
    }
}

/// What a pretended meter does instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MisbehaviourKind {
    /// Closes the connection and does nothing; if that lasts, new ones too.
    Disconnect,
    /// Obeys, and sends a line of rubbish in place of an answer, also where none is due.
    Garbage,
    /// Obeys, and sends the first half of an answer.
    HalfAnswer,
    /// Neither obeys nor answers.
    Silence,
    /// Has no reading.
    Overload,
    /// Puts an error into its queue, and neither obeys nor answers.
    Refusal,
    /// Obeys, and reads a bias back that it has not.
    WrongBias,
}

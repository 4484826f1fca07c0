//! Options of identification: structure, mesh, initial state, signs, gas. The default chooses
//! everything by cross-validation.

use super::drift::DriftGiven;
use super::residuals::FitRow;
use crate::model::Structure;

/// Options of one identification.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct IdentifyOptions {
    /// `symbol` by default.
    pub structure: Option<Structure>,
    /// Fixed parts of the model; all others are chosen by cross-validation.
    pub constraints: Constraints,
    /// Which resistances may not be negative.
    pub signs: Signs,
    /// Temperature of the gas for structure `conductance`.
    pub gas: GasGiven,
    /// The class to which ΔG = 0 belongs; by default the one with the least conductance.
    pub reference: Option<String>,
    /// Number of rates an output that are fitted to the record, starting from the mesh solution.
    pub free_poles: Option<usize>,
    /// Pairs i → j and j → i have the same resistances.
    pub tie: bool,
    /// Whether the offset moves.
    pub drift: DriftGiven,
    /// Losses that grow with temperature.
    pub losses: Losses,
    /// Whether the gas column is a surrounding that outputs of structure `symbol` follow.
    pub follow_ambient: bool,
}

impl IdentifyOptions {
    /// Whether the user requests an initial state that a record may contradict, and there is a
    /// choice to make.
    pub fn asks_for_an_initial_state(&self) -> bool {
        let given = &self.constraints;
        let is_state = matches!(given.initial_state, Some(InitialState::Rest | InitialState::Settled));
        is_state && !given.mesh_is_fixed() && self.free_poles.is_none() && !self.tie
    }

    /// Why no drift is searched in a record of so many classes, if none is.
    pub fn no_drift_for(&self, classes: usize) -> Option<&'static str> {
        let (given, is_auto) = (&self.constraints, self.drift == DriftGiven::Auto);
        let reasons = [
            (self.tie, "with tied pairs"),
            (self.free_poles.is_some(), "with free poles"),
            (self.structure == Some(Structure::Conductance), "with structure `conductance`"),
            // What one spectrum a class leaves where winds change looks like a drift, and so does
            // what rates leave that were given.
            (is_auto && classes > 1, "by itself with several event classes"),
            (is_auto && given.has_mesh(), "by itself on a mesh that is given"),
        ];
        reasons.into_iter().find_map(|(holds, reason)| holds.then_some(reason))
    }

    /// The same with any initial state.
    #[must_use]
    pub fn with_any_initial_state(&self) -> Self {
        let constraints = Constraints { initial_state: None, ..self.constraints.clone() };
        Self { constraints, ..self.clone() }
    }
}

/// Whether losses may grow with temperature: w = u − g (T − T_0)².
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Losses {
    /// The model is linear.
    #[default]
    None,
    /// Every element has a g ≥ 0, which is estimated.
    Growing,
    /// As `Growing` where the record leaves no doubt, else as `None`.
    Auto,
}

/// Where the temperature of the gas comes from.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum GasGiven {
    /// It is estimated.
    #[default]
    Unknown,
    /// The same all through, °C.
    ConstantC(f64),
    /// The record's gas column.
    Column,
}

/// Parts of a model that the user fixes; `None` is chosen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Constraints {
    /// Number of rates.
    pub order: Option<usize>,
    /// First and last rate.
    pub edges_rad_s: Option<(f64, f64)>,
    /// Ridge on columns of unit norm.
    pub ridge: Option<f64>,
    /// The state at the first row.
    pub initial_state: Option<InitialState>,
    /// Whether the output may follow its input at once.
    pub feed_through: Option<bool>,
    /// Dead time, in samples.
    pub delay: Option<usize>,
}

impl Constraints {
    /// Whether the user gives the mesh, or a part of it.
    pub fn has_mesh(&self) -> bool {
        self.order.is_some() || self.edges_rad_s.is_some()
    }

    /// Whether the user knows the mesh, so that least squares is left as plain as the record
    /// allows.
    pub fn mesh_is_fixed(&self) -> bool {
        self.order.is_some() && self.edges_rad_s.is_some()
    }
}

/// The state of the body at the first row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InitialState {
    /// Nothing stored: all states zero.
    Rest,
    /// As if the first row's inputs had been held for ever.
    Settled,
    /// Anything: one more parameter a rate.
    Free,
}

impl InitialState {
    /// As in a model file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Settled => "settled",
            Self::Free => "free",
        }
    }
}

/// Which resistances may not be negative.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Signs {
    /// As many as cross-validation allows.
    #[default]
    Choose,
    /// None is held.
    Any,
    /// Those of the banks of these inputs (by pair: input and output).
    Positive(Vec<(usize, usize)>),
    /// All are held.
    AllPositive,
}

impl Signs {
    /// Whether the user holds the resistances of a pair at or above zero.
    pub fn asks(&self, input: usize, output: usize) -> bool {
        match self {
            Self::Choose | Self::Any => false,
            Self::Positive(pairs) => pairs.contains(&(input, output)),
            Self::AllPositive => true,
        }
    }
}

/// Called with the present step, rows done, and rows in all.
pub type Progress<'a> = dyn FnMut(&'static str, u64, u64) + 'a;

/// Called for every row with measured and predicted outputs, for whoever draws them.
pub type FitObserver<'a> = dyn FnMut(&FitRow<'_>) + 'a;

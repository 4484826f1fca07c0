//! The body of a head: what its simulation is made of, as a table `[body]` of its file.
//!
//! ```text
//!   gas ── surface … node ── link ── node … rod ══ support at a fixed temperature
//!                     │
//!                  element: heat goes in here
//! ```
//!
//! | key | holds |
//! |---|---|
//! | `nodes` | lumps of one temperature, with their heat capacity |
//! | `links` | ways between nodes: a conductance, a contact, a gap of gas, or a rod in cells, to a node or the `support` |
//! | `elements` | the node of every element whose name is not that of a node |
//! | `[[body.convection]]` | a [correlation](Correlation), and the surfaces that lose heat by it |
//! | `gas` | the gas that the head is meant for, where a command is given none |
//! | `tolerances` | how much a specimen differs from the file |
//! | `unknown` | numbers that nobody has published, and their ranges |
//!
//! A name may stand for several: `chip[1-4]` is four of them, `core1,core2` two. Links between
//! several join the first with the first and so on, or each with one.
//!
//! | file | what |
//! |---|---|
//! | [`table`] | the table as it is written |
//! | [`correlation`] | what the wind takes, by name |
//! | [`names`] | names that stand for several |
//! | [`parts`] | what it consists of: nodes, links, surfaces by number |
//! | [`checked`] | the same with every name resolved and every number found possible |
//! | [`unknown`] | numbers that nobody has published |
//! | `reader`, `convection` | how it is read: nodes, links and elements; laws and surfaces |
//! | `ways` | which nodes links join |

pub mod checked;
mod convection;
pub mod correlation;
pub mod names;
pub mod parts;
mod reader;
pub mod table;
pub mod unknown;
mod ways;

pub use checked::Body;
pub use correlation::{BoomShape, Correlation, CylinderShape, KingLaw, NusseltGrid, PlateShape, WireLaw, WireShape};
pub use parts::{BodyElement, BodyLink, BodyNode, BodySurface, Convection, UnknownNumber};

#[cfg(test)]
mod tests;

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
//! | [`table`] | the table as it is written, with the laws that the wind takes |
//! | [`parts`] | what it consists of: nodes, links, surfaces by number |
//! | [`checked`] | the same with every name resolved and every number found possible |
//! | `reader`, `convection` | how it is read: nodes, links and elements; laws and surfaces |

pub mod checked;
mod convection;
pub mod parts;
mod reader;
pub mod table;

pub use checked::Body;
pub use parts::{BodyElement, BodyLink, BodyNode, BodySurface, Convection};
pub use table::{
    BoomShape, Correlation, CylinderShape, KingLaw, NusseltGrid, PlateShape, UnknownNumber, WireLaw, WireShape,
};

#[cfg(test)]
mod tests;

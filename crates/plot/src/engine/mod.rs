//! The one engine of all pictures: a figure is a column of rows of charts, which are laid out and
//! painted to SVG here.

pub mod axis;
pub mod chart;
pub mod colour;
pub mod extent;
pub mod head;
pub mod layout;
pub mod line_ends;
pub mod page;
pub mod paint;
pub mod paint_axes;
pub mod pen;
pub mod reduce;
pub mod scaled;
pub mod selection;
pub mod svg;
pub mod trace;
pub mod type_face;
pub mod words;

//! Plots of the benchmarks as SVG: a grid of panels with logarithmic axes, a legend, and one curve per series.

mod axis;
mod page;

pub use axis::Log;
pub use page::{FAINT, INK, Page, Panel, colour};

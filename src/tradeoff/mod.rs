//! tradeoff: how much error a method, a plan, an encoding or a tone map has, and what it costs, charted against each other.
//!
//! [`methods`] says what is tried and how hard, [`child`] runs a program and looks at its time and memory, [`reference`] makes and keeps
//! what is compared with, [`judge`] compares, [`scene`] does all that for one scene, [`filters`] for what comes after a renderer,
//! [`page`] and [`picture`] show it.

mod chart;
mod child;
mod command;
mod filters;
mod judge;
mod methods;
mod page;
mod picture;
mod reference;
mod scene;
mod table;

pub use chart::frontier;
pub use command::{Tradeoff, command};

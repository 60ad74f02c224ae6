//! Media and subsurface scattering: laws that every density and phase function keeps, four solvers against each other and against
//! closed forms, and the places where methods fail.

#[path = "media/densities.rs"]
mod densities;
#[path = "media/keys.rs"]
mod keys;
#[path = "media/limits.rs"]
mod limits;
#[path = "media/look.rs"]
mod look;
#[path = "media/phases.rs"]
mod phases;
#[path = "media/probe.rs"]
mod probe;
#[path = "media/solvers.rs"]
mod solvers;

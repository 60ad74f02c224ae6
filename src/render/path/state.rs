//! A path on its way: where it is, what it carries, and what it has to know beside in scenes with effects.

use glam::Vec3A;

use crate::medium::Inside;
use crate::render::lanes::Lanes;
use crate::render::media::Lots;

/// What a path knows beside; nothing where there are no effects.
pub(super) trait Beside: Copy {
    /// There are.
    const EFFECTS: bool;

    /// At its start.
    fn new(nm: Option<f32>, from: Vec3A, frame: Vec3A, inside: impl FnOnce() -> (Inside, Lots)) -> Self;

    /// What it knows.
    fn known(&mut self) -> Option<&mut Known>;
}

impl Beside for () {
    const EFFECTS: bool = false;

    fn new(_: Option<f32>, _: Vec3A, _: Vec3A, _: impl FnOnce() -> (Inside, Lots)) {}

    fn known(&mut self) -> Option<&mut Known> {
        None
    }
}

impl Beside for Known {
    const EFFECTS: bool = true;

    fn new(nm: Option<f32>, from: Vec3A, frame: Vec3A, inside: impl FnOnce() -> (Inside, Lots)) -> Known {
        let (inside, lots) = inside();
        Known { nm, inside, from, lots, ways: 0, scatterings: 0, frame }
    }

    fn known(&mut self) -> Option<&mut Known> {
        Some(self)
    }
}

/// What a path knows besides where there are effects.
#[derive(Clone, Copy)]
pub(super) struct Known {
    /// The only wavelength that says where it goes, nm; all of them do until it splits.
    pub nm: Option<f32>,
    /// The bodies that it is in.
    pub inside: Inside,
    /// Where its way began, on the surface itself.
    pub from: Vec3A,
    /// For null collisions.
    pub lots: Lots,
    /// Ways through media so far.
    pub ways: u32,
    /// Bounces that were none of a surface.
    pub scatterings: u32,
    /// Axis of the Stokes vectors of light that comes against its way.
    pub frame: Vec3A,
}

/// A path on its way.
#[derive(Clone)]
pub(super) struct State<E> {
    pub origin: Vec3A,
    pub direction: Vec3A,
    pub way: Way,
    pub bounce: u32,
    /// Factor of all wavelengths, kept apart: what is the same for all of them is multiplied once.
    pub weight: f32,
    /// What it would carry on white surfaces.
    pub share: f32,
    /// What the tints have left of each eighth of the wavelengths.
    pub outline: Lanes<1>,
    pub beside: E,
}

/// How a path came by its direction.
#[derive(Clone, Copy)]
pub(super) enum Way {
    /// From the eye or a mirror: no lamp was aimed at.
    Straight,
    /// By a lobe with a density, 1/sr, where lamps were aimed at too.
    Lobe { pdf: f32, from: Vec3A, normal: Vec3A },
    /// Scattered: lamps that lie there have been found from the way before.
    Scattered,
}
